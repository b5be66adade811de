# SPDX-License-Identifier: Apache-2.0
"""Each rule of the edge checker goes red by what lasts a few nanoseconds between clock edges."""

import cocotb

from cocotb_tests.checkers.drive import BENCH, broken_by
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "vme_edge_checker"
NAMES = ["strobed", "dtack_ours", "stays", "off", "drive_ours", "inside", "fate"]
# Stimuli in ns. The last instant is judged by the next.
END = """ds_ni=3 d_oe_o=0 10 as_ni=1 iackin_ni=1 iackout_no=1 dtack_no=1 iack_ni=1 10
    a_i=0x1234 10"""
BEGIN = "10 as_ni=0 10 ds_ni=2 10"
OURS, OTHER = f"a_i={0x6001 >> 1}", f"a_i={0x2001 >> 1} {BEGIN}"
ANSWER = "d_oe_o=1 10 dtack_no=0 10"
READ = f"{OURS} {BEGIN} {ANSWER}"
ACKNOWLEDGE = f"a_i=5 iack_ni=0 {BEGIN} iackin_ni=0 10"
PASS = f"{ACKNOWLEDGE} iackout_no=0 10"
FAULTS = {
    "dtack_without_strobe": (["strobed", "dtack_ours"], "dtack_no=0 2"),
    "dtack_to_another": (["dtack_ours"], f"{OTHER} dtack_no=0 2"),
    # Our address is there, but the strobe fell under another's.
    "dtack_to_an_old_strobe": (["dtack_ours"], f"{OTHER} {OURS} 10 dtack_no=0 2"),
    "dtack_drops": (["stays"], f"{READ} dtack_no=1 2 dtack_no=0 2"),
    "drivers_linger": (["off"], f"{READ} ds_ni=3 2"),
    "drivers_for_another": (["drive_ours"], f"{OTHER} d_oe_o=1 2"),
    "pass_outlives_as": (["inside"], f"{PASS} as_ni=1 2"),
    "passed_then_answered": (["fate"], f"{PASS} iackout_no=1 2 d_oe_o=1 10 dtack_no=0 2"),
    "answered_then_passed": (["fate"], f"{ACKNOWLEDGE} {ANSWER} iackout_no=0 2"),
}


@test("VME-3", "INT-2")
async def what_is_right_breaks_nothing(dut):
    for stimulus in (READ, f"{ACKNOWLEDGE} {ANSWER}", PASS):
        assert await broken_by(dut, CHECKER, NAMES, f"{stimulus} {END}") == [], stimulus


@test("VME-3", "INT-2")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    rules, stimulus = FAULTS[fault]
    assert await broken_by(dut, CHECKER, NAMES, f"{stimulus} {END}") == rules
