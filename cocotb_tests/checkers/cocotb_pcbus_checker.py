# SPDX-License-Identifier: Apache-2.0
"""Each rule of the PC bus goes red for the fault it names, and for nothing else. §4.3.2"""

import cocotb

from cocotb_tests.checkers.drive import Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL = "pcbus_checker"
SOURCES = ("../../rtl/checkers/pcbus_checker.sv",)
PARAMETERS = {"Stop": 0, "MaxClks": 14, "NumCards": 3}


async def read(p, clocks=4, drivers=1, address=0x304):
    await p.step(1, pc_a_i=address)
    await p.step(clocks, pc_ior_ni=0, drivers_i=drivers)
    await p.step(2, pc_ior_ni=1, drivers_i=0)


async def write(p, clocks=4, address=0x308):
    await p.step(1, pc_a_i=address, pc_d_i=0x42)
    await p.step(clocks, pc_iow_ni=0)
    await p.step(2, pc_iow_ni=1)


async def good(p):
    await read(p)
    await write(p)
    await read(p, clocks=14, address=0x3F00)
    await p.step(1, pc_a_i=0x300)
    await p.step(2, pc_ior_ni=0)
    await p.step(1, link_ok_i=0, pc_ior_ni=1)  # the cable comes out in mid-command
    await p.step(3, link_ok_i=1)
    await write(p)


async def both_commands(p):
    await p.step(1, pc_a_i=0x304)
    await p.step(4, pc_ior_ni=0, pc_iow_ni=0)
    await p.step(2, pc_ior_ni=1, pc_iow_ni=1)


async def dma(p):
    await p.step(1, pc_aen_i=1)
    await p.step(1, pc_aen_i=0)


async def address_with_command(p):
    await p.step(4, pc_a_i=0x304, pc_ior_ni=0)
    await p.step(2, pc_ior_ni=1)


async def address_moves(p):
    await p.step(1, pc_a_i=0x304)
    await p.step(2, pc_ior_ni=0)
    await p.step(2, pc_a_i=0x305)
    await p.step(2, pc_ior_ni=1)


async def address_goes_at_once(p):
    await p.step(1, pc_a_i=0x304)
    await p.step(4, pc_ior_ni=0)
    await p.step(2, pc_ior_ni=1, pc_a_i=0x305)


async def data_goes_at_once(p):
    await p.step(1, pc_a_i=0x308, pc_d_i=0x42)
    await p.step(4, pc_iow_ni=0)
    await p.step(2, pc_iow_ni=1, pc_d_i=0x43)


async def short_command(p):
    await read(p, clocks=3)


async def no_recovery(p):
    await p.step(1, pc_a_i=0x304)
    await p.step(4, pc_ior_ni=0)
    await p.step(1, pc_ior_ni=1)
    await p.step(4, pc_ior_ni=0)
    await p.step(2, pc_ior_ni=1)


async def data_moves(p):
    await p.step(1, pc_a_i=0x308, pc_d_i=0x42)
    await p.step(2, pc_iow_ni=0)
    await p.step(2, pc_d_i=0x43)
    await p.step(2, pc_iow_ni=1)


async def never_ready(p):
    await read(p, clocks=15)


async def card_drives_a_write(p):
    await p.step(1, pc_a_i=0x308, pc_d_i=0x42)
    await p.step(4, pc_iow_ni=0, drivers_i=2)
    await p.step(2, pc_iow_ni=1, drivers_i=0)


async def memory_space(p):
    await read(p, address=0x8304)
    await p.step(1, pc_a_i=0x300)


FAULTS = {
    "both_commands": (both_commands, 0),
    "dma": (dma, 1),
    "address_with_command": (address_with_command, 2),
    "address_moves": (address_moves, 3),
    "address_goes_at_once": (address_goes_at_once, 4),
    "data_goes_at_once": (data_goes_at_once, 5),
    "short_command": (short_command, 6),
    "no_recovery": (no_recovery, 7),
    "data_moves": (data_moves, 8),
    "never_ready": (never_ready, 9),
    "card_drives_a_write": (card_drives_a_write, 10),
    "memory_space": (memory_space, 11),
}


@test("PCB-1", "MAP-1")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut), good)
    assert not int(dut.conflict_o.value)


@test("PCB-1", "MAP-1")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    stimulus, rule = FAULTS[fault]
    await expect(Pins(dut), stimulus, rule)


@test("PCB-2")
async def two_cards_that_answer_are_told(dut):
    async def stimulus(p):
        await read(p, drivers=5)

    await expect(Pins(dut), stimulus)
    assert int(dut.conflict_o.value)
