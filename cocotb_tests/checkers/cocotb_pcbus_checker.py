# SPDX-License-Identifier: Apache-2.0
"""Each rule of the PC bus goes red for the fault it names, and for nothing else. §4.3.2"""

import cocotb

from cocotb_tests.checkers.drive import BENCH, Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "pcbus_checker"


def read(clocks=4, drivers=1, address=0x304) -> str:
    return f"a_i={address} 1 ior_ni=0 drivers_i={drivers} {clocks} ior_ni=1 drivers_i=0 2"


WRITE = "a_i=0x308 d_i=0x42 1 iow_ni=0 4 iow_ni=1 2"
CABLE_OUT = "a_i=0x300 1 ior_ni=0 2 link_ok_i=0 ior_ni=1 1 link_ok_i=1 3"  # in mid-command
GOOD = f"{read()} {WRITE} {read(clocks=14, address=0x3F00)} {CABLE_OUT} {WRITE}"
FAULTS = {
    "both_commands": (0, "a_i=0x304 1 ior_ni=0 iow_ni=0 4 ior_ni=1 iow_ni=1 2"),
    "dma": (1, "aen_i=1 1 aen_i=0 1"),
    "address_with_command": (2, "a_i=0x304 ior_ni=0 4 ior_ni=1 2"),
    "address_moves": (3, "a_i=0x304 1 ior_ni=0 2 a_i=0x305 2 ior_ni=1 2"),
    "address_goes_at_once": (4, "a_i=0x304 1 ior_ni=0 4 ior_ni=1 a_i=0x305 2"),
    "data_goes_at_once": (5, "a_i=0x308 d_i=0x42 1 iow_ni=0 4 iow_ni=1 d_i=0x43 2"),
    "short_command": (6, read(clocks=3)),
    "no_recovery": (7, "a_i=0x304 1 ior_ni=0 4 ior_ni=1 1 ior_ni=0 4 ior_ni=1 2"),
    "data_moves": (8, "a_i=0x308 d_i=0x42 1 iow_ni=0 2 d_i=0x43 2 iow_ni=1 2"),
    "never_ready": (9, read(clocks=15)),
    "card_drives_a_write": (
        10, "a_i=0x308 d_i=0x42 1 iow_ni=0 drivers_i=2 4 iow_ni=1 drivers_i=0 2"),
    "memory_space": (11, f"{read(address=0x8304)} a_i=0x300 1"),
}  # fmt: skip


@test("PCB-1", "MAP-1")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut, CHECKER), GOOD)
    assert not int(dut.conflict_o.value)


@test("PCB-1", "MAP-1")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    rule, stimulus = FAULTS[fault]
    await expect(Pins(dut, CHECKER), stimulus, rule)


@test("PCB-2")
async def two_cards_that_answer_are_told(dut):
    await expect(Pins(dut, CHECKER), read(drivers=5))
    assert int(dut.conflict_o.value)
