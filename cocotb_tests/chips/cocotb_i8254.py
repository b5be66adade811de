# SPDX-License-Identifier: Apache-2.0
"""The 8254: the rows of its sheet, and what counts clocks or is left to us. §4.3.3."""

from cocotb_tests.chips.pit import Pit
from cocotb_tests.chips.replay import Scripts, rows, script

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)


rows(__name__, Pit, lambda row: "PIT-1")


@script(Pit, "PIT-1", "VME-5")
def register_3_reads_ff(s):
    s.program(2, 5)
    s.read(3, 0xFF)


class Bus(Scripts, of=Pit, req="PIT-1"):
    # Seed 0: everything zero; nothing counts before it is programmed
    power_up_is_quiet = "expect(out=0, d_o=0xFF, oe=0) pulse(5, mask=7) expect(out=0)"
    write_ends_with_chip_select_too = """
        program(2, 3) step(2, cs_n=0, wr_n=0, a=3, d=0x30) step(cs_n=1) out(0) step(wr_n=1)
        out(0)"""
    # The clock that loads the count is the one that latches: it is loaded
    status_latched_with_the_load = """
        program(2, 3) write(3, 0xE2, rise=1, fall=1) read(0, 0xB4, 'null count is 0 already')"""
    # The write that ends in the very clock of a CLK pulse does not see that pulse
    write_in_the_clock_of_the_rise_waits = """
        cw(0, 4) write(0, 2) write(0, 0, rise=1, fall=1) status(0, 1, 1, 0x38) 1:2 1:1 0:0"""
    live_count_is_seen_while_rd_is_low = """
        program(2, 0x42, rw=LSB) pulse() step(cs_n=0, rd_n=0, a=0, rise=1, fall=1) step()
        seen(d_o=0x41) step() seen(d_o=0x40) step() seen(d_o=0x3F)
        step(cs_n=1, rd_n=1, rise=0, fall=0)"""
    # out_rise and out_fall are 1 in the very clock whose edge moves OUT
    edge_outputs_announce_out = """
        program(2, 2) pulse() seen(out=1, out_rise=0, out_fall=0) pulse()
        seen(out=1, out_rise=0, out_fall=1) pulse() seen(out=0, out_rise=1, out_fall=0) pulse()
        cw(0, 2) seen('a control word moves OUT without CLK', out=0, out_rise=1)"""


@script(Pit, "PIT-1", variant="chmos")
def both_bytes_of_a_count_are_taken_together(s):
    """The CHMOS part of the bench has SplitCr = 0: a trigger between them loads the old one."""
    s.cw(0, 1)
    s.count(0, 4)
    s.trigger()
    s.golden("0:4 0:3")
    s.write(0, 2)
    s.trigger()
    s.golden("0:4 0:3")
    s.write(0, 0)
    s.trigger()
    s.golden("0:2 0:1")


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
