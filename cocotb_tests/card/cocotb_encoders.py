# SPDX-License-Identifier: Apache-2.0
"""Encoder counters, their latch, index and made signals. §5.3.1, §5.3.2, §5.3.4, §5.3.5"""

import cocotb
from cocotb.triggers import RisingEdge, Timer
from cocotbext.quadrature import QuadratureDecoder, QuadratureSource

from cocotb_tests.card import host
from cocotb_tests.card.host import NS_PER_COUNT, card_test, slot_test
from cocotb_tests.lib.tb import (
    B_INDEX,
    B_TO_JOINT,
    C_INDEX1,
    C_INDEX2,
    LATCH,
    PORT_A,
    PORT_B,
    PORT_C,
    QUAD,
    RUN,
)

TOPLEVEL, VARIANTS = host.TOPLEVEL, host.VARIANTS
MOVES = (600, -600, 64, -1, 255, -300)


@card_test("ENC-1", "CRD-2")
async def counts_at_full_speed(tb):
    """All at once, 4 million counts/s, up and down, across both ends of the range."""
    starts = [(0x0100, 0xFF00)[move > 0] for move in MOVES]
    for axis in tb.axes():
        await tb.preset(axis, starts[axis])
    moving = [cocotb.start_soon(tb.enc[a].move(MOVES[a], NS_PER_COUNT)) for a in tb.axes()]
    for task in moving:
        await task
    await tb.us(1)
    assert await tb.counts() == [(starts[a] + MOVES[a]) & 0xFFFF for a in tb.axes()]


@slot_test("ENC-1")
async def counts_a_worn_encoder(dut, tb):
    """A trapezoid to 2.5 M counts/s and back, edges up to 0.45 of a count from their places."""
    await tb.preset(0, 0)
    for phase, duty in ((0, 0), (30, 10), (-15, -25)):
        source = QuadratureSource(
            tb.enc[0].a, tb.enc[0].b, phase_error_deg=phase, duty_error_deg=duty
        )
        decoder = QuadratureDecoder(dut.enc_a_i, dut.enc_b_i, shortest_ns=125)
        await tb.clocks(2)
        for sign in (1, -1):
            top = sign * 2.5e6
            await source.profile([(100e-6, 0, top), (20e-6, top, top), (100e-6, top, 0)])
            await tb.us(1)
            assert await tb.encoder(0) == source.count == decoder.count == (300 if sign > 0 else 0)
        decoder.stop()


@slot_test("ENC-1", "PCB-1")
async def slow_bus_clock_slows_the_sampling(dut, tb):
    """CLK ticks every fourth clock: a level shorter than that can pass unseen, longer cannot."""
    await tb.preset(0, 0)

    async def clk():
        n = 0
        while True:
            await RisingEdge(dut.clk_i)
            n += 1
            dut.pc_clk_en_i.value = int(n % 4 == 0)

    cocotb.start_soon(clk())
    await tb.enc[0].move(100, 1010)
    await tb.us(4)
    assert await tb.encoder(0) == 100
    await tb.enc[0].move(100, 130)
    await tb.us(4)
    assert await tb.encoder(0) != 200


@slot_test("ENC-1")
async def illegal_transitions_and_glitches(tb):
    """Both inputs at once count nothing; a glitch counts there and back or not at all."""
    await tb.preset(1, 100)
    for _ in range(5):
        tb.enc[1].jump()
        await tb.us(1)
    assert await tb.encoder(1) == 100
    for ns in (10, 60, 120, 130, 200, 260):
        for line in "ab":
            await tb.enc[1].glitch(ns, line)
            await tb.us(1)
            assert await tb.encoder(1) == 100, f"glitch of {ns} ns on {line}"


@slot_test("ENC-1")
@cocotb.parametrize(mode=[0, 1, 2, 3, 4, 5])
async def encoder_modes(tb, mode):
    """Two turns up, one down: hold, x1, x1, x2, x2, x4 by port A bits 2-0, for both joints."""
    await tb.pc.write(PORT_A, mode)
    per_cycle = (0, 1, 1, 2, 2, 4)[mode]
    for axis in tb.axes():
        await tb.preset(axis, 0x4000)
        await tb.enc[axis].move(4 * 6, 500)
        await tb.us(1)
        assert await tb.encoder(axis) == 0x4000 + 6 * per_cycle
        await tb.enc[axis].move(-4 * 4, 500)
        await tb.us(1)
        assert await tb.encoder(axis) == 0x4000 + 2 * per_cycle


@card_test("ENC-2", "LAT-1")
async def latched_once_then_live(tb):
    """The first read after a latch is the latched count; a second latch before the read wins."""

    async def all_move(way: int) -> None:
        for axis in tb.axes():
            await tb.enc[axis].move(way, 300)
        await tb.us(1)

    async def expect(more: int) -> None:
        assert await tb.counts() == [100 + 10 * axis + more for axis in tb.axes()]

    for axis in tb.axes():
        await tb.preset(axis, 100 + 10 * axis)
    await tb.pulse()
    await all_move(5)
    for more in (0, 5, 5):
        await expect(more)
    for card in range(tb.cards):
        await tb.cwr(card, LATCH, 0)
    await all_move(5)
    await tb.pulse()
    await all_move(5)
    for more in (10, 15):
        await expect(more)


@slot_test("DIA-2", b=B_TO_JOINT)
async def synthetic_encoder(tb):
    """Port B0 = 0: both counters count port A5-A6, those of the joints have no effect."""

    async def turn(port_a: int, *states: tuple[int, int]) -> list[int]:
        """Counts after these states of A and B."""
        for a, b in states:
            await tb.pc.write(PORT_A, port_a | a << 5 | b << 6)
        await tb.us(1)
        return await tb.counts()

    for axis in tb.axes():
        await tb.preset(axis, 50)
    await tb.enc[0].move(9, 300)
    assert await turn(QUAD, (1, 0), (1, 1), (0, 1), (0, 0), (1, 0)) == [55, 55]
    assert await turn(QUAD, (0, 0), (0, 1)) == [53, 53]
    assert (tb.led(0, "a1"), tb.led(0, "b1")) == (1, 0), "the LEDs show the joint"
    await turn(4, (0, 1))  # x2
    for axis in tb.axes():
        await tb.preset(axis, 50)
    assert await turn(4, (0, 0), (1, 0), (1, 1), (0, 1)) == [52, 52]


@card_test("DIA-2", "CAL-1", b=0)
async def the_made_index_is_one_bit_of_port_a(tb):
    """Bit 7 alone, whatever lights, A and B do, for both joints of its card."""
    both = C_INDEX1 | C_INDEX2
    for value in range(32):
        await tb.cwr(0, PORT_B, 0)
        await tb.cwr(0, PORT_A, QUAD | value << 3)
        for card in range(tb.cards):
            await tb.cwr(card, PORT_B, B_INDEX)
        await tb.us(2)
        seen = [await tb.crd(card, PORT_C) & both for card in range(tb.cards)]
        assert seen == [both * (value > 15)] + [0] * (tb.cards - 1), f"{value:02X}"


@slot_test("CAL-1")
@cocotb.parametrize(axis=[0, 1])
async def index_latches_flag_and_count(tb, axis):
    """At full speed; only while armed; later pulses latch again; disarming clears."""
    flag = (C_INDEX1, C_INDEX2)[axis]
    await tb.preset(axis, 1000)
    await tb.enc[axis].index(500)
    assert not await tb.pc.read(PORT_C) & flag, "not armed"
    await tb.pc.write(PORT_B, RUN | B_INDEX)
    assert not await tb.pc.read(PORT_C) & flag
    encoder = tb.enc[axis]
    encoder.lines, at_start = 5, encoder.count  # an index every 20 counts
    for way in (1, 1, -1):
        first = encoder.count
        await encoder.move(27 * way, NS_PER_COUNT)
        await tb.us(1)
        assert await tb.pc.read(PORT_C) & (C_INDEX1 | C_INDEX2) == flag
        marks = range(first + way, encoder.count + way, way)
        last = [count for count in marks if count % 20 == 0][-1]
        assert await tb.encoder(axis) == 1000 + last - at_start
        assert await tb.encoder(axis) == 1000 + encoder.count - at_start, "then the live count"
    await tb.pc.write(PORT_B, RUN)
    assert not await tb.pc.read(PORT_C) & flag


@slot_test("CAL-1")
async def index_that_is_high_when_armed(tb):
    """The flag follows the level, as Table 5.1 says: it is set."""
    tb.enc[0].i.set(0, 1)
    await tb.us(1)
    await tb.pc.write(PORT_B, RUN | B_INDEX)
    await tb.us(1)
    assert await tb.pc.read(PORT_C) & C_INDEX1
    await tb.pc.write(PORT_B, RUN)
    assert not await tb.pc.read(PORT_C) & C_INDEX1


@slot_test("CAL-1")
async def index_at_any_speed(tb):
    """The count latched is exactly that of the index, upwards and downwards, to 4 M counts/s.

    The index comes and goes with an edge of A or B, at any phase of the clock.
    """
    e = tb.enc[0]
    e.lines = 4  # an index every 16 counts
    await e.move(5, 500)
    for ns in (250, 260, 333, 500, 2000):
        for start, end in ((5, 29), (29, 5)):
            await tb.pc.write(PORT_B, RUN)
            await tb.preset(0, e.count)
            await tb.pc.write(PORT_B, RUN | B_INDEX)
            assert not await tb.pc.read(PORT_C) & C_INDEX1
            await Timer(2 + 2 * tb.random.randrange(tb.period // 2), "ps")
            assert e.count == start
            await e.move(end - start, ns)
            await tb.us(1)
            assert await tb.pc.read(PORT_C) & C_INDEX1
            assert await tb.encoder(0) == 16, f"{ns} ns, from {start} to {end}"
            assert await tb.encoder(0) == end


@slot_test("CAL-1")
@cocotb.parametrize(ns=[10, 60, 100])
async def an_index_shorter_than_a_clock(dut, tb, ns):
    """On every phase it sets its latch, that of its joint alone, and latches the counter."""
    for phase in range(0, 125, 10):
        for joint, bit in ((0, C_INDEX1), (1, C_INDEX2)):
            await tb.cwr(0, PORT_B, RUN | B_INDEX)
            await tb.enc[joint].move(3, 500)
            await tb.us(1)
            count = 3 * (phase // 10 + 1) & 0xFFFF
            await RisingEdge(dut.clk_i)
            await Timer(phase + 1, "ns")
            dut.enc_i_i.value = 1 << joint
            await Timer(ns, "ns")
            dut.enc_i_i.value = 0
            await tb.us(1)
            await tb.enc[joint].move(5, 500)
            assert await tb.crd(0, PORT_C) & (C_INDEX1 | C_INDEX2) == bit, f"{phase} ns"
            assert await tb.encoder(joint) == count, "the count of the index"
            await tb.enc[joint].move(-5, 500)
            await tb.cwr(0, PORT_B, RUN)
            assert not await tb.crd(0, PORT_C) & (C_INDEX1 | C_INDEX2)
