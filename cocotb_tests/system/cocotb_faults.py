# SPDX-License-Identifier: Apache-2.0
"""Faults of the hardware, made from outside on named nets and registers. §4.3.6, §5.3

A net is forced, a register held. lib/visible.vlt lists the nets for Verilator.
"""

from cocotb.handle import Force, Release

from cocotb_tests.adaptor.cocotb_interrupts import machine as interrupts
from cocotb_tests.adaptor.cocotb_interrupts import panic_edge, panic_low, sclock_edge, sclock_low
from cocotb_tests.card.host import Rack
from cocotb_tests.lib.req import test
from cocotb_tests.lib.tb import (
    ADC_LO,
    ARMED,
    BASE,
    C_DONE,
    LATCH_ALL,
    PANIC_IRQ,
    PCCSR,
    PORT_C,
    SCLOCK_IRQ,
    volts_of,
)
from cocotb_tests.system.cocotb_safety import BEAT_US, panic
from cocotb_tests.system.cocotb_safety import machine as safety
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL


@test("INT-1")
async def lost_interrupt_fault(dut):
    """SCLOCK runs, its edges do not reach the latch; PANIC's do."""
    tb = await interrupts(dut)
    rise = dut.u_adaptor.u_core.u_pccsr.sclock_rise
    rise.value = Force(0)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    await sclock_edge(tb)
    await panic_edge(tb)
    assert await tb.rd(PCCSR) == ARMED | PANIC_IRQ | BASE
    await panic_low(tb)
    rise.value = Release()
    await sclock_low(tb)
    await sclock_edge(tb)
    assert await tb.rd(PCCSR) == ARMED | SCLOCK_IRQ | PANIC_IRQ | BASE


@test("PAN-1", "JMP-1")
async def panic_line_open(dut):
    """A card whose IRQ jumper is off panics unheard."""
    tb = await safety(dut, 0x0C)  # card 1 alone
    dut.u_cards.card_irq.value = Force(0)
    await tb.us(BEAT_US + 20)
    assert not panic(tb)
    assert await tb.crd(1, PORT_C) & 5 == 0
    dut.u_cards.card_irq.value = Release()
    await tb.clocks(5)
    assert panic(tb)


@test("LAT-1", "JMP-1")
async def sclock_line_open(dut):
    """A card whose DRQ jumper is off never latches; its neighbours do."""
    tb = await Rack(dut).start()
    tb.stuck(dut.u_cards.g_card[1].u_card.u_latch.sclock_q, 1)  # so that no edge is seen
    tb.inputs([0x1000] * 6)
    await tb.pulse()
    await tb.us(1)
    assert [await tb.crd(c, PORT_C) & C_DONE for c in range(3)] == [0, C_DONE, 0]


@test("DAC-1", "ADC-1")
async def stuck_converters(dut):
    """A D/A that is stuck shows it at the output; a stuck A/D converts and keeps its code."""
    tb = await Rack(dut).start()
    axis = dut.u_cards.g_card[1].u_card.g_axis[0].u_axis
    stuck = tb.stuck(axis.u_dac.rank2_q, 0x901)
    for n in (2, 3):
        await tb.dac(n, 0x700)
    assert tb.volts(2) == volts_of(0x901) and tb.volts(3) == volts_of(0x700)
    stuck.cancel()
    await tb.dac(2, 0x700)
    assert tb.volts(2) == volts_of(0x700)
    tb.inputs([0x2000] * 6)
    tb.stuck(axis.u_adc.next_q, 0x900)
    await tb.cwr(0, LATCH_ALL, 0)
    await tb.converted()
    assert [await tb.adc(n) for n in range(4)] == [0xA00, 0xA00, 0x900, 0xA00]
    assert await tb.crd(1, ADC_LO) == 0
