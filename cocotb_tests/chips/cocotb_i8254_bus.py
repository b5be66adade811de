# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""Programming and reading the 8254: formats, latches, read-back, null count, rewrites. §4.3.3."""

from cocotb_tests.chips.pit import BOTH, LSB, MSB, Pit, bcd
from cocotb_tests.chips.replay import Scripts, script
from cocotb_tests.lib.req import test

TOPLEVEL = "bench_i8254"
SOURCES = ("bench_i8254.sv", "bench_replay.sv")


@script(Pit, "PIT-1", "VME-5")
def register_3_reads_ff(s):
    s.program(2, 5)
    s.read(3, 0xFF)


class Bus(Scripts, of=Pit, req="PIT-1"):
    def power_up_is_quiet(s):
        """Seed 0: everything zero; nothing counts before it is programmed."""
        s.expect(out=0, d_o=0xFF, oe=0)
        s.pulse(5, mask=7)
        s.expect(out=0)

    def bus_floats_unless_read(s):
        s.program(2, 5)
        s.step(rd_n=0, a=0)
        s.seen("CS# high", d_o=0xFF, oe=0)
        s.step(rd_n=1)
        s.step(cs_n=0)
        s.seen("RD# high", d_o=0xFF, oe=0)
        s.step(cs_n=1)

    def write_needs_chip_select(s):
        s.program(2, 3)
        s.step(2, wr_n=0, a=3, d=0x30)
        s.step(2, wr_n=1)
        s.out(1, note="the mode 0 word went elsewhere")
        s.golden("1:3 1:2 0:1")

    def write_takes_effect_when_the_strobe_ends(s):
        s.program(2, 3)
        s.step(3, cs_n=0, wr_n=0, a=3, d=0x30)
        s.out(1, note="WR# still low")
        s.step(cs_n=1, wr_n=1)
        s.out(0, note="mode 0")

    def write_ends_with_chip_select_too(s):
        s.program(2, 3)
        s.step(2, cs_n=0, wr_n=0, a=3, d=0x30)
        s.step(cs_n=1)
        s.out(0)
        s.step(wr_n=1)
        s.out(0)

    def last_data_of_the_strobe_counts(s):
        s.cw(0, 4, rw=LSB)
        s.step(2, cs_n=0, wr_n=0, a=0, d=9)
        s.step(1, d=2)
        s.step(cs_n=1, wr_n=1, d=0)
        s.golden("1:2 1:1 0:0")

    def lsb_only_format(s):
        s.program(2, 0x12, rw=LSB)
        s.pulse()
        s.read(0, 0x12)
        s.read(0, 0x12, "again the LSB")

    def msb_only_format(s):
        s.program(2, 0x3400, rw=MSB)
        s.pulse()
        s.read(0, 0x34)
        s.pulse()
        s.read(0, 0x33, "3400h - 1")

    def two_byte_format_alternates(s):
        s.program(2, 0x1234)
        s.pulse()
        s.read(0, 0x34)
        s.read(0, 0x12)
        s.read(0, 0x34)
        s.read(0, 0x12)

    def control_word_clears_the_other_byte(s):
        """After 1234h in both bytes, an LSB-only count has MSB 0 and an MSB-only one LSB 0."""
        s.program(2, 0x1234)
        s.pulse(2)
        s.program(4, 0x02, rw=LSB)
        s.outs("110")
        s.program(2, 0x1234)
        s.program(2, 0x0100, rw=MSB)
        s.pulse()
        s.latch(0)
        s.read(0, 0x01)
        s.pulse()
        s.read(0, 0x00, "0100h - 1")

    def control_word_resets_the_byte_flip_flops(s):
        s.program(2, 0x1234)
        s.pulse()
        s.read(0, 0x34)
        s.write(0, 0x77)
        s.cw(0, 2)
        s.count(0, 0x0506)
        s.pulse()
        s.read(0, 0x06)
        s.read(0, 0x05)

    def reads_and_writes_interleave(s):
        """rd LSB, wr LSB, rd MSB, wr MSB of one counter is legal."""
        s.program(4, 0x1234)
        s.pulse()
        s.read(0, 0x34)
        s.write(0, 0x78)
        s.read(0, 0x12)
        s.write(0, 0x56)
        s.golden("1:5678 1:5677")

    def counters_program_in_any_order(s):
        s.cw(0, 2)
        s.cw(1, 4)
        s.cw(2, 3)
        s.write(0, 3)
        s.write(2, 4)
        s.write(1, 2)
        s.write(2, 0)
        s.write(1, 0)
        s.write(0, 0)
        s.golden("1:3 1:2 0:1 1:3")
        s.golden("1:2 1:1 0:0", n=1)
        s.golden("1:4 1:2 0:4", n=2)

    def count_latch_holds_until_read(s):
        s.program(2, 0x1234)
        s.pulse(5)
        s.latch(0)
        s.pulse(0x40)
        s.value(0, 0x1230)
        s.value(0, 0x11F0, "live again")

    def second_count_latch_is_ignored(s):
        s.program(2, 0x1234)
        s.pulse(5)
        s.latch(0)
        s.pulse(3)
        s.latch(0)
        s.value(0, 0x1230)
        s.value(0, 0x122D)

    def latch_waits_for_both_bytes(s):
        s.program(2, 0x1234)
        s.pulse(5)
        s.latch(0)
        s.read(0, 0x30)
        s.pulse(0x40)
        s.latch(0)
        s.read(0, 0x12)
        s.value(0, 0x11F0)

    def latch_in_single_byte_format(s):
        s.program(2, 0x50, rw=LSB)
        s.pulse(2)
        s.latch(0)
        s.pulse()
        s.read(0, 0x4F)
        s.read(0, 0x4E)

    def latch_does_not_change_the_mode(s):
        """The low bits of a latch command are don't-care."""
        s.program(2, 3)
        s.pulse()
        s.write(3, 0x0B)
        s.value(0, 3)
        s.golden("1:2 0:1 1:3")
        s.status(0, 1, 0, 0x34)

    def latch_between_the_bytes_of_a_read(s):
        """The flip-flop stays: the next byte is the MSB of the new latch, which frees it."""
        s.program(2, 0x1234)
        s.pulse()
        s.read(0, 0x34)
        s.latch(0)
        s.pulse(0x40)
        s.read(0, 0x12)
        s.value(0, 0x11F4)

    def latches_of_three_counters_are_apart(s):
        for n, value in enumerate((0x1111, 0x2222, 0x3333)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        s.latch(0)
        s.pulse(mask=7)
        s.latch(2)
        s.pulse(mask=7)
        s.value(1, 0x2220)
        s.value(2, 0x3332)
        s.value(0, 0x1111)

    def control_word_releases_the_latches(s):
        s.program(2, 0x1234)
        s.pulse()
        s.read_back(0, count=True, status=True)
        s.program(4, 0x0042)
        s.pulse()
        s.value(0, 0x0042)

    def read_back_latches_several_counts(s):
        for n, value in enumerate((0x1111, 0x2222, 0x3333)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        s.write(3, 0xC0 | 0x10 | 0b1010)
        s.pulse(mask=7)
        s.value(0, 0x1111)
        s.value(1, 0x2221, "counter 1 was not selected")
        s.value(2, 0x3333)

    def read_back_status_then_count(s):
        s.program(3, 0x0104)
        s.pulse()
        s.read_back(0, count=True, status=True)
        s.pulse()
        s.read(0, 0xB6, "status first")
        s.read(0, 0x04)
        s.read(0, 0x01)
        s.read(0, 0x02, "live")

    def status_comes_first_whatever_was_latched_first(s):
        s.program(2, 0x0105)
        s.pulse()
        s.latch(0)
        s.read_back(0, status=True)
        s.read(0, 0xB4, "status")
        s.value(0, 0x0105)

    def status_between_two_bytes(s):
        """Reading status neither moves the byte flip-flop nor frees the latched count."""
        s.program(2, 0x1234)
        s.pulse()
        s.latch(0)
        s.read(0, 0x34)
        s.status(0, 1, 0, 0x34)
        s.pulse(0x80)
        s.read(0, 0x12, "still the latched MSB")
        s.value(0, 0x11B4)

    def second_status_latch_is_ignored(s):
        s.program(2, 3)
        s.read_back(0, status=True)
        s.outs("110")
        s.read_back(0, status=True)
        s.read(0, 0xF4, "OUT and null count as of the first")
        s.status(0, 0, 0, 0x34)

    def read_back_of_nothing(s):
        """COUNT# and STATUS# both high: no latch."""
        s.program(2, 0x0205)
        s.pulse()
        s.write(3, 0xFE)
        s.pulse()
        s.value(0, 0x0204)

    def read_back_table_of_the_data_sheet(s):
        """Six read-back commands in order; what a latch already holds is not replaced."""
        for n, value in enumerate((0x1010, 0x2020, 0x3030)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        for command in (0xC2, 0xE4, 0xEC, 0xD8, 0xC4, 0xE2):
            s.write(3, command)
            s.pulse(mask=7)
        s.read(1, 0xB4, "status 1 as of E4h")
        s.value(1, 0x201C, "count 1 as of C4h")
        s.read(2, 0xB4, "status 2 as of ECh")
        s.value(2, 0x302D, "count 2 as of D8h")
        s.read(0, 0xB4, "status 0 as of C2h")
        s.value(0, 0x1010, "count 0 as of C2h")

    def status_returns_the_control_word(s):
        for rw in (LSB, MSB, BOTH):
            for mode in range(8):
                for bcd_bit in (0, 1):
                    s.cw(1, mode, rw, bcd_bit)
                    low = rw << 4 | mode << 1 | bcd_bit
                    s.status(1, int(mode != 0), 1, low, f"status of {low:#x}")

    def null_count_rises_and_falls(s):
        s.cw(0, 2)
        s.status(0, 1, 1, 0x34, "after the control word")
        s.count(0, 3)
        s.status(0, 1, 1, 0x34, "after the count")
        s.pulse()
        s.status(0, 1, 0, 0x34, "after the load")

    def status_latched_with_the_load(s):
        """The clock that loads the count is the one that latches: it is loaded."""
        s.program(2, 3)
        s.write(3, 0xE2, rise=1, fall=1)
        s.read(0, 0xB4, "null count is 0 already")

    def null_count_needs_the_second_byte(s):
        s.program(4, 0x0105)
        s.pulse()
        s.write(0, 7)
        s.status(0, 1, 0, 0x38, "one byte")
        s.write(0, 0)
        s.status(0, 1, 1, 0x38, "both")
        s.pulse()
        s.status(0, 1, 0, 0x38, "loaded")

    def null_count_waits_for_the_reload(s):
        s.program(2, 3)
        s.pulse(2)
        s.count(0, 4)
        s.status(0, 1, 1, 0x34)
        s.pulse()
        s.status(0, 0, 1, 0x34, "the period is not over")
        s.pulse()
        s.status(0, 1, 0, 0x34, "reloaded")

    def null_count_waits_for_a_trigger(s):
        s.program(1, 3)
        s.pulse(4)
        s.status(0, 1, 1, 0x32)
        s.trigger()
        s.pulse()
        s.status(0, 0, 0, 0x32)

    def count_while_null_is_the_old_one(s):
        s.program(2, 0x0050)
        s.pulse(3)
        s.cw(0, 2)
        s.value(0, 0x004E, "CE keeps its value")
        s.count(0, 0x0099)
        s.value(0, 0x004E)
        s.pulse()
        s.value(0, 0x0099)

    def control_word_disarms_counting(s):
        s.program(2, 0x0050)
        s.pulse(3)
        s.cw(0, 2)
        s.golden("1:4E 1:4E 1:4E")

    def initial_out_of_each_mode(s):
        for mode in (0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7):
            s.cw(0, mode)
            s.out(int(mode != 0), note=f"mode {mode}, no CLK")


@test("PIT-1")
async def control_word_in_the_low_phase(dut):
    """Mode set while OUT is low, in modes 2, 3, 4, 5: OUT rises at once, no CLK."""
    for mode, pulses in ((2, 3), (3, 3), (4, 4), (5, 4)):
        s = Pit()
        s.program(mode, 3)
        s.trigger()
        s.pulse(pulses)
        s.out(0, note=f"mode {mode}")
        s.cw(0, mode)
        s.out(1, note=f"mode {mode} again")
        await s.run(dut)


@script(Pit, "PIT-1", chmos=True)
def mode0_first_byte_in_chmos(s):
    """The CHMOS part: OUT falls with the first byte; counting stops, but not after a rollover."""
    s.program(0, 5)
    s.golden("0:5 0:4")
    s.write(0, 9)
    s.golden("0:4 0:4")
    s.write(0, 0)
    s.golden("0:9 0:8")
    s.count(0, 1)
    s.golden("0:1 1:0")
    s.write(0, 2)
    s.golden("0:0 0:0")
    s.write(0, 0)
    s.golden("0:2 0:1 1:0 1:FFFF")
    s.write(0, 7)
    s.golden("0:FFFE 0:FFFD")
    s.write(0, 0)
    s.golden("0:7 0:6")


@test("PIT-1")
async def first_of_two_bytes_is_in_the_count_register_at_once(dut):
    """CR_L and CR_M are loaded one at a time: a trigger between the bytes loads the mix."""
    for chmos, mixed in ((False, "0:2 0:1"), (True, "0:4 0:3")):  # that one has SplitCr = 0
        s = Pit(chmos=chmos)
        s.cw(0, 1)
        s.count(0, 4)
        s.trigger()
        s.golden("0:4 0:3")
        s.write(0, 2)
        s.trigger()
        s.golden(mixed)
        s.write(0, 0)
        s.trigger()
        s.golden("0:2 0:1")
        await s.run(dut)


class Edges(Scripts, of=Pit, req="PIT-1"):
    def mode0_first_byte_stops_counting(s):
        """The NMOS part: OUT falls and counting stops with the first byte."""
        s.program(0, 5)
        s.golden("0:5 0:4")
        s.write(0, 3)
        s.golden("0:4 0:4 0:4")
        s.write(0, 0)
        s.golden("0:3 0:2 0:1 1:0")
        s.write(0, 2)
        s.out(0, note="OUT falls with the first byte")
        s.golden("0:0 0:0")

    def mode0_first_byte_stops_after_a_late_load(s):
        """A count that waits for its CLK is loaded; the first byte of the next one stops it."""
        s.program(0, 5)
        s.write(0, 3)
        s.golden("0:3 0:3 0:3")  # CR_L has it already
        s.write(0, 0)
        s.golden("0:3 0:2 0:1 1:0")

    def reload_between_the_bytes_takes_the_mix(s):
        """Modes 2 and 3 reload at the end of a period whatever CR holds; NULL does not tell it."""
        s.program(2, 0x0103)
        s.cw(0, 2)
        s.count(0, 3)
        s.golden("1:3 1:2 0:1")
        s.write(0, 5)
        s.golden("1:5 1:4")
        s.status(0, 1, 0, 0x34)
        s.write(0, 0)
        s.status(0, 1, 1, 0x34)
        s.golden("1:3 1:2 0:1 1:5")
        s.status(0, 1, 0, 0x34)

    def mode0_count_written_as_the_old_one_ends(s):
        """Written while the last CLK is high: its fall ends the old count, and OUT stays low."""
        s.program(0, 2, rw=LSB)
        s.pulse(2)
        s.rise()
        s.count(0, 3)
        s.fall()
        s.out(0, note="the old count is over")
        s.outs("00011")

    def mode0_count_written_twice(s):
        s.program(0, 9)
        s.count(0, 2)
        s.golden("0:2 0:1 1:0")

    def load_needs_a_full_pulse(s):
        """A count written after the CLK rise waits for the next rise and fall."""
        s.cw(0, 4)
        s.rise()
        s.count(0, 2)
        s.fall()
        s.status(0, 1, 1, 0x38, "half a pulse is none")
        s.golden("1:2 1:1 0:0")

    def write_in_the_clock_of_the_rise_waits(s):
        """The write that ends in the very clock of a CLK pulse does not see that pulse."""
        s.cw(0, 4)
        s.count(0, 2, rise=1, fall=1)
        s.status(0, 1, 1, 0x38)
        s.golden("1:2 1:1 0:0")

    def count_moves_on_the_fall(s):
        s.program(2, 9)
        s.pulse()
        s.rise()
        s.latch(0)
        s.value(0, 9, "after the rise")
        s.fall()
        s.latch(0)
        s.value(0, 8, "after the fall")

    def gate_is_sampled_on_the_rise(s):
        s.program(0, 9)
        s.pulse()
        s.rise()
        s.gate(0)
        s.fall()
        s.latch(0)
        s.value(0, 8, "GATE fell after the rise")
        s.rise()
        s.gate(1)
        s.fall()
        s.latch(0)
        s.value(0, 8, "GATE rose after the rise")

    def bcd_borrows_through_all_digits(s):
        s.program(4, bcd(1000), bcd=1)
        s.golden("1:1000 1:0999 1:0998")
        s.program(4, bcd(2), bcd=1)
        s.golden("1:2 1:1 0:0 1:9999 1:9998")
        s.program(4, bcd(5010), bcd=1)
        s.pulse(12)
        s.latch(0)
        s.value(0, bcd(4999))

    def live_count_is_seen_while_rd_is_low(s):
        s.program(2, 0x42, rw=LSB)
        s.pulse()
        s.step(cs_n=0, rd_n=0, a=0, rise=1, fall=1)
        for want in (0x41, 0x40, 0x3F):
            s.step()
            s.seen(d_o=want)
        s.step(cs_n=1, rd_n=1, rise=0, fall=0)

    def edge_outputs_announce_out(s):
        """out_rise and out_fall are 1 in the very clock whose edge moves OUT."""
        s.program(2, 2)
        s.pulse()
        s.seen(out=1, out_rise=0, out_fall=0)
        s.pulse()
        s.seen(out=1, out_rise=0, out_fall=1)
        s.pulse()
        s.seen(out=0, out_rise=1, out_fall=0)
        s.pulse()
        s.cw(0, 2)
        s.seen("a control word moves OUT without CLK", out=0, out_rise=1)


@script(Pit, "PIT-1", "PIT-2", cascade=True)
def cascade_golden(s):
    """Modes 2 and 2, 4 times 3. OUT1 changes only where OUT0 falls."""
    s.program(2, 3, n=1)
    s.program(2, 4, n=0)
    pairs = "11 11 11 01 11 11 11 01 11 11 11 00 10 10 10 01 11 11 11 01 11 11 11 00 10 10 10 01"
    for at, pair in enumerate(pairs.split()):
        s.pulse()
        s.out(int(pair[0]), 0, f"OUT0 after CLK {at + 1}")
        s.out(int(pair[1]), 1, f"OUT1 after CLK {at + 1}")


@script(Pit, "PIT-1", "PIT-2", cascade=True)
def cascade_needs_a_rise_after_the_count(s):
    """Counter 1 programmed last: OUT0 is high already, so its first fall does not load yet."""
    s.program(2, 4, n=0)
    s.program(2, 3, n=1)
    s.pulse(15)
    s.out(1, 1)
    s.pulse()
    s.out(0, 1, "one OUT0 period later than in the golden sequence")


@script(Pit, "PIT-1", "PIT-2", cascade=True)
def cascade_of_three_moves_in_one_clock(s):
    """Timer 2 counts SCLOCK: all three chains of OUT edges fall into one clock."""
    s.program(2, 0, n=2)
    s.program(2, 2, n=1)
    s.program(2, 2, n=0)
    s.pulse(4 * 6 + 1)
    s.latch(2)
    first = 0x10000 - 5
    s.value(2, first & 0xFFFF, "count after six SCLOCKs, the first loads")
