# SPDX-License-Identifier: Apache-2.0
"""Each rule on whose cycle it is goes red for the fault it names, and for nothing else. §4.3.6"""

import cocotb

from cocotb_tests.checkers.drive import Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL = "vme_claim_checker"
SOURCES = ("../../rtl/checkers/vme_claim_checker.sv",)
PARAMETERS = {"Stop": 0}
OURS = 0x6409 >> 1
LEVEL_5 = 0x7F & ~(1 << 4)


async def access(p, drive=1, **cycle):
    """A read that is answered whatever it addresses."""
    await p.step(3, **{"vme_a_i": OURS, "vme_as_ni": 0, "vme_ds_ni": 2} | cycle)
    await p.step(2, vme_d_oe_o=drive)
    await p.step(2, vme_dtack_no=0)
    await p.step(2, vme_as_ni=1, vme_ds_ni=3, vme_d_oe_o=0)
    await p.step(2, vme_dtack_no=1, vme_am_i=0x29, vme_lword_ni=1)


async def acknowledge(p, *, asked=True, answer=True, level=5):
    if asked:
        await p.step(2, vme_irq_no=LEVEL_5)
    await p.step(1, vme_a_i=level, vme_iack_ni=0, vme_as_ni=0, vme_ds_ni=2)
    await p.step(3, vme_iackin_ni=0)
    if answer:
        await p.step(2, vme_d_oe_o=1)
        await p.step(2, vme_dtack_no=0)
    else:
        await p.step(4, vme_iackout_no=0)
    await p.step(
        2, vme_as_ni=1, vme_ds_ni=3, vme_iackin_ni=1, vme_iack_ni=1, vme_iackout_no=1, vme_d_oe_o=0
    )
    await p.step(2, vme_dtack_no=1, vme_irq_no=0x7F)


async def good(p):
    await access(p)
    await access(p, vme_am_i=0x2D, vme_ds_ni=0)
    await acknowledge(p)
    await acknowledge(p, asked=False, answer=False)
    await acknowledge(p, level=3, answer=False)
    await p.step(8, vme_sysreset_ni=0)
    await p.step(2, vme_sysreset_ni=1)


async def answers_wrong_address(p):
    await access(p, drive=0, vme_a_i=0x6809 >> 1)


async def answers_wrong_modifier(p):
    await access(p, drive=0, vme_am_i=0x39)


async def answers_even_byte(p):
    await access(p, drive=0, vme_ds_ni=1)


async def answers_long_word(p):
    await access(p, drive=0, vme_lword_ni=0, vme_ds_ni=0)


async def drives_for_another(p):
    await p.step(2, vme_a_i=0x1000, vme_as_ni=0, vme_ds_ni=2)
    await p.step(2, vme_d_oe_o=1)
    await p.step(2, vme_as_ni=1, vme_ds_ni=3, vme_d_oe_o=0)


async def answers_unasked(p):
    await acknowledge(p, asked=False)


async def steals_the_cycle(p):
    """The request comes while IACKIN* is already low."""
    await p.step(1, vme_a_i=5, vme_iack_ni=0, vme_as_ni=0, vme_ds_ni=2)
    await p.step(2, vme_iackin_ni=0)
    await p.step(2, vme_irq_no=LEVEL_5, vme_d_oe_o=1)
    await p.step(2, vme_dtack_no=0)
    await p.step(2, vme_as_ni=1, vme_ds_ni=3, vme_iackin_ni=1, vme_iack_ni=1, vme_d_oe_o=0)
    await p.step(2, vme_dtack_no=1, vme_irq_no=0x7F)


async def chain_without_cycle(p):
    await p.step(2, vme_iackout_no=0)
    await p.step(2, vme_iackout_no=1)


async def chain_after_the_cycle(p):
    """IACKOUT* still low when AS* has risen."""
    await p.step(1, vme_a_i=3, vme_iack_ni=0, vme_as_ni=0, vme_ds_ni=2)
    await p.step(3, vme_iackin_ni=0)
    await p.step(3, vme_iackout_no=0)
    await p.step(2, vme_as_ni=1)
    await p.step(1, vme_iackout_no=1, vme_iackin_ni=1, vme_iack_ni=1, vme_ds_ni=3)


async def passes_its_own(p):
    await acknowledge(p, answer=False)


async def wrong_line(p):
    await p.step(2, vme_irq_no=0x7F & ~(1 << 3))
    await p.step(2, vme_irq_no=0x7F)


async def requests_in_reset(p):
    await p.step(2, vme_irq_no=LEVEL_5)
    await p.step(8, vme_sysreset_ni=0)
    await p.step(2, vme_sysreset_ni=1)


FAULTS = {
    "answers_wrong_address": (answers_wrong_address, 0),
    "answers_wrong_modifier": (answers_wrong_modifier, 0),
    "answers_even_byte": (answers_even_byte, 0),
    "answers_long_word": (answers_long_word, 0),
    "drives_for_another": (drives_for_another, 1),
    "answers_unasked": (answers_unasked, 2),
    "steals_the_cycle": (steals_the_cycle, 2),
    "chain_without_cycle": (chain_without_cycle, 3),
    "chain_after_the_cycle": (chain_after_the_cycle, 3),
    "passes_its_own": (passes_its_own, 4),
    "wrong_line": (wrong_line, 5),
    "requests_in_reset": (requests_in_reset, 6),
}


@test("VME-1", "VME-2", "INT-2")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut), good)


@test("VME-1", "VME-2", "INT-2")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    stimulus, rule = FAULTS[fault]
    await expect(Pins(dut), stimulus, rule)
