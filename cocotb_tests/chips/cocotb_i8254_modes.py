# SPDX-License-Identifier: Apache-2.0
"""The six modes of the 8254: golden sequences, gates, shortest and longest counts. §4.3.3."""

from cocotb_tests.chips.pit import LSB, MSB, Pit, bcd
from cocotb_tests.chips.replay import Scripts

TOPLEVEL = "bench_i8254"
SOURCES = ("bench_i8254.sv", "bench_replay.sv")


class Modes(Scripts, of=Pit, req="PIT-1"):
    def mode0_golden_n3(s):
        s.cw(0, 0)
        s.out(0, note="OUT after the control word")
        s.count(0, 3)
        s.golden("0:3 0:2 0:1 1:0 1:FFFF 1:FFFE")

    def mode0_golden_n1(s):
        s.program(0, 1)
        s.golden("0:1 1:0 1:FFFF")

    def mode0_golden_bcd(s):
        s.program(0, bcd(10), bcd=1)
        s.golden("0:10 0:09 0:08 0:07 0:06 0:05 0:04 0:03 0:02 0:01 1:00 1:9999 1:9998")

    def mode0_zero_is_65536(s):
        s.program(0, 0)
        s.pulse(65536)
        s.out(0, note="one CLK before the end")
        s.pulse()
        s.out(1, note="N+1 CLKs after the write")

    def mode0_zero_is_10000_in_bcd(s):
        s.program(0, 0, bcd=1)
        s.pulse(10000)
        s.out(0)
        s.pulse()
        s.out(1)

    def mode0_gate_stops_the_count_not_out(s):
        s.program(0, 4)
        s.golden("0:4 0:3")
        s.gate(0)
        s.golden("0:3 0:3 0:3")
        s.gate(1)
        s.golden("0:2 0:1 1:0")
        s.gate(0)
        s.golden("1:0 1:0")

    def mode0_loads_while_gate_is_low(s):
        """Loaded on the next CLK all the same; OUT rises N CLKs after GATE, no extra one."""
        s.cw(0, 0)
        s.gate(0)
        s.count(0, 3)
        s.golden("0:3 0:3")
        s.gate(1)
        s.golden("0:2 0:1 1:0")

    def mode0_new_count_lowers_out(s):
        s.program(0, 2)
        s.outs("001")
        s.count(0, 3)
        s.out(0, note="OUT after the new count")
        s.golden("0:3 0:2 0:1 1:0")

    def mode1_golden_n3(s):
        s.program(1, 3)
        s.out(1)
        s.trigger()
        s.golden("0:3 0:2 0:1 1:0 1:FFFF")

    def mode1_shortest_pulse(s):
        s.program(1, 1)
        s.trigger()
        s.golden("0:1 1:0 1:FFFF")

    def mode1_without_trigger_stays_high(s):
        """As on the adaptor, where GATE is tied high."""
        s.program(1, 2)
        s.outs("11111111")

    def mode1_retrigger_extends(s):
        s.program(1, 4)
        s.trigger()
        s.golden("0:4 0:3 0:2")
        s.trigger()
        s.golden("0:4 0:3 0:2 0:1 1:0")

    def mode1_new_count_waits_for_a_trigger(s):
        s.program(1, 3)
        s.trigger()
        s.golden("0:3 0:2")
        s.count(0, 5)
        s.golden("0:1 1:0 1:FFFF")
        s.trigger()
        s.golden("0:5 0:4 0:3 0:2 0:1 1:0")

    def mode1_gate_low_does_not_stop(s):
        s.program(1, 3)
        s.trigger()
        s.golden("0:3")
        s.gate(0)
        s.golden("0:2 0:1 1:0")

    def mode1_trigger_before_the_count_is_ignored(s):
        s.cw(0, 1)
        s.trigger()
        s.count(0, 2)
        s.outs("1111")

    def mode1_short_gate_pulse_is_not_lost(s):
        """GATE up and down again before the CLK rise: the flip-flop remembers it."""
        s.gate(0)
        s.program(1, 2)
        s.gate(1)
        s.gate(0)
        s.step(3)
        s.golden("0:2 0:1 1:0")

    def mode2_golden_n3(s):
        s.cw(0, 2)
        s.out(1)
        s.count(0, 3)
        s.golden("1:3 1:2 0:1 1:3 1:2 0:1 1:3")

    def mode2_golden_n2(s):
        s.program(2, 2)
        s.golden("1:2 0:1 1:2 0:1")

    def mode2_one_acts_as_two(s):
        s.program(2, 1)
        s.golden("1:2 0:1 1:2 0:1")

    def mode2_bcd(s):
        s.program(2, bcd(11), bcd=1)
        s.golden("1:11 1:10 1:09 1:08 1:07 1:06 1:05 1:04 1:03 1:02 0:01 1:11")

    def mode2_zero_is_65536(s):
        s.program(2, 0)
        s.pulse(65535)
        s.out(1)
        s.pulse()
        s.out(0)
        s.pulse()
        s.out(1)

    def mode2_gate_low_raises_out_at_once(s):
        s.program(2, 3)
        s.outs("110")
        s.gate(0)
        s.out(1, note="no CLK needed")
        s.golden("1:1 1:1")
        s.gate(1)
        s.golden("1:3 1:2 0:1 1:3")

    def mode2_trigger_reloads(s):
        s.program(2, 4)
        s.golden("1:4 1:3")
        s.trigger()
        s.golden("1:4 1:3 1:2 0:1 1:4")

    def mode2_new_count_waits_for_the_period(s):
        s.program(2, 4)
        s.golden("1:4 1:3")
        s.count(0, 3)
        s.golden("1:2 0:1 1:3 1:2 0:1 1:3")

    def mode2_new_count_at_a_trigger(s):
        s.program(2, 9)
        s.golden("1:9 1:8")
        s.count(0, 3)
        s.trigger()
        s.golden("1:3 1:2 0:1 1:3")

    def mode2_is_also_mode6(s):
        s.program(6, 3)
        s.golden("1:3 1:2 0:1 1:3")
        s.status(0, 1, 0, 0x3C, "M2 is returned as written")

    def mode3_golden_n4(s):
        s.cw(0, 3)
        s.out(1)
        s.count(0, 4)
        s.golden("1:4 1:2 0:4 0:2 1:4 1:2 0:4 0:2")

    def mode3_golden_n2(s):
        s.program(3, 2)
        s.golden("1:2 0:2 1:2 0:2")

    def mode3_golden_n5(s):
        s.program(3, 5)
        s.golden("1:4 1:2 1:0 0:4 0:2 1:4 1:2 1:0 0:4")

    def mode3_golden_n3(s):
        s.program(3, 3)
        s.golden("1:2 1:0 0:2 1:2 1:0 0:2")

    def mode3_golden_bcd(s):
        s.program(3, bcd(10), bcd=1)
        s.golden("1:10 1:08 1:06 1:04 1:02 0:10 0:08 0:06 0:04 0:02 1:10")

    def mode3_zero_is_65536(s):
        s.program(3, 0)
        s.pulse(32768)
        s.out(1)
        s.pulse()
        s.out(0)
        s.pulse(32767)
        s.out(0)
        s.pulse()
        s.out(1)

    def mode3_one_acts_as_zero(s):
        s.program(3, 1, bcd=1)
        s.pulse(5000)
        s.out(1)
        s.pulse()
        s.out(0)
        s.pulse(5000)
        s.out(1)

    def mode3_gate_low_raises_out_at_once(s):
        s.program(3, 6)
        s.outs("1110")
        s.gate(0)
        s.out(1)
        s.golden("1:6 1:6")
        s.gate(1)
        s.golden("1:6 1:4 1:2 0:6")

    def mode3_new_count_at_the_half_cycle(s):
        s.program(3, 6)
        s.golden("1:6 1:4")
        s.count(0, 4)
        s.golden("1:2 0:4 0:2 1:4 1:2 0:4")

    def mode3_parity_is_latched_at_the_load(s):
        """An odd count written into an even half cycle must not disturb it, nor the other way."""
        s.program(3, 6)
        s.golden("1:6")
        s.count(0, 5)
        s.golden("1:4 1:2 0:4")
        s.count(0, 4)
        s.golden("0:2 1:4 1:2 0:4")
        s.count(0, 5)
        s.golden("0:2 1:4")
        s.count(0, 4)
        s.golden("1:2 1:0 0:4 0:2 1:4 1:2 0:4")

    def mode3_is_also_mode7(s):
        s.program(7, 4)
        s.golden("1:4 1:2 0:4 0:2 1:4")
        s.status(0, 1, 0, 0x3E)

    def mode4_golden_n3(s):
        s.cw(0, 4)
        s.out(1)
        s.count(0, 3)
        s.golden("1:3 1:2 1:1 0:0 1:FFFF")

    def mode4_golden_n1(s):
        s.program(4, 1)
        s.golden("1:1 0:0 1:FFFF")

    def mode4_gives_one_strobe_only(s):
        s.program(4, 2, rw=LSB)
        s.golden("1:2 1:1 0:0 1:FF")
        for _ in range(65540):
            s.pulse()
            s.out(1, note="no second strobe")

    def mode4_new_count_retriggers(s):
        s.program(4, 3)
        s.golden("1:3 1:2")
        s.count(0, 4)
        s.golden("1:4 1:3 1:2 1:1 0:0 1:FFFF")

    def mode4_first_byte_has_no_effect(s):
        s.program(4, 4)
        s.golden("1:4 1:3")
        s.write(0, 6)
        s.golden("1:2 1:1")
        s.write(0, 0)
        s.golden("1:6 1:5")

    def mode4_gate_stops_the_count(s):
        s.program(4, 2)
        s.golden("1:2")
        s.gate(0)
        s.golden("1:2 1:2")
        s.gate(1)
        s.golden("1:1 0:0")

    def mode4_strobe_ends_whatever_gate_is(s):
        s.program(4, 2)
        s.golden("1:2 1:1 0:0")
        s.gate(0)
        s.out(0, note="GATE has no effect on OUT")
        s.golden("1:0 1:0")

    def mode5_golden_n3(s):
        s.program(5, 3)
        s.trigger()
        s.golden("1:3 1:2 1:1 0:0 1:FFFF")

    def mode5_retrigger(s):
        s.program(5, 3)
        s.trigger()
        s.golden("1:3 1:2")
        s.trigger()
        s.golden("1:3 1:2 1:1 0:0 1:FFFF")

    def mode5_trigger_on_the_strobe_reloads(s):
        s.program(5, 1)
        s.trigger()
        s.golden("1:1 0:0")
        s.trigger()
        s.golden("1:1 0:0 1:FFFF")

    def mode5_without_trigger_never_strobes(s):
        s.program(5, 2)
        s.outs("1111111")

    def mode5_gate_level_does_not_matter(s):
        s.program(5, 3)
        s.trigger()
        s.gate(0)
        s.golden("1:3 1:2 1:1 0:0 1:FFFF")

    def msb_only_count_has_a_zero_low_byte(s):
        s.program(2, 0x0200, rw=MSB)
        s.pulse(512)
        s.out(0)
        s.pulse()
        s.out(1)

    def three_counters_run_apart(s):
        s.program(2, 3, n=0)
        s.program(3, 4, n=1)
        s.program(0, 2, n=2)
        for levels in ("110", "110", "001", "101", "111"):
            s.pulse(mask=7)
            for n in range(3):
                s.out(int(levels[n]), n)
