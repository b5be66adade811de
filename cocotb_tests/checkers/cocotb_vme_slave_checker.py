# SPDX-License-Identifier: Apache-2.0
"""Each rule for a VME slave goes red for the fault it names, and for nothing else. §4.3.1"""

import cocotb

from cocotb_tests.checkers.drive import Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL = "vme_slave_checker"
SOURCES = ("../../rtl/checkers/vme_slave_checker.sv",)
PARAMETERS = {"Stop": 0}


async def read(p, data=0x5A):
    """A read as it should be; ends with DTACK* still low."""
    await p.step(3, vme_ds_ni=2)
    await p.step(2, vme_d_oe_o=1, vme_d_o=data)
    await p.step(2, vme_dtack_no=0)


async def release(p):
    await p.step(2, vme_ds_ni=3, vme_d_oe_o=0, vme_d_o=0xFF)
    await p.step(2, vme_dtack_no=1)


async def good(p):
    for data in (0x5A, 0x00):
        await read(p, data)
        await release(p)
    await p.step(3, vme_write_ni=0, vme_ds_ni=0)
    await p.step(2, vme_dtack_no=0)
    await release(p)
    await p.step(4, vme_write_ni=1, vme_iack_ni=0, vme_ds_ni=2, vme_iackout_no=0)  # passed on
    await p.step(2, vme_iack_ni=1, vme_ds_ni=3, vme_iackout_no=1)
    await read(p)
    await p.step(1, vme_sysreset_ni=0)  # the one licence to let go early
    await p.step(2, vme_dtack_no=1, vme_d_oe_o=0)


async def dtack_alone(p):
    await p.step(2, vme_dtack_no=0)
    await p.step(2, vme_dtack_no=1)


async def early_release(p):
    await read(p)
    await p.step(2, vme_dtack_no=1)
    await p.step(2, vme_ds_ni=3, vme_d_oe_o=0)


async def slow_release(p):
    await read(p)
    await p.step(4, vme_ds_ni=3, vme_d_oe_o=0)
    await p.step(1, vme_dtack_no=1)


async def drivers_stay(p):
    await read(p)
    await p.step(1, vme_ds_ni=3)
    await p.step(1, vme_d_oe_o=0)
    await p.step(1, vme_dtack_no=1)


async def drive_on_write(p):
    await p.step(3, vme_ds_ni=2, vme_write_ni=0)
    await p.step(1, vme_d_oe_o=1)
    await p.step(2, vme_d_oe_o=0)
    await p.step(2, vme_dtack_no=0)
    await release(p)


async def data_moves(p):
    await read(p)
    await p.step(1, vme_d_o=0x5B)
    await release(p)


async def both_fates(p):
    await p.step(3, vme_iack_ni=0, vme_ds_ni=2)
    await p.step(2, vme_d_oe_o=1, vme_d_o=0x42)
    await p.step(2, vme_dtack_no=0)
    await p.step(1, vme_iackout_no=0)
    await p.step(1, vme_iackout_no=1)
    await release(p)


async def data_late(p):
    await p.step(3, vme_ds_ni=2)
    await p.step(2, vme_d_oe_o=1, vme_d_o=0x42, vme_dtack_no=0)
    await release(p)


async def data_changes_with_dtack(p):
    await p.step(3, vme_ds_ni=2)
    await p.step(2, vme_d_oe_o=1, vme_d_o=0x42)
    await p.step(2, vme_d_o=0x43, vme_dtack_no=0)
    await release(p)


RULES = {
    0: dtack_alone,
    1: early_release,
    2: slow_release,
    3: drivers_stay,
    4: drive_on_write,
    5: data_moves,
    6: both_fates,
    7: data_late,
}


@test("VME-3", "INT-2")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut), good)


@test("VME-3", "INT-2")
@cocotb.parametrize(rule=list(RULES))
async def rule_goes_red(dut, rule):
    await expect(Pins(dut), RULES[rule], rule)


@test("VME-3")
async def data_that_changes_with_dtack_is_late_too(dut):
    await expect(Pins(dut), data_changes_with_dtack, 7)
