# SPDX-License-Identifier: Apache-2.0
"""Each duty of a VME master goes red for the fault it names, and for nothing else. §4.3.1"""

import cocotb

from cocotb_tests.checkers.drive import BENCH, Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "vme_master_checker"
OURS = 0x6409 >> 1
BEGIN, BREAK_OFF = "1 as_ni=0 1 ds_ni=2 3", "as_ni=1 ds_ni=3"
END = f"dtack_no=0 2 {BREAK_OFF} iackin_ni=1 iack_ni=1 2 dtack_no=1 write_ni=1 2"
# The fourth is another board's and broken off: not ours to judge. BERR* ends the last.
GOOD = f"""{BEGIN} {END} write_ni=0 d_i=0x1234 {BEGIN} {END}
    a_i=5 iack_ni=0 {BEGIN} iackin_ni=0 2 {END}
    a_i=0x1000 {BEGIN} {BREAK_OFF} 1
    a_i={OURS} {BEGIN} 130 {BREAK_OFF} 3"""
FAULTS = {
    "strobe_without_as": (0, f"ds_ni=2 3 {END}"),
    "address_moves": (1, f"{BEGIN} a_i={0x640B >> 1} 1 {END}"),
    "modifier_moves": (1, f"{BEGIN} am_i=0x2D 1 {END}"),
    "write_moves": (2, f"{BEGIN} write_ni=0 1 {END}"),
    "data_moves": (3, f"write_ni=0 d_i=0x77 {BEGIN} d_i=0x78 1 {END}"),
    "strobe_withdrawn": (4, f"{BEGIN} {BREAK_OFF} 3"),
    "strobe_too_soon": (5, f"{BEGIN} dtack_no=0 2 ds_ni=3 1 ds_ni=2 1 {END}"),
    "second_strobe_late": (6, f"{BEGIN} ds_ni=0 2 {END}"),
    "iackin_without_cycle": (7, "iackin_ni=0 3 iackin_ni=1 2"),
}


@test("VME-3", "VME-6")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut, CHECKER, vme_a_i=OURS), GOOD)


@test("VME-3", "VME-6")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    rule, stimulus = FAULTS[fault]
    await expect(Pins(dut, CHECKER, vme_a_i=OURS), stimulus, rule)
