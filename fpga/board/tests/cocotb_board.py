# SPDX-License-Identifier: Apache-2.0
"""The card on a board: a serial line for a host, converters on SPI, pins for all else. §5"""

import cocotb
from cocotbext.mmcs import Pins
from cocotbext.quadrature import QuadratureSource

from cocotb_tests.lib.tb import (
    ADC_HI,
    ADC_LO,
    BASE,
    LATCH,
    PCCSR,
    PORT_A,
    PORT_B,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    Machine,
    Tb,
)
from fpga.board.tests.converters import Dac8568, Mcp3208, SerialHost

CLK_HZ, BAUD = 24_000_000, 1_000_000
CARD = [Machine.creg(0, n) for n in range(32)]
FORGET_US = 1100
SLOTS_US = 140  # two joints, twice


class Board(Tb):
    async def begin(self):
        self.clk_hz = CLK_HZ
        self.period = round(1e12 / CLK_HZ / 2) * 2
        dut = self.dut
        self.pc = SerialHost(dut, BAUD)
        self.adc = Mcp3208(dut, [0x800] * 8)
        self.dac = Dac8568(dut)
        self.encoder = QuadratureSource(*map(Pins, (dut.enc_a, dut.enc_b, dut.enc_i)), 0)
        dut.estop_n.value = dut.enable_n.value = 0
        dut.ftdi_txd.value = 0  # during the reset: half a request
        await self.start()
        dut.ftdi_txd.value = 1
        await self.us(FORGET_US)
        await self.pc.wr(PCCSR, BASE)
        for register, value in ((PPI_CONTROL, PPI_SETUP), (PORT_A, QUAD), (PORT_B, 0x03)):
            await self.pc.wr(CARD[register], value)


@cocotb.test()
async def registers_over_the_serial_line(dut):
    tb = Board(dut)
    await tb.begin()
    for value in (0x00, 0x55, 0xFF, QUAD):
        await tb.pc.wr(CARD[PORT_A], value)
        assert await tb.pc.rd(CARD[PORT_A]) == value
    assert await tb.pc.rd(PCCSR) == BASE
    assert await tb.pc.rd(0x411) == 0xFF


@cocotb.test()
async def converters_and_encoder(dut):
    """Codes out of the D/A and into the A/D, as they are on the SPI; counts of the pins."""
    tb = Board(dut)
    await tb.begin()
    assert tb.dac.reference
    await tb.us(1200)  # the relay
    for joint, code in ((0, 0x000), (1, 0xFFF), (0, 0x9A5), (1, 0x800)):
        await tb.pc.wr(CARD[8 + 2 * joint], code & 0xFF)
        await tb.pc.wr(CARD[9 + 2 * joint], code >> 8)
        await tb.us(SLOTS_US)
        assert tb.dac.value[joint] == code << 4, f"{joint} {tb.dac.value[joint]:04X}"
    for codes in ((0x123, 0xEDC), (0xFFF, 0x000), (0x800, 0x801)):
        tb.adc.codes[:2] = codes
        await tb.us(SLOTS_US)
        await tb.pc.rd(CARD[LATCH])
        await tb.us(40)
        high = await tb.pc.rd(CARD[ADC_HI])
        for joint, code in enumerate(codes):
            low = await tb.pc.rd(CARD[ADC_LO + joint])
            assert (high >> 4 * joint & 15) << 8 | low == code
    assert set(tb.adc.reads) == {0, 1}
    await tb.encoder.move(300, 500)
    await tb.pc.rd(CARD[LATCH])
    high = await tb.pc.rd(CARD[4])
    assert high << 8 | await tb.pc.rd(CARD[5]) == 300


@cocotb.test()
async def the_stop_loop(dut):
    """An open loop is PANIC and brakes; closed, with both D/As written, they are released."""
    tb = Board(dut)
    await tb.begin()
    assert int(dut.panic_o.value) and not int(dut.brake_release.value)
    for register in (8, 9, 10, 11):
        await tb.pc.wr(CARD[register], 0x08 if register % 2 else 0)
    await tb.us(5)
    assert not int(dut.panic_o.value) and int(dut.brake_release.value)
    assert int(dut.beat_o.value) == 3
    dut.estop_n.value = 1
    await tb.us(5)
    assert int(dut.panic_o.value) and not int(dut.brake_release.value)
