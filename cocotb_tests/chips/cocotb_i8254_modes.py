# SPDX-License-Identifier: Apache-2.0
"""The six modes of the 8254: golden sequences, gates, shortest and longest counts. §4.3.3."""

from cocotb_tests.chips.pit import LSB, Pit
from cocotb_tests.chips.replay import Scripts

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)


class Modes(Scripts, of=Pit, req="PIT-1"):
    mode0_golden_n3 = """
        cw(0, 0) out(0) count(0, 3) 0:3 0:2 0:1 1:0 1:FFFF
        1:FFFE"""
    mode0_golden_n1 = "program(0, 1) 0:1 1:0 1:FFFF"
    mode0_golden_bcd = """
        program(0, 0x10, bcd=1) 0:10 0:09 0:08 0:07 0:06 0:05 0:04 0:03 0:02 0:01 1:00 1:9999
        1:9998"""
    mode0_zero_is_65536 = """
        program(0, 0) pulse(65536) out(0) pulse()
        out(1)"""
    mode0_zero_is_10000_in_bcd = "program(0, 0, bcd=1) pulse(10000) out(0) pulse() out(1)"
    mode0_gate_stops_the_count_not_out = """
        program(0, 4) 0:4 0:3 gate(0) 0:3 0:3 0:3 gate(1) 0:2 0:1 1:0 gate(0) 1:0 1:0"""
    # Loaded on the next CLK all the same; OUT rises N CLKs after GATE, no extra one
    mode0_loads_while_gate_is_low = "cw(0, 0) gate(0) count(0, 3) 0:3 0:3 gate(1) 0:2 0:1 1:0"
    mode0_new_count_lowers_out = """
        program(0, 2) 001 count(0, 3) out(0) 0:3 0:2 0:1 1:0"""
    mode1_golden_n3 = "program(1, 3) out(1) trigger() 0:3 0:2 0:1 1:0 1:FFFF"
    mode1_shortest_pulse = "program(1, 1) trigger() 0:1 1:0 1:FFFF"
    # As on the adaptor, where GATE is tied high
    mode1_without_trigger_stays_high = "program(1, 2) 11111111"
    mode1_retrigger_extends = "program(1, 4) trigger() 0:4 0:3 0:2 trigger() 0:4 0:3 0:2 0:1 1:0"
    mode1_new_count_waits_for_a_trigger = """
        program(1, 3) trigger() 0:3 0:2 count(0, 5) 0:1 1:0 1:FFFF trigger() 0:5 0:4 0:3 0:2 0:1
        1:0"""
    mode1_gate_low_does_not_stop = "program(1, 3) trigger() 0:3 gate(0) 0:2 0:1 1:0"
    mode1_trigger_before_the_count_is_ignored = "cw(0, 1) trigger() count(0, 2) 1111"
    # GATE up and down again before the CLK rise: the flip-flop remembers it
    mode1_short_gate_pulse_is_not_lost = "gate(0) program(1, 2) gate(1) gate(0) step(3) 0:2 0:1 1:0"
    mode2_golden_n3 = "cw(0, 2) out(1) count(0, 3) 1:3 1:2 0:1 1:3 1:2 0:1 1:3"
    mode2_golden_n2 = "program(2, 2) 1:2 0:1 1:2 0:1"
    mode2_one_acts_as_two = "program(2, 1) 1:2 0:1 1:2 0:1"
    mode2_bcd = """
        program(2, 0x11, bcd=1) 1:11 1:10 1:09 1:08 1:07 1:06 1:05 1:04 1:03 1:02 0:01 1:11"""
    mode2_zero_is_65536 = "program(2, 0) pulse(65535) out(1) pulse() out(0) pulse() out(1)"
    mode2_gate_low_raises_out_at_once = """
        program(2, 3) 110 gate(0) out(1) 1:1 1:1 gate(1) 1:3 1:2 0:1 1:3"""
    mode2_trigger_reloads = "program(2, 4) 1:4 1:3 trigger() 1:4 1:3 1:2 0:1 1:4"
    mode2_new_count_waits_for_the_period = """
        program(2, 4) 1:4 1:3 count(0, 3) 1:2 0:1 1:3 1:2 0:1 1:3"""
    mode2_new_count_at_a_trigger = "program(2, 9) 1:9 1:8 count(0, 3) trigger() 1:3 1:2 0:1 1:3"
    mode2_is_also_mode6 = """
        program(6, 3) 1:3 1:2 0:1 1:3 status(0, 1, 0, 0x3C, 'M2 is returned as written')"""
    mode3_golden_n4 = "cw(0, 3) out(1) count(0, 4) 1:4 1:2 0:4 0:2 1:4 1:2 0:4 0:2"
    mode3_golden_n2 = "program(3, 2) 1:2 0:2 1:2 0:2"
    mode3_golden_n5 = "program(3, 5) 1:4 1:2 1:0 0:4 0:2 1:4 1:2 1:0 0:4"
    mode3_golden_n3 = "program(3, 3) 1:2 1:0 0:2 1:2 1:0 0:2"
    mode3_golden_bcd = """
        program(3, 0x10, bcd=1) 1:10 1:08 1:06 1:04 1:02 0:10 0:08 0:06 0:04 0:02 1:10"""
    mode3_zero_is_65536 = """
        program(3, 0) pulse(32768) out(1) pulse() out(0) pulse(32767) out(0) pulse() out(1)"""
    mode3_one_acts_as_zero = """
        program(3, 1, bcd=1) pulse(5000) out(1) pulse() out(0) pulse(5000) out(1)"""
    mode3_gate_low_raises_out_at_once = """
        program(3, 6) 1110 gate(0) out(1) 1:6 1:6 gate(1) 1:6 1:4 1:2 0:6"""
    mode3_new_count_at_the_half_cycle = "program(3, 6) 1:6 1:4 count(0, 4) 1:2 0:4 0:2 1:4 1:2 0:4"
    # An odd count written into an even half cycle must not disturb it, nor the other way
    mode3_parity_is_latched_at_the_load = """
        program(3, 6) 1:6 count(0, 5) 1:4 1:2 0:4 count(0, 4) 0:2 1:4 1:2 0:4 count(0, 5) 0:2 1:4
        count(0, 4) 1:2 1:0 0:4 0:2 1:4 1:2 0:4"""
    mode3_is_also_mode7 = "program(7, 4) 1:4 1:2 0:4 0:2 1:4 status(0, 1, 0, 0x3E)"
    mode4_golden_n3 = "cw(0, 4) out(1) count(0, 3) 1:3 1:2 1:1 0:0 1:FFFF"
    mode4_golden_n1 = "program(4, 1) 1:1 0:0 1:FFFF"

    def mode4_gives_one_strobe_only(s):
        s.program(4, 2, rw=LSB)
        s.golden("1:2 1:1 0:0 1:FF")
        for _ in range(65540):
            s.pulse()
            s.out(1, note="no second strobe")

    mode4_new_count_retriggers = "program(4, 3) 1:3 1:2 count(0, 4) 1:4 1:3 1:2 1:1 0:0 1:FFFF"
    mode4_first_byte_has_no_effect = "program(4, 4) 1:4 1:3 write(0, 6) 1:2 1:1 write(0, 0) 1:6 1:5"
    mode4_gate_stops_the_count = "program(4, 2) 1:2 gate(0) 1:2 1:2 gate(1) 1:1 0:0"
    mode4_strobe_ends_whatever_gate_is = """
        program(4, 2) 1:2 1:1 0:0 gate(0) out(0) 1:0 1:0"""
    mode5_golden_n3 = "program(5, 3) trigger() 1:3 1:2 1:1 0:0 1:FFFF"
    mode5_retrigger = "program(5, 3) trigger() 1:3 1:2 trigger() 1:3 1:2 1:1 0:0 1:FFFF"
    mode5_trigger_on_the_strobe_reloads = "program(5, 1) trigger() 1:1 0:0 trigger() 1:1 0:0 1:FFFF"
    mode5_without_trigger_never_strobes = "program(5, 2) 1111111"
    mode5_gate_level_does_not_matter = "program(5, 3) trigger() gate(0) 1:3 1:2 1:1 0:0 1:FFFF"
    msb_only_count_has_a_zero_low_byte = """
        program(2, 0x0200, rw=MSB) pulse(512) out(0) pulse() out(1)"""

    def three_counters_run_apart(s):
        s.program(2, 3, n=0)
        s.program(3, 4, n=1)
        s.program(0, 2, n=2)
        for levels in ("110", "110", "001", "101", "111"):
            s.pulse(mask=7)
            for n in range(3):
                s.out(int(levels[n]), n)
