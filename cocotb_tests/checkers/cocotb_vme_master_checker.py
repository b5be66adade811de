# SPDX-License-Identifier: Apache-2.0
"""Each duty of a VME master goes red for the fault it names, and for nothing else. §4.3.1"""

import cocotb

from cocotb_tests.checkers.drive import Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL = "vme_master_checker"
SOURCES = ("../../rtl/checkers/vme_master_checker.sv",)
PARAMETERS = {"Stop": 0}


async def begin(p, **cycle):
    await p.step(1, **cycle)
    await p.step(1, vme_as_ni=0)
    await p.step(3, vme_ds_ni=2)


async def end(p):
    await p.step(2, vme_dtack_no=0)
    await p.step(2, vme_as_ni=1, vme_ds_ni=3, vme_iackin_ni=1, vme_iack_ni=1)
    await p.step(2, vme_dtack_no=1, vme_write_ni=1)


async def cycle(p, **what):
    await begin(p, **what)
    await end(p)


async def good(p):
    await cycle(p)
    await cycle(p, vme_write_ni=0, vme_d_i=0x1234)
    await begin(p, vme_a_i=5, vme_iack_ni=0)
    await p.step(2, vme_iackin_ni=0)
    await end(p)
    await begin(p, vme_a_i=0x1000)  # another board's, broken off: not ours to judge
    await p.step(1, vme_as_ni=1, vme_ds_ni=3)
    await begin(p, vme_a_i=0x6409 >> 1)
    await p.step(130)  # nobody answers: BERR* ends it
    await p.step(3, vme_as_ni=1, vme_ds_ni=3)


async def strobe_without_as(p):
    await p.step(3, vme_ds_ni=2)
    await end(p)


async def address_moves(p):
    await begin(p)
    await p.step(1, vme_a_i=0x640B >> 1)
    await end(p)


async def modifier_moves(p):
    await begin(p)
    await p.step(1, vme_am_i=0x2D)
    await end(p)


async def write_moves(p):
    await begin(p)
    await p.step(1, vme_write_ni=0)
    await end(p)


async def data_moves(p):
    await begin(p, vme_write_ni=0, vme_d_i=0x77)
    await p.step(1, vme_d_i=0x78)
    await end(p)


async def strobe_withdrawn(p):
    await begin(p)
    await p.step(3, vme_as_ni=1, vme_ds_ni=3)


async def strobe_too_soon(p):
    await begin(p)
    await p.step(2, vme_dtack_no=0)
    await p.step(1, vme_ds_ni=3)
    await p.step(1, vme_ds_ni=2)
    await end(p)


async def second_strobe_late(p):
    await begin(p)
    await p.step(2, vme_ds_ni=0)
    await end(p)


async def iackin_without_cycle(p):
    await p.step(3, vme_iackin_ni=0)
    await p.step(2, vme_iackin_ni=1)


FAULTS = {
    "strobe_without_as": (strobe_without_as, 0),
    "address_moves": (address_moves, 1),
    "modifier_moves": (modifier_moves, 1),
    "write_moves": (write_moves, 2),
    "data_moves": (data_moves, 3),
    "strobe_withdrawn": (strobe_withdrawn, 4),
    "strobe_too_soon": (strobe_too_soon, 5),
    "second_strobe_late": (second_strobe_late, 6),
    "iackin_without_cycle": (iackin_without_cycle, 7),
}


@test("VME-3", "VME-6")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut, vme_a_i=0x6409 >> 1), good)


@test("VME-3", "VME-6")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    stimulus, rule = FAULTS[fault]
    await expect(Pins(dut, vme_a_i=0x6409 >> 1), stimulus, rule)
