# SPDX-License-Identifier: Apache-2.0
"""One card whose asynchronous inputs change next to a clock, a command, SCLOCK or each other. §5.3

The synchronisers take an input that changed within 2 ns before the clock as its old or its new
value. Times are random, half of them whole clocks; half of the cases begin next to a clock edge.
"""

import cocotb
from cocotb.triggers import RisingEdge, Timer

from cocotb_tests.card.host import VARIANTS as CARDS
from cocotb_tests.card.host import Slot
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import (
    B_INDEX,
    C_DONE,
    C_INDEX1,
    DAC1,
    ENC1,
    LATCH,
    PORT_A,
    PORT_B,
    PORT_C,
    QUAD,
    RUN,
    volts_of,
)

TOPLEVEL = "mark1"
SOURCES = ("mmcs_sync.sv",)
PARAMETERS = CARDS["slot"]
CLK, WINDOW = 125, 2  # ns
CASES = 100  # of a row of a table
PHASES = ((0, 0), (1, 0), (1, 1), (0, 1))  # A and B of a quarter period


class Edges(Slot):
    async def start(self, b: int = RUN):
        await super().start(b)
        self.place = 0
        return self

    def span(self, least: float, most: float) -> float:
        """ns between the two; every other time in whole clocks."""
        if self.random.random() < 0.5:
            return self.random.randint(-int(-least // CLK), int(most // CLK)) * CLK
        return self.random.uniform(least, most)

    async def align(self) -> float:
        """To any time in a clock, every other time next to its edge; the ns since it."""
        near, far = self.random.uniform(-3, 1) % CLK, self.random.uniform(0, CLK)
        phase = round(near if self.random.random() < 0.5 else far, 3)
        await RisingEdge(self.dut.clk_i)
        await Timer(round(1000 * phase) + 1, "ps")
        return phase

    def later(self, ns: float, change, *values) -> None:
        async def act():
            if ns > 0:
                await Timer(round(1000 * ns), "ps")
            change(*values)

        cocotb.start_soon(act())

    def step(self, way: int = 1) -> None:
        """A quarter period of joint 1."""
        self.place = (self.place + way) % 4
        self.dut.enc_a_i.value, self.dut.enc_b_i.value = PHASES[self.place]

    def index(self, level: int) -> None:
        self.dut.enc_i_i.value = level

    def drq(self, level: int) -> None:
        self.dut.pc_drq_i.value = level << 2

    def sclock_at(self, ns: float) -> None:
        self.later(ns, self.drq, 1)
        self.later(ns + 4 * CLK, self.drq, 0)

    async def live(self) -> int:
        """The count as it is, whatever was latched."""
        await self.pc.read(PORT_C)
        return await self.encoder(0)

    async def pair(self, low_first: bool) -> int:
        registers = (ENC1 + 1, ENC1) if low_first else (ENC1, ENC1 + 1)
        first, second = [await self.pc.read(register) for register in registers]
        return second << 8 | first if low_first else first << 8 | second


edge_test = tests_on(Edges)


@edge_test("ENC-1", "ENC-2")
async def two_edges_of_an_encoder(tb):
    """From one clock apart on both are counted; closer together both or none, and so close that
    their order is lost, they may be taken in the other one."""
    for way in (1, -1):
        for _ in range(CASES):
            await tb.preset(0, 0x100)
            await tb.align()
            apart = tb.span(0, 3 * CLK)
            tb.later(0, tb.step, way)
            tb.later(apart, tb.step, way)
            await tb.clocks(9)
            both, got = 0x100 + 2 * way, await tb.live()
            may = {both} | ({0x100} if apart < CLK + WINDOW else set())
            may |= {0x200 - both} if apart < WINDOW else set()
            assert got in may, f"{got:04X}, {apart} ns apart"


@edge_test("LAT-1", "ENC-2")
async def an_edge_around_sclock(tb):
    for low_first in (False, True):
        for _ in range(CASES):
            await tb.preset(0, 0xFF)
            at = tb.span(-6 * CLK, 4 * CLK) + tb.random.choice((-1, 0.5, 1))
            await tb.clocks(1)
            await Timer(5, "ns")
            tb.sclock_at(7 * CLK)
            tb.later(7 * CLK + at, tb.step)
            await tb.clocks(16)
            latched = await tb.pair(low_first)
            assert latched in (0xFF, 0x100), f"{latched:04X}: in pieces"
            assert latched == 0x100 or at > -4 * CLK, "an edge long before the latch is missing"
            assert latched == 0xFF or at <= 0, "an edge after the latch is in it"
            assert await tb.live() == 0x100
            tb.step(-1)


@edge_test("CAL-1", "LAT-1")
async def an_index_around_sclock(tb):
    """An edge that comes with the index is in the count that the index latches, whatever SCLOCK
    does; an index next to a clock may be taken a clock before its edge."""
    for moving in (False, True):
        for _ in range(CASES):
            await tb.pc.write(PORT_B, RUN | B_INDEX)
            await tb.preset(0, 0x2000)
            at, phase = 6 * CLK, await tb.align()
            tb.later(at, tb.step)
            tb.later(at, tb.index, 1)
            if moving:
                tb.later(at + 5 * CLK, tb.step)
            tb.later(at + 6 * CLK, tb.index, 0)
            # of the adaptor: just after a clock edge
            sclock = at + tb.random.randrange(-2, 6) * CLK - phase + 5
            tb.sclock_at(sclock)
            await tb.clocks(24)
            assert await tb.pc.read(PORT_C) & C_INDEX1, "the index is not latched"
            got = await tb.pair(False)
            may = {0x2001} | ({0x2000} if phase > CLK - WINDOW else set())
            may |= {0x2002} if moving and sclock > at + 3 * CLK else set()
            assert got in may, f"{got:04X}, SCLOCK {sclock - at} ns after the index"
            await tb.pc.write(PORT_B, RUN)


@edge_test("CAL-1")
async def an_edge_around_the_index(tb):
    for way in (1, -1):
        for _ in range(CASES):
            await tb.pc.write(PORT_B, RUN | B_INDEX)
            await tb.preset(0, 0x4000)
            await tb.align()
            at = tb.span(-3 * CLK, 3 * CLK)
            tb.later(3 * CLK, tb.index, 1)
            tb.later(3 * CLK + at, tb.step, way)
            tb.later(9 * CLK, tb.index, 0)
            await tb.clocks(15)
            got = await tb.pair(False)
            may = {0x4000 + way} if at <= CLK + WINDOW else set()
            may |= {0x4000} if at > -WINDOW else set()
            assert got in may, f"{got:04X}, the edge {at} ns after the index"
            await tb.pc.write(PORT_B, RUN)


@edge_test("ENC-2")
async def an_edge_in_a_pair_of_accesses(tb):
    """Both orders of the bytes, both directions, the high byte changing with the low one."""
    for way, low_first in ((1, False), (1, True), (-1, False), (-1, True)):
        for _ in range(CASES):
            before, after = (0xFF, 0x100)[::way]
            await tb.preset(0, before)
            await tb.align()
            tb.later(tb.span(0, 14 * CLK), tb.step, way)
            assert await tb.pair(low_first) in (before, after), "a read in pieces"
            await tb.clocks(5)
            assert await tb.live() == after, "a count is lost"
            value = (0x12FF, 0x1300)[::way][0]
            await tb.align()
            tb.later(tb.span(0, 18 * CLK), tb.step, way)
            halves = [(ENC1, value >> 8), (ENC1 + 1, value & 0xFF)]
            for register, half in halves[:: -1 if low_first else 1]:
                await tb.pc.write(register, half)
            await tb.clocks(9)
            assert await tb.live() in (value, value + way), "a preset in pieces"


@edge_test("HB-1", "HB-2")
async def a_heartbeat_around_the_end_of_the_last(tb):
    """The D/A is written, and the axis switch moves, next to the end of the one-shot: PANIC is gone
    after the heartbeat and has no pulse shorter than a clock."""
    changes = tb.times(lambda pin: pin.value_change, tb.dut.pc_irq_o)
    beat = CARDS["slot"]["HeartbeatUs"] * 1000
    for switch in (False, True):
        for _ in range(CASES // 4):
            await tb.dac(1, 0x800)
            await tb.pc.write(DAC1, 0)
            await tb.clocks(6)
            changes.clear()
            await Timer(round(1000 * (beat - 26 * CLK + tb.span(-3 * CLK, 3 * CLK))), "ps")
            await tb.dac(1, 0x800)
            if switch:
                at = tb.span(2 * CLK, 3 * CLK)
                tb.later(at, setattr, tb.dut.axis_enable_i, "value", 2)
                tb.later(at + 3 * CLK, setattr, tb.dut.axis_enable_i, "value", 3)
            await tb.pc.write(DAC1, 0x55)
            await tb.clocks(6)
            assert not tb.panic(), "PANIC after a heartbeat"
            pulses = zip(changes[::2], changes[1::2], strict=True)
            assert switch or all(fall - rise > 124_000 for rise, fall in pulses), "a glitch"


@edge_test("CRD-2", "PAN-2")
async def reset_drv_or_power_in_a_write(tb):
    for pin, level in ((tb.dut.pc_reset_drv_i, 1), (tb.dut.power_i, 0)):
        for _ in range(CASES):
            await tb.dac(0, 0xA00)
            await tb.relay()
            assert tb.volts(0)
            await tb.align()
            at = tb.span(0, 8 * CLK)
            tb.later(at, setattr, pin, "value", level)
            tb.later(at + 6 * CLK, setattr, pin, "value", 1 - level)
            await tb.pc.write(PORT_A, 0x1D)
            await tb.clocks(14)
            assert not int(tb.dut.drive_v_o.value), "a drive moves after RESET"
            await tb.setup(0, RUN)
            await tb.preset(0, 0x5A5A)
            assert await tb.live() == 0x5A5A
            await tb.pc.write(PORT_A, 0x15)
            assert await tb.pc.read(PORT_A) == 0x15
            await tb.pc.write(PORT_A, QUAD)


@edge_test("ADC-1", "LAT-1")
async def a_latch_around_the_end_of_a_conversion(tb):
    """One conversion or two, each whole; a conversion takes 25 us."""
    old, new = 0x955, 0xDAA  # of which no two pieces are alike
    for _ in range(CASES // 2):
        await tb.pc.write(LATCH, 0)  # whatever was there
        await tb.us(26)
        tb.inputs([volts_of(old)])
        await tb.clocks(1)
        await Timer(5, "ns")
        tb.sclock_at(0)
        tb.later(3 * CLK, tb.inputs, [volts_of(new)])
        tb.sclock_at((200 + tb.random.randint(-3, 4)) * CLK)
        await tb.us(53)
        assert await tb.adc(0) in (old, new), "a conversion in pieces"
        assert await tb.pc.read(PORT_C) & C_DONE
