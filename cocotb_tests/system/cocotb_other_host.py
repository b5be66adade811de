# SPDX-License-Identifier: Apache-2.0
"""The whole machine at the host port of its core. §4.2.1"""

from cocotb_tests.adaptor.cocotb_host_port import HostPort
from cocotb_tests.lib.req import test
from cocotb_tests.lib.tb import ARMED, BASE, PCCSR, PORT_A, QUAD, SCLOCK_IRQ, Tb
from cocotb_tests.system.machine import SINGLE

TOPLEVEL = "mmcs_core"
PARAMETERS = SINGLE


class OtherHost(HostPort):
    async def start(self):
        await Tb.start(self)
        self.dut.axis_enable_i.value = 3
        self.enc = self.encoders(2)
        await self.wr(PCCSR, BASE)
        await self.setup(0, 0x03)
        return self


@test("ADP-1")
async def every_register_by_the_port(dut):
    """Card and adaptor as from VME: all patterns of a register, an encoder, a D/A."""
    tb = await OtherHost(dut).start()
    for value in (*(1 << n for n in range(8)), 0x00, 0xFF, QUAD):
        await tb.cwr(0, PORT_A, value)
        assert await tb.crd(0, PORT_A) == value
    await tb.preset(0, 0)
    await tb.enc[0].move(300, 500)
    await tb.us(1)
    assert await tb.encoder(0) == 300
    await tb.us(30)  # the relay
    await tb.dac(0, 0xC00)
    assert int(dut.drive_v_o.value) & 0xFFFF == 0x4000
    for card in range(1, 16):
        assert await tb.crd(card, PORT_A) == 0xFF, "no such card"


@test("ADP-1")
async def interrupts_and_their_vector(dut):
    """An edge of SCLOCK asks for an interrupt; a front gets the vector that was written."""
    tb = await OtherHost(dut).start()
    assert int(dut.vector_o.value) == 0x0F
    await tb.wr(0x441, 0xA5)
    await tb.us(1)
    assert int(dut.vector_o.value) == 0xA5
    await tb.wr(0x407, 0x70)  # SCLOCK low
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    await tb.us(1)
    assert not int(dut.irq_req_o.value)
    await tb.wr(0x407, 0x74)  # and high: an edge
    await tb.us(1)
    assert int(dut.irq_req_o.value)
    assert await tb.rd(PCCSR) == ARMED | SCLOCK_IRQ | BASE
    await tb.wr(PCCSR, BASE)
    await tb.us(1)
    assert not int(dut.irq_req_o.value)
