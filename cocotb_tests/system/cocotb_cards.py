# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""Three Mark I cards behind the adaptor: registers, latching, D/A, A/D, encoders. §5.3"""

import cocotb
from cocotb.triggers import ReadOnly, RisingEdge, Timer

from cocotb_tests.lib.req import test, tests_on
from cocotb_tests.lib.tb import (
    B_DOUBLE,
    B_INDEX,
    B_REAL_ENC,
    B_TO_JOINT,
    BASE,
    C_BEAT1,
    C_DONE,
    C_INDEX1,
    C_INDEX2,
    DAC1,
    LATCH,
    LATCH_ALL,
    PCCSR,
    PORT_A,
    PORT_B,
    PORT_C,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    RUN,
    Machine,
    dip,
    volts_of,
)
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
NS_PER_COUNT = 250  # the 4 million counts/s of ENC-1
RELAY_US = 20
CONVERT_US = 25


async def machine(dut, b: int = RUN) -> Machine:
    """Cards set up, relays settled, SCLOCK low and standing."""
    tb = await Machine(dut).start()
    await tb.wr(0x407, 0x70)
    for card in range(tb.cards):
        await tb.setup(card, b)
    await tb.us(RELAY_US + 2)
    return tb


machine_test = tests_on(machine)


async def pulse(tb: Machine) -> None:
    """One rising edge of SCLOCK."""
    await tb.wr(0x407, 0x70)
    await tb.wr(0x407, 0x74)


# --- decode -------------------------------------------------------------------------------------


@machine_test("CRD-1", "MAP-1")
async def cards_are_separate(tb):
    """Each card's registers hold what was written to that card."""
    for card in range(3):
        await tb.cwr(card, PORT_A, 0x10 + card)
        await tb.preset(2 * card, 0x1000 * card + 1)
        await tb.preset(2 * card + 1, 0x1000 * card + 2)
    for card in range(3):
        assert await tb.crd(card, PORT_A) == 0x10 + card
        assert await tb.encoder(2 * card) == 0x1000 * card + 1
        assert await tb.encoder(2 * card + 1) == 0x1000 * card + 2


@machine_test("CRD-1")
async def other_bases_reach_no_card(tb):
    """PCCSR bits 4-0 other than 0x18: reads 0xFF, writes nothing."""
    for base in range(32):
        if base == BASE:
            continue
        await tb.wr(PCCSR, base)
        await tb.cwr(0, PORT_A, 0xAA)
        assert await tb.crd(0, PORT_A) == 0xFF
    await tb.wr(PCCSR, BASE)
    assert await tb.crd(0, PORT_A) == QUAD


@machine_test("CRD-1")
async def unused_and_one_way_registers(tb):
    """Holes and write-only offsets read 0xFF; writing holes and the A/D changes nothing."""
    before = [await tb.crd(1, r) for r in (0, 1, 4, 5, 6, 7, 12, 13, 14)]
    holes = [0x0F, 0x11, *range(0x13, 0x20)]
    for register in [*holes, 8, 9, 10, 11]:
        assert await tb.crd(1, register) == 0xFF, f"offset {register:02X}"
    for register in [*holes, 12, 13, 14]:
        await tb.cwr(1, register, 0x5A)
    await tb.us(CONVERT_US + 2)
    assert [await tb.crd(1, r) for r in (0, 1, 4, 5, 6, 7, 12, 13, 14)] == before
    assert await tb.crd(1, PPI_CONTROL) == 0xFF
    assert [tb.volts(n) for n in range(6)] == [0] * 6


@test("PPI-1")
async def ports_after_reset_and_after_mode_set(dut):
    """Inputs after reset: port A floats; the mode word clears; port C bits 5-7 read 1."""
    tb = await Machine(dut).start()
    for card in range(3):
        await tb.cwr(card, PORT_A, 0x55)
        await tb.cwr(card, PPI_CONTROL, PPI_SETUP)
        assert await tb.crd(card, PORT_A) == 0
        assert await tb.crd(card, PORT_B) == 0
        assert await tb.crd(card, PORT_C) & 0xE0 == 0xE0
        await tb.cwr(card, PORT_A, 0x3C)
        await tb.cwr(card, PORT_B, 0x60)
        assert await tb.crd(card, PORT_A) == 0x3C and await tb.crd(card, PORT_B) == 0x60
        await tb.cwr(card, PPI_CONTROL, PPI_SETUP)
        assert await tb.crd(card, PORT_A) == 0 and await tb.crd(card, PORT_B) == 0


# --- encoders -----------------------------------------------------------------------------------


@machine_test("ENC-1")
async def encoders_count_at_full_speed(tb):
    """All six at once, 4 million counts/s, up and down, A leading B up."""
    for axis in range(6):
        await tb.preset(axis, 0x7FF0 + axis)
    moves = (37, -101, 64, -1, 255, -300)
    tasks = [cocotb.start_soon(e.move(m, NS_PER_COUNT)) for e, m in zip(tb.enc, moves, strict=True)]
    for task in tasks:
        await task
    await tb.us(1)
    for axis, move in enumerate(moves):
        assert await tb.encoder(axis) == (0x7FF0 + axis + move) & 0xFFFF, f"axis {axis}"


@machine_test("ENC-1")
async def encoder_wraps_both_ways(tb):
    await tb.preset(0, 0xFFFE)
    await tb.enc[0].move(5, NS_PER_COUNT)
    await tb.us(1)
    assert await tb.encoder(0) == 3
    await tb.enc[0].move(-9, NS_PER_COUNT)
    await tb.us(1)
    assert await tb.encoder(0) == 0xFFFA


@machine_test("ENC-1")
async def illegal_transitions_and_glitches(tb):
    """Both inputs at once count nothing; a glitch counts there and back or not at all."""
    await tb.preset(3, 100)
    for _ in range(5):
        tb.enc[3].jump()
        await tb.us(1)
    assert await tb.encoder(3) == 100
    for ns in (10, 60, 120, 130, 200, 260):
        for line in "ab":
            await tb.enc[3].glitch(ns, line)
            await tb.us(1)
            assert await tb.encoder(3) == 100, f"glitch of {ns} ns on {line}"


@machine_test("ENC-1")
@cocotb.parametrize(mode=[0, 1, 2, 3, 4, 5])
async def encoder_modes(tb, mode):
    """Two turns up, one down: hold, x1, x1, x2, x2, x4 by port A bits 2-0, for both joints."""
    await tb.cwr(0, PORT_A, mode)
    per_cycle = (0, 1, 1, 2, 2, 4)[mode]
    for axis in (0, 1):
        await tb.preset(axis, 0x4000)
        await tb.enc[axis].move(4 * 6, 500)
        await tb.us(1)
        assert await tb.encoder(axis) == 0x4000 + 6 * per_cycle
        await tb.enc[axis].move(-4 * 4, 500)
        await tb.us(1)
        assert await tb.encoder(axis) == 0x4000 + 2 * per_cycle


@machine_test("ENC-2")
async def read_is_one_sample_while_counting(tb):
    """MSB and LSB of one instant, across the carry, while the encoder runs."""
    await tb.preset(0, 0x00F0)
    last = 0x00F0
    task = cocotb.start_soon(tb.enc[0].move(400, 300))
    for _ in range(60):
        value = await tb.encoder(0)
        assert last <= value <= last + 40, f"{last:04X} then {value:04X}"
        last = value
    await task


@machine_test("ENC-2", "LAT-1")
async def first_read_after_a_latch_is_the_latched_count(tb):
    for axis in range(6):
        await tb.preset(axis, 10 * axis)
    await pulse(tb)
    for axis in range(6):
        await tb.enc[axis].move(7, 300)
    await tb.us(1)
    assert [await tb.encoder(a) for a in range(6)] == [10 * a for a in range(6)]
    assert [await tb.encoder(a) for a in range(6)] == [10 * a + 7 for a in range(6)]


@machine_test("DIA-2", b=B_TO_JOINT)
async def synthetic_encoder(tb):
    """Port B0 = 0: both chips see port A5-A7, the joints are not heard."""
    for axis in (0, 1):
        await tb.preset(axis, 50)
    await tb.enc[0].move(9, 300)
    for a, b in ((1, 0), (1, 1), (0, 1), (0, 0), (1, 0)):
        await tb.cwr(0, PORT_A, QUAD | a << 5 | b << 6)
    assert [await tb.encoder(a) for a in (0, 1)] == [55, 55]
    for a, b in ((0, 0), (0, 1)):
        await tb.cwr(0, PORT_A, QUAD | a << 5 | b << 6)
    assert [await tb.encoder(a) for a in (0, 1)] == [53, 53]
    assert (tb.led(0, "a1"), tb.led(0, "b1")) == (1, 0), "the LEDs show the joint"
    await tb.cwr(0, PORT_A, 4 | 1 << 6)  # x2
    for axis in (0, 1):
        await tb.preset(axis, 50)
    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
        await tb.cwr(0, PORT_A, 4 | a << 5 | b << 6)
    assert [await tb.encoder(a) for a in (0, 1)] == [52, 52]


@machine_test("DIA-2", "CAL-1", b=B_TO_JOINT | B_INDEX)
async def synthetic_index(tb):
    assert not await tb.crd(1, PORT_C) & (C_INDEX1 | C_INDEX2)
    await tb.cwr(1, PORT_A, QUAD | 0x80)
    assert await tb.crd(1, PORT_C) & (C_INDEX1 | C_INDEX2) == C_INDEX1 | C_INDEX2
    assert not await tb.crd(0, PORT_C) & (C_INDEX1 | C_INDEX2)


# --- calibration --------------------------------------------------------------------------------


@machine_test("CAL-1")
@cocotb.parametrize(axis=[0, 3])
async def index_latches_flag_and_count(tb, axis):
    """At full speed; only while armed; later pulses latch again; disarming clears."""
    card, flag = axis // 2, (C_INDEX1, C_INDEX2)[axis % 2]
    await tb.preset(axis, 1000)
    await tb.enc[axis].index(500)
    assert not await tb.crd(card, PORT_C) & flag, "not armed"
    await tb.cwr(card, PORT_B, RUN | B_INDEX)
    assert not await tb.crd(card, PORT_C) & flag
    encoder = tb.enc[axis]
    encoder.lines, at_start = 5, encoder.count  # an index every 20 counts
    for way in (1, 1, -1):
        first = encoder.count
        await encoder.move(27 * way, NS_PER_COUNT)
        await tb.us(1)
        assert await tb.crd(card, PORT_C) & (C_INDEX1 | C_INDEX2) == flag
        marks = range(first + way, encoder.count + way, way)
        last = [count for count in marks if count % 20 == 0][-1]
        assert await tb.encoder(axis) == 1000 + last - at_start
        assert await tb.encoder(axis) == 1000 + encoder.count - at_start, "then the live count"
    await tb.cwr(card, PORT_B, RUN)
    assert not await tb.crd(card, PORT_C) & flag


@machine_test("CAL-1")
async def index_that_is_high_when_armed(tb):
    """The flag follows the level, as Table 5.1 says: it is set."""
    tb.enc[0].i.set(0, 1)
    await tb.us(1)
    await tb.cwr(0, PORT_B, RUN | B_INDEX)
    await tb.us(1)
    assert await tb.crd(0, PORT_C) & C_INDEX1
    await tb.cwr(0, PORT_B, RUN)
    assert not await tb.crd(0, PORT_C) & C_INDEX1


# --- D/A ----------------------------------------------------------------------------------------


@machine_test("DAC-1", "ANA-1")
async def dac_codes_and_volts(tb):
    """Offset binary, 20 V span; the low byte waits for the high nibble."""
    codes = (0x000, 0x001, 0x7FF, 0x800, 0x801, 0xFFF, 0x5A5, 0xA5A)
    for axis in range(6):
        for code in codes:
            before = tb.volts(axis)
            await tb.cwr(axis // 2, DAC1 + 2 * (axis % 2), code & 0xFF)
            assert tb.volts(axis) == before, "a low byte alone moved the output"
            await tb.cwr(axis // 2, DAC1 + 2 * (axis % 2) + 1, 0xF0 | code >> 8)
            assert tb.volts(axis) == volts_of(code), f"axis {axis} code {code:03X}"


@machine_test("DAC-1", "LAT-1")
async def dac_double_buffering(tb):
    """PB3 = 1: both outputs of the card move with the latch and not before; other cards do not."""
    await tb.cwr(1, PORT_B, RUN | B_DOUBLE)
    for n, code in enumerate((0x123, 0x456, 0xFED)):
        held = [tb.volts(a) for a in (2, 3)]
        await tb.dac(2, code)
        await tb.dac(3, code ^ 0xFFF)
        await tb.dac(0, code)
        assert tb.volts(0) == volts_of(code), "card 0 is single-buffered"
        assert [tb.volts(a) for a in (2, 3)] == held, f"sample {n} came early"
        await pulse(tb)
        await tb.clocks(3)
        assert [tb.volts(a) for a in (2, 3)] == [volts_of(code), volts_of(code ^ 0xFFF)]


@machine_test("DAC-1", "LAT-1", b=RUN | B_DOUBLE)
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
            assert [tb.volts(a) for a in range(6)] == [volts_of(last)] * 6
            assert len(set(moved)) == 1, "all outputs move in the same clock"
            assert tb.clks(moved[0] - edge) <= 2
        last = 0x300 + 0x111 * n
        moved.clear()
        for axis in range(6):
            await tb.dac(axis, last)
        assert not moved


@machine_test("LAT-1", "DAC-1", b=RUN | B_DOUBLE)
async def software_latch_updates_double_buffered_dacs(tb):
    """Jumper E023-E022 is fitted: 0x10 for its card, 0x12 for all."""
    for axis in range(6):
        await tb.dac(axis, 0x900)
    await tb.cwr(1, LATCH, 0)
    assert [tb.volts(a) for a in range(6)] == [0, 0, 0x1000, 0x1000, 0, 0]
    await tb.crd(7, LATCH_ALL)  # any card address, also one that is absent; a read as well
    assert [tb.volts(a) for a in range(6)] == [0x1000] * 6


# --- latch and A/D ------------------------------------------------------------------------------


@machine_test("LAT-1", "ADC-1")
@cocotb.parametrize(how=["sclock", "write", "read", "all"])
async def what_starts_a_conversion(tb, how):
    """SCLOCK starts all; 0x10 its card; 0x12 every card."""
    tb.inputs([0x1000 * (n + 1) for n in range(6)])
    expected = [0x800 + 0x100 * (n + 1) for n in range(6)]
    before = [await tb.adc(n) for n in range(6)]
    if how == "sclock":
        await pulse(tb)
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
    assert [await tb.adc(n) for n in range(6)] == [
        expected[n] if n in mine else before[n] for n in range(6)
    ]


@machine_test("LAT-1", b=B_REAL_ENC | B_TO_JOINT | B_DOUBLE)
async def port_b2_gates_sclock(tb):
    """PB2 = 0: SCLOCK neither latches, starts nor updates; software latches still do."""
    tb.inputs([0x2000] * 6)
    await tb.preset(0, 77)
    await tb.dac(0, 0xC00)
    await pulse(tb)
    await tb.enc[0].move(3, 300)
    await tb.us(1)
    assert await tb.encoder(0) == 80, "no latch: the live count"
    assert tb.volts(0) == 0
    assert await tb.crd(0, PORT_C) & C_DONE
    await tb.cwr(0, LATCH, 0)
    await tb.enc[0].move(3, 300)
    assert not await tb.crd(0, PORT_C) & C_DONE
    assert tb.volts(0) == volts_of(0xC00)
    assert [await tb.encoder(0), await tb.encoder(0)] == [80, 83]


@machine_test("LAT-1")
async def no_skew_between_cards(tb):
    """All six encoders run; SCLOCK and 0x12 take all counts on the same clock."""
    for axis in range(6):
        await tb.preset(axis, 0)
    stop = []

    async def run():
        while not stop:
            for e in tb.enc:
                e.step(1)
            await Timer(300, "ns")

    task = cocotb.start_soon(run())
    for how in ("sclock", "all", "sclock", "all"):
        await tb.us(3)
        if how == "sclock":
            await pulse(tb)
        else:
            await tb.cwr(0, LATCH_ALL, 0)
        counts = {await tb.encoder(a) for a in range(6)}
        assert len(counts) == 1, f"{how}: {counts}"
    stop.append(1)
    await task


@machine_test("ADC-1")
async def adc_timing_and_busy(tb):
    """25 us; the old sample is readable meanwhile; a start while busy is ignored."""
    tb.inputs([0x4000] * 6)
    await pulse(tb)
    await tb.us(CONVERT_US + 2)
    assert await tb.adc(0) == 0xC00
    tb.inputs([-0x4000] * 6)
    await pulse(tb)
    start = tb.now()
    assert await tb.adc(0) == 0xC00
    await tb.us(10)
    tb.inputs([0x7000] * 6)
    await pulse(tb)  # busy: neither restarts nor samples again
    assert await tb.adc(0) == 0xC00
    await Timer(round(start / 1000 + 22_500 - tb.now() / 1000), "ns")
    assert not await tb.crd(0, PORT_C) & C_DONE
    await tb.us(2)
    assert await tb.crd(0, PORT_C) & C_DONE
    assert [await tb.adc(n) for n in range(6)] == [0x400] * 6


@machine_test("ADC-1", "ANA-1")
async def adc_codes(tb):
    """Full scale, zero, half steps and clamping, six inputs at a time."""
    for volts in (
        [-32768, -32761, -32760, -17, -9, -8],
        [-7, 0, 7, 8, 9, 16],
        [32767, 32759, 32744, 32743, 16384, -16384],
    ):
        tb.inputs(volts)
        await tb.cwr(0, LATCH_ALL, 0)
        await tb.us(CONVERT_US + 1)
        for axis, v in enumerate(volts):
            nearest = {min(max((v + 32768 + r) // 16, 0), 4095) for r in (7, 8)}
            assert await tb.adc(axis) in nearest, f"{v}"


@machine_test("DIA-1", "DAC-1", "ADC-1")
async def analogue_loop(tb):
    """PB1 = 0: the A/D sees the D/A, the joint sees 0 V; the relay takes its time both ways."""
    tb.inputs([0x7000] * 6)
    codes = (0x000, 0x3FF, 0x800, 0x9AB, 0xFFF, 0x123)
    for axis, code in enumerate(codes):
        await tb.dac(axis, code)
    assert [tb.volts(n) for n in range(6)] == [volts_of(c) for c in codes]
    for card in range(3):
        await tb.cwr(card, PORT_B, RUN & ~B_TO_JOINT)
    await tb.us(RELAY_US + 2)
    assert [tb.volts(n) for n in range(6)] == [0] * 6
    await tb.cwr(0, LATCH_ALL, 0)
    await tb.us(CONVERT_US + 1)
    assert [await tb.adc(n) for n in range(6)] == list(codes)
    await tb.cwr(0, PORT_B, RUN)
    await tb.us(RELAY_US + 2)
    assert [tb.volts(n) for n in (0, 1, 2)] == [volts_of(0), volts_of(0x3FF), 0]


@machine_test("DIA-1")
async def relay_takes_its_time(dut, tb):
    await tb.dac(0, 0xFFF)
    await tb.cwr(0, PORT_B, RUN & ~B_TO_JOINT)
    await tb.us(RELAY_US + 2)
    await tb.cwr(0, PORT_B, RUN)
    start = tb.now()
    await dut.drive_v_o.value_change
    took = (tb.now() - start) / 1e6
    assert abs(took - RELAY_US) < 1.5, f"{took} us"
    await tb.clocks(1)
    assert tb.volts(0) == volts_of(0xFFF)


# --- lights -------------------------------------------------------------------------------------


@machine_test("LED-2")
async def card_leds(dut, tb):
    """Every LED follows its signal, on its own card only."""
    assert all(tb.led(c, "power") for c in range(3))
    for axis in range(6):
        card, joint = axis // 2, axis % 2 + 1
        for name, pins in (("a", tb.enc[axis].a), ("b", tb.enc[axis].b), ("i", tb.enc[axis].i)):
            for level in (1, 0):
                before = int(dut.card_leds_o.value)
                pins.set(axis, level)
                await tb.us(1)
                assert tb.led(card, f"{name}{joint}") == level
                assert bin(before ^ int(dut.card_leds_o.value)).count("1") == level or not level
    for card in range(3):
        for name, bit in (("gp1", 3), ("gp2", 4)):
            await tb.cwr(card, PORT_A, QUAD | 1 << bit)
            lit = [(c, n) for c in range(3) for n in ("gp1", "gp2") if tb.led(c, n)]
            assert lit == [(card, name)]
            await tb.cwr(card, PORT_A, QUAD)


@machine_test("HB-1", "LED-2")
async def heartbeat_leds_and_port_c(tb):
    """Writing a D/A low byte starts that axis's heartbeat; the high nibble does not."""
    for axis in range(6):
        card, joint = axis // 2, axis % 2
        await tb.cwr(card, DAC1 + 2 * joint + 1, 8)
        assert not await tb.crd(card, PORT_C) & C_BEAT1 << 2 * joint
        await tb.cwr(card, DAC1 + 2 * joint, 0)
        assert await tb.crd(card, PORT_C) & C_BEAT1 << 2 * joint
        assert tb.led(card, f"beat{joint + 1}")
    await tb.us(420)
    assert [await tb.crd(c, PORT_C) & 5 for c in range(3)] == [0, 0, 0]
    assert not any(tb.led(c, f"beat{j}") for c in range(3) for j in (1, 2))


# --- faults -------------------------------------------------------------------------------------


@machine_test("PCB-2", "CRD-1")
async def two_cards_with_one_address(dut, tb):
    """Card 2's DIP switch set like card 1's: data is the AND of both, both take writes."""
    await tb.cwr(1, PORT_A, 0xF5)
    await tb.cwr(2, PORT_A, 0x3D)
    dut.dip_i.value = dip(0, 1, 1)
    await tb.clocks(2)
    assert await tb.crd(1, PORT_A) == 0xF5 & 0x3D
    assert await tb.crd(2, PORT_A) == 0xFF
    await tb.cwr(1, PORT_A, 0x0D)
    dut.dip_i.value = dip(0, 1, 2)
    await tb.clocks(2)
    assert [await tb.crd(c, PORT_A) for c in range(3)] == [5, 0x0D, 0x0D]


@machine_test("CRD-1", "VME-4")
async def empty_slot(dut, tb):
    """Where no card is, or not any more, nobody drives the bus."""
    assert await tb.crd(3, PORT_A) == 0xFF
    dut.dip_i.value = dip(0, 15, 2)  # card 1 as good as out
    assert await tb.crd(1, PORT_A) == 0xFF
    assert await tb.crd(0, PORT_A) == QUAD and await tb.crd(2, PORT_A) == QUAD
