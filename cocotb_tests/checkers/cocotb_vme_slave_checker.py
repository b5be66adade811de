# SPDX-License-Identifier: Apache-2.0
"""Each rule for a VME slave goes red for the fault it names, and for nothing else. §4.3.1"""

import cocotb

from cocotb_tests.checkers.drive import BENCH, Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "vme_slave_checker"


def read(data: int = 0x5A) -> str:
    """A read as it should be; ends with DTACK* still low."""
    return f"ds_ni=2 3 d_oe_o=1 d_o={data} 2 dtack_no=0 2"


RELEASE = "ds_ni=3 d_oe_o=0 d_o=0xFF 2 dtack_no=1 2"
# Reads, a write, an acknowledge that is passed on, and SYSRESET*, the one licence to let go early.
GOOD = f"""{read()} {RELEASE} {read(0)} {RELEASE}
    write_ni=0 ds_ni=0 3 dtack_no=0 2 {RELEASE}
    write_ni=1 iack_ni=0 ds_ni=2 iackout_no=0 4 iack_ni=1 ds_ni=3 iackout_no=1 2
    {read()} sysreset_ni=0 1 dtack_no=1 d_oe_o=0 2"""
FAULTS = {
    "dtack_alone": (0, "dtack_no=0 2 dtack_no=1 2"),
    "early_release": (1, f"{read()} dtack_no=1 2 ds_ni=3 d_oe_o=0 2"),
    "slow_release": (2, f"{read()} ds_ni=3 d_oe_o=0 4 dtack_no=1 1"),
    "drivers_stay": (3, f"{read()} ds_ni=3 1 d_oe_o=0 1 dtack_no=1 1"),
    "drive_on_write": (4, f"ds_ni=2 write_ni=0 3 d_oe_o=1 1 d_oe_o=0 2 dtack_no=0 2 {RELEASE}"),
    "data_moves": (5, f"{read()} d_o=0x5B 1 {RELEASE}"),
    "both_fates": (6, f"iack_ni=0 {read()} iackout_no=0 1 iackout_no=1 1 {RELEASE}"),
    "data_late": (7, f"ds_ni=2 3 d_oe_o=1 d_o=0x42 dtack_no=0 2 {RELEASE}"),
    "data_changes_with_dtack": (
        7, f"ds_ni=2 3 d_oe_o=1 d_o=0x42 2 d_o=0x43 dtack_no=0 2 {RELEASE}"),
}  # fmt: skip


@test("VME-3", "INT-2")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut, CHECKER), GOOD)


@test("VME-3", "INT-2")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    rule, stimulus = FAULTS[fault]
    await expect(Pins(dut, CHECKER), stimulus, rule)
