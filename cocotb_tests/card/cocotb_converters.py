# SPDX-License-Identifier: Apache-2.0
"""D/A, A/D, what latches them, relay, heartbeat, PANIC, switches. §5.3.2-5.3.6, §5.4.1"""

from math import ceil

import cocotb
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge

from cocotb_tests.card import host
from cocotb_tests.card.host import CONVERT_US, Slot, card_test, rack_test, slot_test
from cocotb_tests.lib.req import slow, test, variants
from cocotb_tests.lib.tb import (
    B_DOUBLE,
    B_REAL_ENC,
    B_SCLOCK,
    B_TO_JOINT,
    C_BEAT1,
    C_DONE,
    DAC1,
    LATCH,
    LATCH_ALL,
    PORT_B,
    PORT_C,
    RUN,
    volts_of,
)

# The times of the report, at a PC's 4.77 MHz, which is no multiple of a megahertz.
TOPLEVEL = host.TOPLEVEL | {"real": "mark1"}
VARIANTS = host.VARIANTS | {"real": {"ClkHz": 4_772_727}}


# --- D/A ----------------------------------------------------------------------------------------


@card_test("DAC-1", "LAT-1")
async def double_buffering(tb):
    """PB3 = 1: both outputs of the card move with the latch and not before; other cards do not.

    PB3 = 0 again: the high write takes both bytes out.
    """
    await tb.relay()
    card = tb.cards - 1
    mine = (2 * card, 2 * card + 1)
    await tb.cwr(card, PORT_B, RUN | B_DOUBLE)
    for n, code in enumerate((0x123, 0x456, 0xFED)):
        held = tb.drives()[2 * card :]
        await tb.dac(mine[0], code)
        await tb.dac(mine[1], code ^ 0xFFF)
        if card:
            await tb.dac(0, code)
            assert tb.volts(0) == volts_of(code), "card 0 is single-buffered"
        assert tb.drives()[2 * card :] == held, f"sample {n} came early"
        await tb.pulse()
        await tb.clocks(3)
        assert tb.drives()[2 * card :] == [volts_of(code), volts_of(code ^ 0xFFF)]
    await tb.cwr(card, PORT_B, RUN)
    await tb.cwr(card, DAC1 + 2, 0x00)
    assert tb.volts(mine[1]) == volts_of(0x012)
    await tb.cwr(card, DAC1 + 3, 0x8)
    assert tb.volts(mine[1]) == 0


@rack_test("DAC-1", "LAT-1", b=RUN | B_DOUBLE)
async def new_value_appears_exactly_one_sample_later(dut, tb):
    """SCLOCK of 60 us: what is written in one sample stands from the next edge."""
    await tb.sclock(8, 60)
    moved = []

    async def watch():
        settled = dut.drive_v_o.value
        while True:
            await dut.drive_v_o.value_change
            await ReadOnly()  # within an instant Icarus shows a vector that is being put together
            if dut.drive_v_o.value != settled:
                settled = dut.drive_v_o.value
                moved.append(tb.now())

    cocotb.start_soon(watch())
    last = None
    for n in range(6):
        await RisingEdge(dut.sclock_o)
        edge = tb.now()
        await tb.us(2)
        if last is not None:
            assert tb.drives() == [volts_of(last)] * 6
            assert len(set(moved)) == 1, "all outputs move in the same clock"
            assert tb.clks(moved[0] - edge) <= 2
        last = 0x300 + 0x111 * n
        moved.clear()
        for axis in range(6):
            await tb.dac(axis, last)
        assert not moved


@rack_test("LAT-1", "DAC-1", b=RUN | B_DOUBLE)
async def software_latch_updates_double_buffered_dacs(tb):
    """Jumper E023-E022 is fitted: 0x10 for its card, 0x12 for all."""
    for axis in range(6):
        await tb.dac(axis, 0x900)
    await tb.cwr(1, LATCH, 0)
    assert tb.drives() == [0, 0, 0x1000, 0x1000, 0, 0]
    await tb.crd(7, LATCH_ALL)  # any card address, also one that is absent; a read as well
    assert tb.drives() == [0x1000] * 6


# --- latch and A/D ------------------------------------------------------------------------------


@rack_test("LAT-1", "ADC-1")
@cocotb.parametrize(how=["sclock", "write", "read", "all"])
async def what_starts_a_conversion(tb, how):
    """SCLOCK starts all; 0x10 its card; 0x12 every card."""
    tb.inputs([0x1000 * (n + 1) for n in range(6)])
    expected = [0x800 + 0x100 * (n + 1) for n in range(6)]
    before = await tb.codes()
    if how == "sclock":
        await tb.pulse()
    elif how == "all":
        await tb.cwr(2, LATCH_ALL, 0)
    elif how == "write":
        await tb.cwr(1, LATCH, 0)
    else:
        await tb.crd(1, LATCH)
    mine = range(6) if how in ("sclock", "all") else (2, 3)
    await tb.us(1)
    done = [await tb.crd(c, PORT_C) & C_DONE for c in range(3)]
    assert done == [0 if 2 * c in mine else C_DONE for c in range(3)]
    await tb.us(CONVERT_US)
    assert await tb.codes() == [expected[n] if n in mine else before[n] for n in range(6)]


@slot_test("LAT-1", "ADC-1")
async def latch_all_of_another_card(tb):
    """0x12 at any card address latches; 0x10 at another's does not."""
    for dip in range(16):
        await tb.pc.outb(dip << 10 | 0x300 | LATCH_ALL, 0)
        assert not await tb.pc.read(PORT_C) & C_DONE
        await tb.us(26)
        await tb.pc.outb(dip << 10 | 0x300 | LATCH, 0)
        assert bool(await tb.pc.read(PORT_C) & C_DONE) == (dip != 9)
        await tb.us(26)


@slot_test("LAT-1", b=B_REAL_ENC | B_TO_JOINT | B_DOUBLE)
async def port_b2_gates_sclock(tb):
    """PB2 = 0: SCLOCK neither latches, starts nor updates; software latches still do."""
    await tb.relay()
    tb.inputs([0x2000] * 2)
    await tb.preset(0, 77)
    await tb.dac(0, 0xC00)
    await tb.pulse()
    await tb.enc[0].move(3, 300)
    await tb.us(1)
    assert await tb.encoder(0) == 80, "no latch: the live count"
    assert tb.volts(0) == 0
    assert await tb.pc.read(PORT_C) & C_DONE
    await tb.pc.write(LATCH, 0)
    await tb.enc[0].move(3, 300)
    assert not await tb.pc.read(PORT_C) & C_DONE
    assert tb.volts(0) == volts_of(0xC00)
    assert [await tb.encoder(0), await tb.encoder(0)] == [80, 83]
    await tb.converted()
    await tb.pc.write(PORT_B, await tb.pc.read(PORT_B) | B_SCLOCK)
    assert await tb.pc.read(PORT_C) & C_DONE, "SCLOCK was high before PB2 was: no edge"


@slot_test("ADC-1", "ANA-1")
async def conversion_to_the_clock(tb):
    """200 clocks at 8 MHz from the latch. Meanwhile the old code is read, and neither the input nor
    a start on any clock changes the new one."""
    await tb.relay()
    tb.inputs([0x4000] * 2)
    await tb.pulse()
    await tb.converted()
    assert await tb.codes() == [0xC00] * 2
    tb.inputs([0x1000, -0x4000])
    await tb.pulse()
    start, starts = tb.now(), 0
    tb.inputs([0x7000] * 2)
    assert await tb.codes() == [0xC00] * 2
    while tb.now() - start < 185 * tb.period:
        assert not await tb.pc.read(PORT_C) & C_DONE
        await tb.pulse()
        starts += 1
    while not await tb.pc.read(PORT_C) & C_DONE:
        pass
    assert 190 < (tb.now() - start) / tb.period < 208 and starts > 13
    assert await tb.codes() == [0x900, 0x400]


@card_test("DIA-1", "DAC-1", "ADC-1")
async def analogue_loop(tb):
    """PB1 = 0: the A/D sees the D/A, the joint sees 0 V; the relay takes its time both ways."""
    await tb.relay()
    tb.inputs([0x7000 for _ in tb.axes()])
    codes = [(0x000, 0x3FF, 0x800, 0x9AB, 0xFFF, 0x123)[axis] for axis in tb.axes()]
    for axis, code in enumerate(codes):
        await tb.dac(axis, code)
    assert tb.drives() == [volts_of(code) for code in codes]
    for card in range(tb.cards):
        await tb.cwr(card, PORT_B, RUN & ~B_TO_JOINT)
    await tb.relay()
    assert not any(tb.drives())
    await tb.cwr(0, LATCH_ALL, 0)
    await tb.converted()
    assert await tb.codes() == codes
    await tb.cwr(0, PORT_B, RUN)
    await tb.relay()
    assert tb.drives() == [volts_of(0), volts_of(0x3FF)] + [0] * (2 * tb.cards - 2)


# --- heartbeat, PANIC, switches -----------------------------------------------------------------


@card_test("HB-1")
async def heartbeat_to_the_clock(dut, tb):
    """The pulse is exactly HeartbeatUs long, after each trigger; a new one restarts it, no gap."""
    dut.axis_enable_i.value = 1
    beat_us = tb.parameters["HeartbeatUs"]
    clocks = beat_us * tb.clk_hz // 1_000_000
    for again in (None, 0.1, 0.5, 0.9):
        await tb.us(beat_us + 3)
        assert tb.panic()
        write = cocotb.start_soon(tb.cwr(0, DAC1, 0))
        start = await tb.led_edge(0, "beat1", 1)
        await write
        if again is None:
            end = await tb.led_edge(0, "beat1", 0)
            assert tb.clks(end - start) == clocks
            continue
        await tb.us(again * beat_us)
        assert not tb.panic()
        before = tb.now()
        await tb.cwr(0, DAC1, 0)
        after = tb.now()
        end = await tb.led_edge(0, "beat1", 0)
        assert before < end - clocks * tb.period <= after + 2 * tb.period


@slot_test("HB-2", "SW-1")
async def panic_needs_an_enabled_axis(dut, tb):
    """All four switch settings x both heartbeats."""
    for enabled in range(4):
        dut.axis_enable_i.value = enabled
        for beating in range(4):
            await tb.us(105)
            for joint in (0, 1):
                if beating >> joint & 1:
                    await tb.pc.write(DAC1 + 2 * joint, 0)
            await ClockCycles(dut.clk_i, 4)
            assert tb.panic() == int(bool(enabled & ~beating)), f"{enabled:02b} {beating:02b}"
            assert int(dut.pc_irq_o.value) & 0xF == 0, "only the jumpered line"
            assert await tb.pc.read(PORT_C) & 5 == (beating & 1) | (beating & 2) << 1


@card_test("SW-1", "HB-2")
async def switch_grounds_the_drive(dut, tb):
    """Each axis by its own switch; the one-shot of an axis switched off still works."""
    await tb.relay()
    codes = [(0xC00, 0x400)[axis % 2] for axis in tb.axes()]
    every = (1 << len(codes)) - 1
    for enabled in (0, 1, 2, every, *(every & ~(1 << axis) for axis in tb.axes())):
        dut.axis_enable_i.value = enabled
        for axis, code in enumerate(codes):
            await tb.dac(axis, code)
        assert tb.drives() == [volts_of(c) * (enabled >> a & 1) for a, c in enumerate(codes)]
        assert [await tb.crd(card, PORT_C) & 5 for card in range(tb.cards)] == [5] * tb.cards


@test("HB-1", "DIA-1", "ADC-1")
@variants("real")
@slow
async def real_heartbeat_relay_and_conversion(dut):
    """The times of the report: 50 ms to the clock, 1 ms, 25 us; no rate rounded to megahertz."""
    tb = await Slot(dut).start()
    dut.axis_enable_i.value = 1
    await tb.pc.write(DAC1, 0xFF)
    await tb.pc.write(DAC1 + 1, 0xF)
    start = tb.now()
    await dut.drive_v_o.value_change
    relay = (tb.now() - start) / 1e6
    assert 990 < relay < 1001, f"relay {relay} us"
    await tb.pulse()
    start = tb.now()
    while not await tb.pc.read(PORT_C) & C_DONE:
        pass
    assert abs((tb.now() - start) / 1e6 - 25) < 2
    await tb.us(50_000)
    write = cocotb.start_soon(tb.pc.write(DAC1, 0))
    begin = await tb.led_edge(0, "beat1", 1)
    await write
    assert await tb.pc.read(PORT_C) & C_BEAT1
    await tb.us(49_900)
    assert not tb.panic()
    end = await tb.led_edge(0, "beat1", 0)
    assert tb.clks(end - begin) == ceil(50e-3 * tb.clk_hz)
    await tb.clocks(2)
    assert tb.panic()
