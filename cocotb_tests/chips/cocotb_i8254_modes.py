# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""The six modes of the 8254: golden sequences, gates, shortest and longest counts. §4.3.3."""

import cocotb

from cocotb_tests.chips.pit import LSB, MSB, Pit, bcd
from cocotb_tests.lib.req import req

TOPLEVEL = "bench_i8254"
SOURCES = ("bench_i8254.sv", "bench_replay.sv")
PARAMETERS: dict = {}


@cocotb.test()
@req("PIT-1")
async def mode0_golden_n3(dut):
    s = Pit()
    s.cw(0, 0)
    s.out(0, note="OUT after the control word")
    s.count(0, 3)
    s.golden("0:3 0:2 0:1 1:0 1:FFFF 1:FFFE")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_golden_n1(dut):
    s = Pit()
    s.program(0, 1)
    s.golden("0:1 1:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_golden_bcd(dut):
    s = Pit()
    s.program(0, bcd(10), bcd=1)
    s.golden("0:10 0:09 0:08 0:07 0:06 0:05 0:04 0:03 0:02 0:01 1:00 1:9999 1:9998")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_zero_is_65536(dut):
    s = Pit()
    s.program(0, 0)
    s.pulse(65536)
    s.out(0, note="one CLK before the end")
    s.pulse()
    s.out(1, note="N+1 CLKs after the write")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_zero_is_10000_in_bcd(dut):
    s = Pit()
    s.program(0, 0, bcd=1)
    s.pulse(10000)
    s.out(0)
    s.pulse()
    s.out(1)
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_gate_stops_the_count_not_out(dut):
    s = Pit()
    s.program(0, 4)
    s.golden("0:4 0:3")
    s.gate(0)
    s.golden("0:3 0:3 0:3")
    s.gate(1)
    s.golden("0:2 0:1 1:0")
    s.gate(0)
    s.golden("1:0 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_loads_while_gate_is_low(dut):
    """Loaded on the next CLK all the same; OUT rises N CLKs after GATE, no extra one."""
    s = Pit()
    s.cw(0, 0)
    s.gate(0)
    s.count(0, 3)
    s.golden("0:3 0:3")
    s.gate(1)
    s.golden("0:2 0:1 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode0_new_count_lowers_out(dut):
    s = Pit()
    s.program(0, 2)
    s.outs("001")
    s.count(0, 3)
    s.out(0, note="OUT after the new count")
    s.golden("0:3 0:2 0:1 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_golden_n3(dut):
    s = Pit()
    s.program(1, 3)
    s.out(1)
    s.trigger()
    s.golden("0:3 0:2 0:1 1:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_shortest_pulse(dut):
    s = Pit()
    s.program(1, 1)
    s.trigger()
    s.golden("0:1 1:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_without_trigger_stays_high(dut):
    """As on the adaptor, where GATE is tied high."""
    s = Pit()
    s.program(1, 2)
    s.outs("11111111")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_retrigger_extends(dut):
    s = Pit()
    s.program(1, 4)
    s.trigger()
    s.golden("0:4 0:3 0:2")
    s.trigger()
    s.golden("0:4 0:3 0:2 0:1 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_new_count_waits_for_a_trigger(dut):
    s = Pit()
    s.program(1, 3)
    s.trigger()
    s.golden("0:3 0:2")
    s.count(0, 5)
    s.golden("0:1 1:0 1:FFFF")
    s.trigger()
    s.golden("0:5 0:4 0:3 0:2 0:1 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_gate_low_does_not_stop(dut):
    s = Pit()
    s.program(1, 3)
    s.trigger()
    s.golden("0:3")
    s.gate(0)
    s.golden("0:2 0:1 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_trigger_before_the_count_is_ignored(dut):
    s = Pit()
    s.cw(0, 1)
    s.trigger()
    s.count(0, 2)
    s.outs("1111")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode1_short_gate_pulse_is_not_lost(dut):
    """GATE up and down again before the CLK rise: the flip-flop remembers it."""
    s = Pit()
    s.gate(0)
    s.program(1, 2)
    s.gate(1)
    s.gate(0)
    s.step(3)
    s.golden("0:2 0:1 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_golden_n3(dut):
    s = Pit()
    s.cw(0, 2)
    s.out(1)
    s.count(0, 3)
    s.golden("1:3 1:2 0:1 1:3 1:2 0:1 1:3")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_golden_n2(dut):
    s = Pit()
    s.program(2, 2)
    s.golden("1:2 0:1 1:2 0:1")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_one_acts_as_two(dut):
    s = Pit()
    s.program(2, 1)
    s.golden("1:2 0:1 1:2 0:1")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_bcd(dut):
    s = Pit()
    s.program(2, bcd(11), bcd=1)
    s.golden("1:11 1:10 1:09 1:08 1:07 1:06 1:05 1:04 1:03 1:02 0:01 1:11")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_zero_is_65536(dut):
    s = Pit()
    s.program(2, 0)
    s.pulse(65535)
    s.out(1)
    s.pulse()
    s.out(0)
    s.pulse()
    s.out(1)
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_gate_low_raises_out_at_once(dut):
    s = Pit()
    s.program(2, 3)
    s.outs("110")
    s.gate(0)
    s.out(1, note="no CLK needed")
    s.golden("1:1 1:1")
    s.gate(1)
    s.golden("1:3 1:2 0:1 1:3")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_trigger_reloads(dut):
    s = Pit()
    s.program(2, 4)
    s.golden("1:4 1:3")
    s.trigger()
    s.golden("1:4 1:3 1:2 0:1 1:4")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_new_count_waits_for_the_period(dut):
    s = Pit()
    s.program(2, 4)
    s.golden("1:4 1:3")
    s.count(0, 3)
    s.golden("1:2 0:1 1:3 1:2 0:1 1:3")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_new_count_at_a_trigger(dut):
    s = Pit()
    s.program(2, 9)
    s.golden("1:9 1:8")
    s.count(0, 3)
    s.trigger()
    s.golden("1:3 1:2 0:1 1:3")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode2_is_also_mode6(dut):
    s = Pit()
    s.program(6, 3)
    s.golden("1:3 1:2 0:1 1:3")
    s.status(0, 1, 0, 0x3C, "M2 is returned as written")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_golden_n4(dut):
    s = Pit()
    s.cw(0, 3)
    s.out(1)
    s.count(0, 4)
    s.golden("1:4 1:2 0:4 0:2 1:4 1:2 0:4 0:2")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_golden_n2(dut):
    s = Pit()
    s.program(3, 2)
    s.golden("1:2 0:2 1:2 0:2")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_golden_n5(dut):
    s = Pit()
    s.program(3, 5)
    s.golden("1:4 1:2 1:0 0:4 0:2 1:4 1:2 1:0 0:4")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_golden_n3(dut):
    s = Pit()
    s.program(3, 3)
    s.golden("1:2 1:0 0:2 1:2 1:0 0:2")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_golden_bcd(dut):
    s = Pit()
    s.program(3, bcd(10), bcd=1)
    s.golden("1:10 1:08 1:06 1:04 1:02 0:10 0:08 0:06 0:04 0:02 1:10")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_zero_is_65536(dut):
    s = Pit()
    s.program(3, 0)
    s.pulse(32768)
    s.out(1)
    s.pulse()
    s.out(0)
    s.pulse(32767)
    s.out(0)
    s.pulse()
    s.out(1)
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_one_acts_as_zero(dut):
    s = Pit()
    s.program(3, 1, bcd=1)
    s.pulse(5000)
    s.out(1)
    s.pulse()
    s.out(0)
    s.pulse(5000)
    s.out(1)
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_gate_low_raises_out_at_once(dut):
    s = Pit()
    s.program(3, 6)
    s.outs("1110")
    s.gate(0)
    s.out(1)
    s.golden("1:6 1:6")
    s.gate(1)
    s.golden("1:6 1:4 1:2 0:6")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_new_count_at_the_half_cycle(dut):
    s = Pit()
    s.program(3, 6)
    s.golden("1:6 1:4")
    s.count(0, 4)
    s.golden("1:2 0:4 0:2 1:4 1:2 0:4")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_parity_is_latched_at_the_load(dut):
    """An odd count written into an even half cycle must not disturb it, nor the other way."""
    s = Pit()
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
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode3_is_also_mode7(dut):
    s = Pit()
    s.program(7, 4)
    s.golden("1:4 1:2 0:4 0:2 1:4")
    s.status(0, 1, 0, 0x3E)
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_golden_n3(dut):
    s = Pit()
    s.cw(0, 4)
    s.out(1)
    s.count(0, 3)
    s.golden("1:3 1:2 1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_golden_n1(dut):
    s = Pit()
    s.program(4, 1)
    s.golden("1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_gives_one_strobe_only(dut):
    s = Pit()
    s.program(4, 2, rw=LSB)
    s.golden("1:2 1:1 0:0 1:FF")
    for _ in range(65540):
        s.pulse()
        s.out(1, note="no second strobe")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_new_count_retriggers(dut):
    s = Pit()
    s.program(4, 3)
    s.golden("1:3 1:2")
    s.count(0, 4)
    s.golden("1:4 1:3 1:2 1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_first_byte_has_no_effect(dut):
    s = Pit()
    s.program(4, 4)
    s.golden("1:4 1:3")
    s.write(0, 6)
    s.golden("1:2 1:1")
    s.write(0, 0)
    s.golden("1:6 1:5")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_gate_stops_the_count(dut):
    s = Pit()
    s.program(4, 2)
    s.golden("1:2")
    s.gate(0)
    s.golden("1:2 1:2")
    s.gate(1)
    s.golden("1:1 0:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode4_strobe_ends_whatever_gate_is(dut):
    s = Pit()
    s.program(4, 2)
    s.golden("1:2 1:1 0:0")
    s.gate(0)
    s.out(0, note="GATE has no effect on OUT")
    s.golden("1:0 1:0")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode5_golden_n3(dut):
    s = Pit()
    s.program(5, 3)
    s.trigger()
    s.golden("1:3 1:2 1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode5_retrigger(dut):
    s = Pit()
    s.program(5, 3)
    s.trigger()
    s.golden("1:3 1:2")
    s.trigger()
    s.golden("1:3 1:2 1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode5_trigger_on_the_strobe_reloads(dut):
    s = Pit()
    s.program(5, 1)
    s.trigger()
    s.golden("1:1 0:0")
    s.trigger()
    s.golden("1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode5_without_trigger_never_strobes(dut):
    s = Pit()
    s.program(5, 2)
    s.outs("1111111")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def mode5_gate_level_does_not_matter(dut):
    s = Pit()
    s.program(5, 3)
    s.trigger()
    s.gate(0)
    s.golden("1:3 1:2 1:1 0:0 1:FFFF")
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def msb_only_count_has_a_zero_low_byte(dut):
    s = Pit()
    s.program(2, 0x0200, rw=MSB)
    s.pulse(512)
    s.out(0)
    s.pulse()
    s.out(1)
    await s.run(dut)


@cocotb.test()
@req("PIT-1")
async def three_counters_run_apart(dut):
    s = Pit()
    s.program(2, 3, n=0)
    s.program(3, 4, n=1)
    s.program(0, 2, n=2)
    for levels in ("110", "110", "001", "101", "111"):
        s.pulse(mask=7)
        for n in range(3):
            s.out(int(levels[n]), n)
    await s.run(dut)
