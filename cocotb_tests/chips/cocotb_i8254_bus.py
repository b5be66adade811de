# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""Programming and reading the 8254: formats, latches, read-back, null count, rewrites. §4.3.3."""

from cocotb_tests.chips.pit import BOTH, LSB, MSB, Pit
from cocotb_tests.chips.replay import Scripts, script
from cocotb_tests.lib.req import test

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)


@script(Pit, "PIT-1", "VME-5")
def register_3_reads_ff(s):
    s.program(2, 5)
    s.read(3, 0xFF)


class Bus(Scripts, of=Pit, req="PIT-1"):
    # Seed 0: everything zero; nothing counts before it is programmed
    power_up_is_quiet = "expect(out=0, d_o=0xFF, oe=0) pulse(5, mask=7) expect(out=0)"
    bus_floats_unless_read = """
        program(2, 5) step(rd_n=0, a=0) seen('CS# high', d_o=0xFF, oe=0) step(rd_n=1)
        step(cs_n=0) seen('RD# high', d_o=0xFF, oe=0) step(cs_n=1)"""
    write_needs_chip_select = """
        program(2, 3) step(2, wr_n=0, a=3, d=0x30) step(2, wr_n=1)
        out(1, note='the mode 0 word went elsewhere') 1:3 1:2 0:1"""
    write_takes_effect_when_the_strobe_ends = """
        program(2, 3) step(3, cs_n=0, wr_n=0, a=3, d=0x30) out(1, note='WR# still low')
        step(cs_n=1, wr_n=1) out(0, note='mode 0')"""
    write_ends_with_chip_select_too = """
        program(2, 3) step(2, cs_n=0, wr_n=0, a=3, d=0x30) step(cs_n=1) out(0) step(wr_n=1)
        out(0)"""
    last_data_of_the_strobe_counts = """
        cw(0, 4, rw=LSB) step(2, cs_n=0, wr_n=0, a=0, d=9) step(1, d=2) step(cs_n=1, wr_n=1, d=0)
        1:2 1:1 0:0"""
    lsb_only_format = """
        program(2, 0x12, rw=LSB) pulse() read(0, 0x12) read(0, 0x12, 'again the LSB')"""
    msb_only_format = """
        program(2, 0x3400, rw=MSB) pulse() read(0, 0x34) pulse() read(0, 0x33, '3400h - 1')"""
    two_byte_format_alternates = """
        program(2, 0x1234) pulse() read(0, 0x34) read(0, 0x12) read(0, 0x34) read(0, 0x12)"""
    # After 1234h in both bytes, an LSB-only count has MSB 0 and an MSB-only one LSB 0
    control_word_clears_the_other_byte = """
        program(2, 0x1234) pulse(2) program(4, 0x02, rw=LSB) 110 program(2, 0x1234)
        program(2, 0x0100, rw=MSB) pulse() latch(0) read(0, 0x01) pulse()
        read(0, 0x00, '0100h - 1')"""
    control_word_resets_the_byte_flip_flops = """
        program(2, 0x1234) pulse() read(0, 0x34) write(0, 0x77) cw(0, 2) count(0, 0x0506) pulse()
        read(0, 0x06) read(0, 0x05)"""
    # rd LSB, wr LSB, rd MSB, wr MSB of one counter is legal
    reads_and_writes_interleave = """
        program(4, 0x1234) pulse() read(0, 0x34) write(0, 0x78) read(0, 0x12) write(0, 0x56)
        1:5678 1:5677"""
    counters_program_in_any_order = """
        cw(0, 2) cw(1, 4) cw(2, 3) write(0, 3) write(2, 4) write(1, 2) write(2, 0) write(1, 0)
        write(0, 0) 1:3 1:2 0:1 1:3 golden('1:2 1:1 0:0', n=1) golden('1:4 1:2 0:4', n=2)"""
    count_latch_holds_until_read = """
        program(2, 0x1234) pulse(5) latch(0) pulse(0x40) value(0, 0x1230)
        value(0, 0x11F0, 'live again')"""
    second_count_latch_is_ignored = """
        program(2, 0x1234) pulse(5) latch(0) pulse(3) latch(0) value(0, 0x1230) value(0, 0x122D)"""
    latch_waits_for_both_bytes = """
        program(2, 0x1234) pulse(5) latch(0) read(0, 0x30) pulse(0x40) latch(0) read(0, 0x12)
        value(0, 0x11F0)"""
    latch_in_single_byte_format = """
        program(2, 0x50, rw=LSB) pulse(2) latch(0) pulse() read(0, 0x4F) read(0, 0x4E)"""
    # The low bits of a latch command are don't-care
    latch_does_not_change_the_mode = """
        program(2, 3) pulse() write(3, 0x0B) value(0, 3) 1:2 0:1 1:3 status(0, 1, 0, 0x34)"""
    # The flip-flop stays: the next byte is the MSB of the new latch, which frees it
    latch_between_the_bytes_of_a_read = """
        program(2, 0x1234) pulse() read(0, 0x34) latch(0) pulse(0x40) read(0, 0x12)
        value(0, 0x11F4)"""

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

    control_word_releases_the_latches = """
        program(2, 0x1234) pulse() read_back(0, count=True, status=True) program(4, 0x0042)
        pulse() value(0, 0x0042)"""

    def read_back_latches_several_counts(s):
        for n, value in enumerate((0x1111, 0x2222, 0x3333)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        s.write(3, 0xC0 | 0x10 | 0b1010)
        s.pulse(mask=7)
        s.value(0, 0x1111)
        s.value(1, 0x2221, "counter 1 was not selected")
        s.value(2, 0x3333)

    read_back_status_then_count = """
        program(3, 0x0104) pulse() read_back(0, count=True, status=True) pulse()
        read(0, 0xB6, 'status first') read(0, 0x04) read(0, 0x01) read(0, 0x02, 'live')"""
    status_comes_first_whatever_was_latched_first = """
        program(2, 0x0105) pulse() latch(0) read_back(0, status=True) read(0, 0xB4, 'status')
        value(0, 0x0105)"""
    # Reading status neither moves the byte flip-flop nor frees the latched count
    status_between_two_bytes = """
        program(2, 0x1234) pulse() latch(0) read(0, 0x34) status(0, 1, 0, 0x34) pulse(0x80)
        read(0, 0x12, 'still the latched MSB') value(0, 0x11B4)"""
    second_status_latch_is_ignored = """
        program(2, 3) read_back(0, status=True) 110 read_back(0, status=True)
        read(0, 0xF4, 'OUT and null count as of the first') status(0, 0, 0, 0x34)"""
    # COUNT# and STATUS# both high: no latch
    read_back_of_nothing = "program(2, 0x0205) pulse() write(3, 0xFE) pulse() value(0, 0x0204)"

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

    null_count_rises_and_falls = """
        cw(0, 2) status(0, 1, 1, 0x34, 'after the control word') count(0, 3)
        status(0, 1, 1, 0x34, 'after the count') pulse() status(0, 1, 0, 0x34, 'after the load')"""
    # The clock that loads the count is the one that latches: it is loaded
    status_latched_with_the_load = """
        program(2, 3) write(3, 0xE2, rise=1, fall=1) read(0, 0xB4, 'null count is 0 already')"""
    null_count_needs_the_second_byte = """
        program(4, 0x0105) pulse() write(0, 7) status(0, 1, 0, 0x38, 'one byte') write(0, 0)
        status(0, 1, 1, 0x38, 'both') pulse() status(0, 1, 0, 0x38, 'loaded')"""
    null_count_waits_for_the_reload = """
        program(2, 3) pulse(2) count(0, 4) status(0, 1, 1, 0x34) pulse()
        status(0, 0, 1, 0x34, 'the period is not over') pulse() status(0, 1, 0, 0x34, 'reloaded')"""
    null_count_waits_for_a_trigger = """
        program(1, 3) pulse(4) status(0, 1, 1, 0x32) trigger() pulse() status(0, 0, 0, 0x32)"""
    count_while_null_is_the_old_one = """
        program(2, 0x0050) pulse(3) cw(0, 2) value(0, 0x004E, 'CE keeps its value')
        count(0, 0x0099) value(0, 0x004E) pulse() value(0, 0x0099)"""
    control_word_disarms_counting = "program(2, 0x0050) pulse(3) cw(0, 2) 1:4E 1:4E 1:4E"

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
    # The NMOS part: OUT falls and counting stops with the first byte
    mode0_first_byte_stops_counting = """
        program(0, 5) 0:5 0:4 write(0, 3) 0:4 0:4 0:4 write(0, 0) 0:3 0:2 0:1 1:0 write(0, 2)
        out(0, note='OUT falls with the first byte') 0:0 0:0"""

    def mode0_first_byte_stops_after_a_late_load(s):
        """A count that waits for its CLK is loaded; the first byte of the next one stops it."""
        s.program(0, 5)
        s.write(0, 3)
        s.golden("0:3 0:3 0:3")  # CR_L has it already
        s.write(0, 0)
        s.golden("0:3 0:2 0:1 1:0")

    # Modes 2 and 3 reload at the end of a period whatever CR holds; NULL does not tell it
    reload_between_the_bytes_takes_the_mix = """
        program(2, 0x0103) cw(0, 2) count(0, 3) 1:3 1:2 0:1 write(0, 5) 1:5 1:4
        status(0, 1, 0, 0x34) write(0, 0) status(0, 1, 1, 0x34) 1:3 1:2 0:1 1:5
        status(0, 1, 0, 0x34)"""
    # Written while the last CLK is high: its fall ends the old count, and OUT stays low
    mode0_count_written_as_the_old_one_ends = """
        program(0, 2, rw=LSB) pulse(2) rise() count(0, 3) fall()
        out(0, note='the old count is over') 00011"""
    mode0_count_written_twice = "program(0, 9) count(0, 2) 0:2 0:1 1:0"
    # A count written after the CLK rise waits for the next rise and fall
    load_needs_a_full_pulse = """
        cw(0, 4) rise() count(0, 2) fall() status(0, 1, 1, 0x38, 'half a pulse is none') 1:2 1:1
        0:0"""
    # The write that ends in the very clock of a CLK pulse does not see that pulse
    write_in_the_clock_of_the_rise_waits = """
        cw(0, 4) count(0, 2, rise=1, fall=1) status(0, 1, 1, 0x38) 1:2 1:1 0:0"""
    count_moves_on_the_fall = """
        program(2, 9) pulse() rise() latch(0) value(0, 9, 'after the rise') fall() latch(0)
        value(0, 8, 'after the fall')"""
    gate_is_sampled_on_the_rise = """
        program(0, 9) pulse() rise() gate(0) fall() latch(0)
        value(0, 8, 'GATE fell after the rise') rise() gate(1) fall() latch(0)
        value(0, 8, 'GATE rose after the rise')"""
    bcd_borrows_through_all_digits = """
        program(4, 0x1000, bcd=1) 1:1000 1:0999 1:0998 program(4, 0x2, bcd=1) 1:2 1:1 0:0 1:9999
        1:9998 program(4, 0x5010, bcd=1) pulse(12) latch(0) value(0, 0x4999)"""
    live_count_is_seen_while_rd_is_low = """
        program(2, 0x42, rw=LSB) pulse() step(cs_n=0, rd_n=0, a=0, rise=1, fall=1) step()
        seen(d_o=0x41) step() seen(d_o=0x40) step() seen(d_o=0x3F)
        step(cs_n=1, rd_n=1, rise=0, fall=0)"""
    # out_rise and out_fall are 1 in the very clock whose edge moves OUT
    edge_outputs_announce_out = """
        program(2, 2) pulse() seen(out=1, out_rise=0, out_fall=0) pulse()
        seen(out=1, out_rise=0, out_fall=1) pulse() seen(out=0, out_rise=1, out_fall=0) pulse()
        cw(0, 2) seen('a control word moves OUT without CLK', out=0, out_rise=1)"""


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
