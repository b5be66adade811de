# SPDX-License-Identifier: Apache-2.0
"""Each rule on whose cycle it is goes red for the fault it names, and for nothing else. §4.3.6"""

import cocotb

from cocotb_tests.checkers.drive import BENCH, Pins, expect
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "vme_claim_checker"
OURS = 0x6409 >> 1
LEVEL_5 = 0x7F & ~(1 << 4)


def access(other: str = "", drive: int = 1) -> str:
    """A read that is answered whatever it addresses."""
    return (
        f"a_i={OURS} as_ni=0 ds_ni=2 {other} 3 d_oe_o={drive} 2 dtack_no=0 2"
        " as_ni=1 ds_ni=3 d_oe_o=0 2 dtack_no=1 am_i=0x29 lword_ni=1 2"
    )


ASKED, SYSRESET = f"irq_no={LEVEL_5} 2", "sysreset_ni=0 8 sysreset_ni=1 2"
ANSWER, PASS = "d_oe_o=1 2 dtack_no=0 2", "iackout_no=0 4"
END = "as_ni=1 ds_ni=3 iackin_ni=1 iack_ni=1 iackout_no=1 d_oe_o=0 2 dtack_no=1 irq_no=0x7F 2"


def acknowledge(fate: str, level: int = 5) -> str:
    return f"a_i={level} iack_ni=0 as_ni=0 ds_ni=2 1 iackin_ni=0 3 {fate} {END}"


GOOD = f"""{access()} {access("am_i=0x2D ds_ni=0")} {ASKED} {acknowledge(ANSWER)}
    {acknowledge(PASS)} {ASKED} {acknowledge(PASS, level=3)} {SYSRESET}"""
FAULTS = {
    "answers_wrong_address": (0, access(f"a_i={0x6809 >> 1}", drive=0)),
    "answers_wrong_modifier": (0, access("am_i=0x39", drive=0)),
    "answers_even_byte": (0, access("ds_ni=1", drive=0)),
    "answers_long_word": (0, access("lword_ni=0 ds_ni=0", drive=0)),
    "drives_for_another": (
        1, "a_i=0x1000 as_ni=0 ds_ni=2 2 d_oe_o=1 2 as_ni=1 ds_ni=3 d_oe_o=0 2"),
    "answers_unasked": (2, acknowledge(ANSWER)),
    # The request comes while IACKIN* is already low.
    "steals_the_cycle": (2, acknowledge(f"irq_no={LEVEL_5} {ANSWER}")),
    "chain_without_cycle": (3, "iackout_no=0 2 iackout_no=1 2"),
    # IACKOUT* still low when AS* has risen.
    "chain_after_the_cycle": (3, acknowledge("iackout_no=0 3 as_ni=1 2", level=3)),
    "passes_its_own": (4, f"{ASKED} {acknowledge(PASS)}"),
    "wrong_line": (5, f"irq_no={0x7F & ~(1 << 3)} 2 irq_no=0x7F 2"),
    "requests_in_reset": (6, f"{ASKED} {SYSRESET}"),
}  # fmt: skip


@test("VME-1", "VME-2", "INT-2")
async def good_cycles_break_nothing(dut):
    await expect(Pins(dut, CHECKER), GOOD)


@test("VME-1", "VME-2", "INT-2")
@cocotb.parametrize(fault=list(FAULTS))
async def rule_goes_red(dut, fault):
    rule, stimulus = FAULTS[fault]
    await expect(Pins(dut, CHECKER), stimulus, rule)
