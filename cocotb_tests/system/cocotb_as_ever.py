# SPDX-License-Identifier: Apache-2.0
"""Random accesses while every other input moves: what the machine answers and drives is as ever."""

import zlib

import cocotb
from cocotb.triggers import FallingEdge

from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import BASE, PCCSR, PIT, PPI_CONTROL, PPI_SETUP, QUAD, VECTOR, Machine, dip
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
# Of each part's accesses, and the outputs at each clock; who means to change what the RTL does puts
# in what the failure shows.
AS_EVER = "d302 77b3 da8b caac d773 a2c4 8fcf b2d0 4692 afa2 a596 caa4"
PARTS, ACCESSES = 12, 120
OUTPUTS = """
    vme_d_o vme_d_oe_o vme_dtack_no vme_iackout_no vme_irq_no brake_release_o alive_o panic_o
    sclock_o led_irq_o drive_v_o card_leds_o pcx_a_o pcx_d_o pcx_d_oe_o pcx_ior_no pcx_iow_no
    pcx_aen_o pcx_clk_en_o pcx_reset_drv_o pcx_drq_o"""


class Moving(Machine):
    """By seed of the test alone: it is the same in every run."""

    def move(self):
        dut, chance = self.dut, self.random
        dut.enc_a_i.value, dut.enc_b_i.value = chance.randrange(64), chance.randrange(64)
        dut.enc_i_i.value = chance.choice([0, 0, chance.randrange(64)])
        dut.adc_v_i.value = chance.getrandbits(96)
        dut.axis_enable_i.value = chance.choice([63, 63, 63, chance.randrange(64)])
        for pin in (dut.estop_closed_i, dut.cable_ok_i, dut.pc_power_i):
            pin.value = chance.random() < 0.985
        dut.dip_i.value = dip(*chance.choice([(0, 1, 2)] * 9 + [(0, 1, 1), (2, 5, 0)]))
        dut.pcx_irq_i.value = chance.choice([0, 0, chance.randrange(32)])
        dut.pcx_d_i.value, dut.pcx_d_oe_i.value = chance.randrange(256), chance.random() < 0.02
        dut.pcx_wait_i.value = chance.random() < 0.1

    async def access(self):
        """Of a card, an own register, the timers, or of what is nobody's."""
        chance, value = self.random, self.random.randrange(256)
        card = self.creg(chance.choice([0, 1, 2, 2, 7]), chance.randrange(32))
        offset = chance.choice([card] * 6 + [PIT + 2 * chance.randrange(4), PCCSR, VECTOR, 0x411])
        if offset == PCCSR:
            value = chance.choice([BASE | value & 7, BASE | 7, value])
        if offset & 63 == self.creg(0, PPI_CONTROL):
            value = chance.choice([PPI_SETUP, PPI_SETUP, value])
        if chance.random() < 0.5:
            return offset, await self.rd(offset)
        return offset, value, await self.wr(offset, value)


@tests_on(Moving)("API-1", "CRD-1", "ADP-1", setup=True, beat=True)
async def random_accesses_while_all_inputs_move(tb):
    tb.random.seed(1989)
    clocks, parts = [], []
    pins = [getattr(tb.dut, name) for name in OUTPUTS.split()]

    async def look():
        while True:
            await FallingEdge(tb.dut.clk_i)
            clocks.append([str(pin.value) for pin in pins])

    task = cocotb.start_soon(look())
    for _ in range(PARTS):
        seen = []
        for _ in range(ACCESSES):
            if tb.random.random() < 0.4:
                tb.move()
            seen.append(await tb.access())
            await tb.clocks(tb.random.choice([0, 1, 1, 2, 5, 40]))
        if parts:
            await tb.wr(PCCSR, BASE)
        await tb.setup(len(parts) % 3, QUAD)
        parts.append(f"{zlib.crc32(f'{seen} {clocks}'.encode()) & 0xFFFF:04x}")
        clocks.clear()
    task.cancel()
    assert " ".join(parts) == AS_EVER
