# SPDX-License-Identifier: Apache-2.0
"""Brakes without a clock, short faults, the sign of life. §2.3.4, §4.3.5, §5.3.2

Pulses are put on every phase of the clock; brakes and PANIC are looked at whenever they change.
"""

import cocotb
from cocotb.triggers import FallingEdge, First, RisingEdge, Timer, ValueChange

from cocotb_tests.lib.req import test, tests_on
from cocotb_tests.lib.tb import (
    ARMED,
    BASE,
    HEALTH_CLKS,
    PANIC_IRQ,
    PCCSR,
    Machine,
)
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
SOURCES = ["estop", "cable", "power", "line"]
IRQ7 = 0x10  # of pcx_irq_i: PANIC's line
ALIVE_US = 500
PHASES = range(0, 125, 10)


class Source:
    """One cause of PANIC, as a pin."""

    def __init__(self, dut, name: str):
        self.pin, self.good, self.bad = {
            "estop": (dut.estop_closed_i, 1, 0), "cable": (dut.cable_ok_i, 1, 0),
            "power": (dut.pc_power_i, 1, 0), "line": (dut.pcx_irq_i, 0, IRQ7),
            "reset": (dut.rst_ni, 1, 0),
        }[name]  # fmt: skip

    def set(self, good: bool) -> None:
        self.pin.value = self.good if good else self.bad

    async def pulse(self, ns: int) -> None:
        self.set(False)
        await Timer(ns, "ns")
        self.set(True)


async def machine(dut) -> Machine:
    """No axis is switched on, so nothing but the pins panics; the brakes are off."""
    tb = await Machine(dut).start(setup=True)
    dut.axis_enable_i.value = 0
    await tb.clocks(HEALTH_CLKS)
    assert not int(dut.panic_o.value) and int(dut.brake_release_o.value)
    return tb


machine_test = tests_on(machine)


class Watch:
    """What of brakes and PANIC rises and falls, in order; never are the brakes off in a PANIC."""

    def __init__(self, dut):
        self.seen: list[str] = []
        self._handles = {"brake": dut.brake_release_o, "panic": dut.panic_o}
        self._tasks = [cocotb.start_soon(self._watch(name)) for name in self._handles]

    async def _watch(self, name: str) -> None:
        while True:
            await ValueChange(self._handles[name])
            self.seen.append(f"{name} {int(self._handles[name].value)}")
            levels = [int(handle.value) for handle in self._handles.values()]
            assert levels != [1, 1], "the brakes are off in a PANIC"

    def stop(self) -> list[str]:
        for task in self._tasks:
            task.cancel()
        return self.seen


@machine_test("PAN-1")
@cocotb.parametrize(what=[*SOURCES, "reset"], level=[0, 1])
async def brakes_without_a_clock(dut, tb, what, level):
    """The clock stands: every cause closes the brakes at once, and its end does not open them."""
    await (RisingEdge if level else FallingEdge)(dut.clk_i)
    await Timer(10, "ns")
    tb.clock.stop()
    await Timer(10, "us")
    assert int(dut.clk_i.value) == level and int(dut.brake_release_o.value)
    source = Source(dut, what)
    source.set(False)
    await Timer(1, "ns")
    assert not int(dut.brake_release_o.value)
    source.set(True)
    await Timer(10, "us")
    assert not int(dut.brake_release_o.value), "no register has released them"


@machine_test("PAN-1")
@cocotb.parametrize(what=SOURCES)
async def a_reset_opens_no_brake(dut, tb, what):
    """Whatever is wrong when reset ends, neither PANIC nor the brakes go away for an instant."""
    source = Source(dut, what)
    dut.rst_ni.value = 0
    source.set(False)
    await tb.clocks(5)
    watch = Watch(dut)
    dut.rst_ni.value = 1
    await tb.clocks(200)
    assert not watch.seen and int(dut.panic_o.value) and not int(dut.brake_release_o.value)
    source.set(True)
    await tb.us(60)
    assert sorted(watch.stop()) == ["brake 1", "panic 0"]


@machine_test("PAN-1", "HB-2")
async def a_reset_opens_no_brake_without_heartbeats(dut, tb):
    """The cards' own PANIC is there before that of the reset goes."""
    dut.axis_enable_i.value = 0x3F
    dut.rst_ni.value = 0
    await tb.clocks(5)
    watch = Watch(dut)
    dut.rst_ni.value = 1
    await tb.clocks(200)
    assert not watch.stop() and int(dut.panic_o.value)


@machine_test("PAN-1", "INT-1")
@cocotb.parametrize(what=SOURCES, ns=[10, 60, 100, 260])
async def short_outages(dut, tb, what, ns):
    """On every phase: brakes closed from its beginning on, one PANIC, latched only while armed."""
    source = Source(dut, what)
    for phase in PHASES:
        for armed in (ARMED, 0):
            await tb.wr(PCCSR, BASE)
            await tb.wr(PCCSR, armed | BASE)
            watch = Watch(dut)
            await RisingEdge(dut.clk_i)
            await Timer(phase + 1, "ns")
            await source.pulse(ns)
            await tb.us(60 if what == "power" else 3)
            seen = watch.stop()
            assert seen[:2] == ["brake 0", "panic 1"], f"{phase} ns: {seen}"
            assert sorted(seen[2:]) == ["brake 1", "panic 0"], f"{phase} ns: {seen}"
            latched = await tb.rd(PCCSR) & PANIC_IRQ
            assert latched == (PANIC_IRQ if armed else 0), f"{phase} ns, armed {armed:02X}"
            if not armed:
                await tb.wr(PCCSR, ARMED | BASE)
                assert await tb.rd(PCCSR) == ARMED | BASE, "what came before is lost"


@test("HB-2", "PAN-1")
async def panic_leaves_the_card_from_a_flip_flop(dut):
    """A clock after the heartbeat's end, by which PANIC's line closes the brakes."""
    tb = await Machine(dut).start(setup=True)
    dut.axis_enable_i.value = 1
    await tb.beat()
    await tb.clocks(HEALTH_CLKS)
    await FallingEdge(dut.brake_release_o)
    at = tb.now()
    assert not tb.led(0, "beat1")
    await RisingEdge(dut.panic_o)
    assert tb.clks(tb.now() - at) == 3
    await tb.dac(0, 0x800)
    await tb.clocks(HEALTH_CLKS)
    end = tb.now()
    beats = []

    async def beat():
        while tb.led(0, "beat1"):
            await FallingEdge(dut.clk_i)
        beats.append(tb.now())

    task = cocotb.start_soon(beat())
    await FallingEdge(dut.brake_release_o)
    await task
    assert at < end < beats[0] < tb.now() + tb.period
    assert tb.clks(tb.now() - (beats[0] - tb.period / 2)) == 1


@machine_test("PAN-1")
async def alive_while_the_clock_runs(dut, tb):
    """An edge every 500 us, in PANIC too; none without a clock, none in a reset."""
    await ValueChange(dut.alive_o)
    for closed in (1, 1, 0, 0):
        dut.estop_closed_i.value = closed
        before, level = tb.now(), int(dut.alive_o.value)
        await ValueChange(dut.alive_o)
        assert tb.now() - before == ALIVE_US * 1e6 and int(dut.alive_o.value) != level
    dut.rst_ni.value = 0
    await tb.us(1)
    level = int(dut.alive_o.value)
    for stopped in (False, True):
        if stopped:
            dut.rst_ni.value = 1
            tb.clock.stop()
        await First(ValueChange(dut.alive_o), Timer(3 * ALIVE_US, "us"))
        assert int(dut.alive_o.value) == level
