# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""Heartbeats, PANIC, brakes, e-stop, cable and power. §2.3.4, §4.3.5, §4.3.8, §5.3.6, §5.4.1"""

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge

from cocotb_tests.lib.req import test, tests_on
from cocotb_tests.lib.tb import (
    ARMED,
    B_DOUBLE,
    BASE,
    C_DONE,
    DAC1,
    HEALTH_CLKS,
    PANIC_IRQ,
    PCCSR,
    PORT_A,
    PORT_B,
    PORT_C,
    QUAD,
    RUN,
    SCLOCK_IRQ,
    VECTOR,
    Machine,
)
from cocotb_tests.system.cocotb_brakes import Source
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
BEAT_US = 400


async def machine(dut, enabled: int = 0x3F) -> Machine:
    """All D/As just written, PANIC low, brakes off."""
    tb = await Machine(dut).start(setup=True)
    dut.axis_enable_i.value = enabled
    await tb.wr(0x407, 0x70)
    await tb.us(25)
    await tb.beat()
    await tb.clocks(HEALTH_CLKS)
    return tb


machine_test = tests_on(machine)


def panic(tb: Machine) -> int:
    level = int(tb.dut.panic_o.value)
    assert int(tb.dut.brake_release_o.value) == 1 - level, "brakes are off only without PANIC"
    return level


async def keep_beating(tb: Machine, axes, us: float) -> None:
    end = tb.now() + us * 1e6
    while tb.now() < end:
        for axis in axes:
            await tb.cwr(axis // 2, DAC1 + 2 * (axis % 2), 0)
        await tb.us(20)


@test("HB-2", "PAN-1")
async def panic_stands_until_every_da_is_written(dut):
    tb = await Machine(dut).start(setup=True)
    for axis in range(6):
        assert panic(tb)
        await tb.cwr(axis // 2, DAC1 + 2 * (axis % 2), 0)
        await tb.clocks(HEALTH_CLKS)
    assert not panic(tb)


@machine_test("HB-2", "PAN-1")
@cocotb.parametrize(axis=[0, 1, 2, 3, 4, 5])
async def any_axis_panics(tb, axis):
    """The wired OR of cards 0 to 2: one axis without D/A writes is enough, and it recovers."""
    assert not panic(tb)
    others = [a for a in range(6) if a != axis]
    await keep_beating(tb, others, BEAT_US + 60)
    assert panic(tb)
    assert [await tb.crd(a // 2, PORT_C) >> 2 * (a % 2) & 1 for a in range(6)] == [
        int(a != axis) for a in range(6)
    ]
    await tb.cwr(axis // 2, DAC1 + 2 * (axis % 2), 0)
    await tb.clocks(HEALTH_CLKS)
    assert not panic(tb)


@machine_test("PAN-1", "INT-1", "DRV-9", enabled=0)
@cocotb.parametrize(what=["estop", "cable", "power", "line"])
async def fail_safe_sources(dut, tb, what):
    """Each asserts PANIC within a few clocks, interrupts once, applies the brakes."""
    await tb.wr(PCCSR, ARMED | PANIC_IRQ | BASE)
    assert not panic(tb)
    source = Source(dut, what)
    source.set(False)
    await tb.clocks(5)
    assert panic(tb)
    assert await tb.rd(PCCSR) == ARMED | PANIC_IRQ | BASE
    assert int(dut.led_irq_o.value) == 1
    await tb.wr(PCCSR, BASE)
    await tb.wr(PCCSR, ARMED | PANIC_IRQ | BASE)
    await tb.us(30)
    assert await tb.rd(PCCSR) == ARMED | BASE, "interrupts once, while the cause stands"
    source.set(True)
    await tb.us(70)
    assert not panic(tb)
    assert await tb.rd(PCCSR) == ARMED | BASE, "its return is no edge"


@machine_test("PAN-1", enabled=0)
async def sources_overlap(dut, tb):
    """PANIC is the OR: a second cause is no second edge."""
    await tb.wr(PCCSR, ARMED | BASE)
    dut.estop_closed_i.value = 0
    await tb.clocks(5)
    await tb.wr(PCCSR, BASE)
    await tb.wr(PCCSR, ARMED | BASE)
    dut.axis_enable_i.value = 0x3F
    await tb.us(BEAT_US + 20)
    assert panic(tb)
    assert await tb.rd(PCCSR) == ARMED | BASE
    dut.estop_closed_i.value = 1
    await tb.us(2)
    assert panic(tb), "a card still panics"
    dut.axis_enable_i.value = 0
    await tb.clocks(HEALTH_CLKS)
    assert not panic(tb)


@machine_test("PAN-3")
async def panic_does_not_cut_the_drives(dut, tb):
    for axis in range(6):
        await tb.dac(axis, 0x400 + axis)
    before = [tb.volts(n) for n in range(6)]
    assert 0 not in before
    dut.estop_closed_i.value = 0
    await tb.us(BEAT_US + 50)
    assert panic(tb)
    assert [tb.volts(n) for n in range(6)] == before


@machine_test("PAN-2", enabled=1)
async def cable_pulled(dut, tb):
    """Cards keep state and D/A values and take no stray latch; reads give 0xFF; VME side lives."""
    await tb.wr(VECTOR, 0x77)
    for card in range(3):
        await tb.cwr(card, PORT_B, RUN | B_DOUBLE)
        await tb.cwr(card, PORT_A, QUAD | card << 3)
    await tb.preset(0, 500)
    await tb.dac(0, 0xA00)
    await tb.crd(0, 0x12)  # the software latch moves it out
    await tb.us(26)
    assert tb.volts(0) == 0x2000
    await tb.dac(0, 0xB00)
    await tb.wr(0x407, 0x74)  # SCLOCK high
    await tb.us(26)
    assert tb.volts(0) == 0x3000
    await tb.dac(0, 0xC00)
    await tb.wr(PCCSR, ARMED | BASE)
    dut.cable_ok_i.value = 0
    await tb.us(1)
    assert await tb.crd(0, PORT_A) == 0xFF
    await tb.cwr(0, PORT_A, 0)  # nobody hears it
    assert await tb.rd(PCCSR) == ARMED | PANIC_IRQ | BASE
    dut.cable_ok_i.value = 1
    await tb.us(1)
    assert tb.volts(0) == 0x3000, "a stray latch moved the D/A"
    for card in range(3):
        assert await tb.crd(card, PORT_A) == QUAD | card << 3
        assert await tb.crd(card, PORT_B) == RUN | B_DOUBLE
        assert await tb.crd(card, PORT_C) & C_DONE
    assert await tb.encoder(0) == 500
    await tb.wr(0x407, 0x70)
    await tb.wr(0x407, 0x74)
    await tb.us(1)
    assert tb.volts(0) == 0x4000, "SCLOCK works again"


@machine_test("PAN-2", "PPI-1", "ANA-1")
async def pc_power_lost_and_back(dut, tb):
    """Cards reset, one-shots low, drives 0, LEDs off; back with a RESET DRV pulse, counts lost, and
    the D/As at 0 V."""
    await tb.wr(VECTOR, 0x77)
    await tb.preset(0, 500)
    await tb.timer(2, 0x1234, 1)
    axes = range(2 * tb.cards)
    for axis in axes:
        await tb.dac(axis, 0xC00 + axis)
    assert [tb.volts(a) for a in axes] == [(0x400 + a) * 16 for a in axes]
    await tb.wr(PCCSR, ARMED | PANIC_IRQ | BASE)
    dut.pc_power_i.value = 0
    await tb.us(1)
    assert not int(dut.drive_v_o.value) and not int(dut.card_leds_o.value) and panic(tb)
    assert await tb.crd(0, PORT_A) == 0xFF
    assert await tb.rd(PCCSR) == ARMED | PANIC_IRQ | BASE
    assert await tb.vme.iack(5) == 0x77
    await tb.us(20)
    dut.pc_power_i.value = 1
    await tb.clocks(6)
    assert int(dut.pcx_reset_drv_o.value) == 1
    back = tb.now()
    await FallingEdge(dut.pcx_reset_drv_o)
    assert 49 <= (tb.now() - back) / 1e6 <= 51, "RESET DRV for 50 us"
    assert panic(tb), "the one-shots are low"
    for card in range(tb.cards):
        await tb.setup(card)
    assert await tb.crd(0, PORT_A) == QUAD
    assert await tb.encoder(0) == 0
    assert await tb.crd(0, PORT_C) & 5 == 0
    for wait_us in (0, 25):  # the relays have let go; then they connect the D/As
        await tb.us(wait_us)
        assert not int(dut.drive_v_o.value)
    await tb.beat()
    await tb.clocks(HEALTH_CLKS)
    assert not panic(tb)
    assert await tb.vme.iack(5) == 0x77, "the latch and the vector stand"


@machine_test("PAN-2", "CSR-1", "PCB-1")
async def sysreset_resets_what_it_should(dut, tb):
    """PCCSR and, by RESET DRV, the cards' PPIs and counters; PIT, vector, one-shots, D/As stand."""
    await tb.wr(VECTOR, 0x5A)
    await tb.timer(2, 0x4321, 1)
    await tb.wr(0x407, 0xE8)  # latch the status of timer 2
    status = await tb.rd(0x405)
    await tb.preset(1, 900)
    await tb.dac(0, 0xC00)
    await tb.beat()
    await tb.dac(0, 0xC00)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | PANIC_IRQ | BASE)
    rises, falls = (tb.times(edge, dut.pcx_reset_drv_o) for edge in (RisingEdge, FallingEdge))
    dut.vme_sysreset_ni.value = 0
    await tb.us(5)
    dut.vme_sysreset_ni.value = 1
    await tb.us(1)
    assert falls and abs((falls[0] - rises[0]) / 1e6 - 5) < 0.3
    assert await tb.rd(PCCSR) == 0
    await tb.wr(0x407, 0xE8)
    assert await tb.rd(0x405) == status
    await tb.wr(PCCSR, BASE)
    assert await tb.crd(0, PORT_A) == 0xFF or await tb.crd(0, PORT_A) == 0, "port A is an input"
    beats = [tb.led(c, f"beat{j}") for c in range(3) for j in (1, 2)]
    assert beats == [1] * 6, "SYSRESET* does not touch the one-shots"
    assert tb.volts(0) == 0, "the relay has let go"
    await tb.setup(0)
    await tb.us(25)
    assert tb.volts(0) == 0x4000, "SYSRESET* does not touch the D/As"
    assert await tb.encoder(1) == 0
    await tb.wr(0x407, 0x70)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    await tb.wr(0x407, 0x74)
    assert await tb.vme.iack(5) == 0x5A, "the vector keeps its contents"
