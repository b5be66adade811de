# SPDX-License-Identifier: Apache-2.0
"""Each limit of the VME tables goes red just past it, and holds just at it. §4.3.1"""

import cocotb

from cocotb_tests.checkers.drive import BENCH, broken_by
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "vme_timing"
NAMES = [
    "addr_setup", "as_high", "write_setup", "data_setup", "as_to_ds", "ds_skew", "ds_high",
    "addr_hold", "data_hold", "strobe_hold", "next_strobe", "ds_to_dtack", "answer",
    "data_to_dtack", "data_off", "off_to_dtack", "dtack_rise", "iackout_rise", "irq_release",
]  # fmt: skip

# One exact cycle: every time of the table in ns, at its limit where it has one.
TIMES = {
    "setup": 10,
    "as_to_ds": 0,
    "ds_skew": 20,
    "ds_to_dtack": 30,
    "data_to_dtack": 0,
    "strobe_hold": 0,
    "data_off": 0,
    "off_to_dtack": 0,
    "high": 30,  # AS* and DS* between cycles
}


def cycle(address: int = 0x3204, write: bool = False, **times: float) -> str:
    """One cycle with both strobes, then the pause to the next."""
    t = TIMES | times
    # each cycle moves every line that has a set-up time
    begin = f"a_i={address} write_ni={1 - write} d_i={address & 0xFF} {t['setup']}"
    first, second = ("ds_ni=2", "as_ni=0") if t["as_to_ds"] < 0 else ("as_ni=0", "ds_ni=2")
    begin += f" {first} {abs(t['as_to_ds'])} {second} {t['ds_skew']} ds_ni=0"
    wait = t["ds_to_dtack"] - t["ds_skew"] - t["data_to_dtack"]
    data = "" if write else f"d_oe_o=1 d_o=0x5A {t['data_to_dtack']}"
    return (
        f"{begin} {wait} {data} dtack_no=0 {max(t['strobe_hold'], 1)} as_ni=1 ds_ni=3"
        f" {t['data_off']} d_oe_o=0 {max(t['off_to_dtack'], 1)} dtack_no=1"
        f" {t['high'] - 1 - t['setup'] - t['data_off']}"
    )


GOOD = " ".join(cycle(0x3204 + n, write=bool(n & 1)) for n in range(4))
# What a late release of the data does to its neighbours is a fault of its own.
ALSO = {"off_to_dtack": ["data_off", "off_to_dtack"]}
# strobe_hold cannot go red: without DTACK* there is nothing to measure from; the clocked checker
# of the master has that rule.
FAULTS = {
    "addr_setup": f"{cycle()} write_ni=1 21 a_i=0x3300 9.9 as_ni=0 1 as_ni=1",
    "as_high": f"{cycle()} 40 as_ni=0 50 as_ni=1 29.9 as_ni=0",
    "write_setup": f"{cycle()} 100 as_ni=0 20 write_ni=0 9.9 ds_ni=2",
    "data_setup": f"{cycle()} 100 as_ni=0 write_ni=0 20 d_i=0x77 9.9 ds_ni=2",
    "as_to_ds": cycle(as_to_ds=-10.1, ds_skew=5, ds_to_dtack=60),
    "ds_skew": cycle(ds_skew=20.1, ds_to_dtack=60),
    "ds_high": f"{cycle()} 50 as_ni=0 50 ds_ni=2 50 ds_ni=3 29.9 ds_ni=2",
    "addr_hold": "50 as_ni=0 ds_ni=2 50 a_i=0x3300 1 d_oe_o=1 dtack_no=0",
    "data_hold": "50 as_ni=0 write_ni=0 50 ds_ni=2 50 d_i=0x66 1 dtack_no=0",
    "next_strobe": "50 as_ni=0 ds_ni=2 50 d_oe_o=1 dtack_no=0 50 d_oe_o=0 ds_ni=3 50 ds_ni=2",
    "ds_to_dtack": cycle(ds_to_dtack=29.9),
    "answer": cycle(ds_to_dtack=16_001),
    "data_to_dtack": "50 as_ni=0 ds_ni=2 50 dtack_no=0 1 d_oe_o=1",
    "data_off": cycle(data_off=0.5, off_to_dtack=5),
    "off_to_dtack":
        "50 as_ni=0 ds_ni=2 50 d_oe_o=1 50 dtack_no=0 50 ds_ni=3 5 dtack_no=1 5 d_oe_o=0",
    "dtack_rise": "50 write_ni=0 50 as_ni=0 ds_ni=2 50 dtack_no=0 50 dtack_no=1",
    "iackout_rise":
        "50 iack_ni=0 50 as_ni=0 50 iackout_no=0 50 as_ni=1 iack_ni=1 40.1 iackout_no=1",
    "irq_release": "50 irq_no=0x6F 50 as_ni=0 ds_ni=2 50 as_ni=1 ds_ni=3 2000.1 irq_no=0x7F",
}  # fmt: skip


@test("VME-3")
async def limits_met_exactly_are_good(dut):
    assert await broken_by(dut, CHECKER, NAMES, GOOD) == []


@test("VME-3")
@cocotb.parametrize(name=list(FAULTS))
async def limit_goes_red(dut, name):
    assert await broken_by(dut, CHECKER, NAMES, FAULTS[name]) == (ALSO.get(name) or [name])
