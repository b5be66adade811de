# SPDX-License-Identifier: Apache-2.0
"""The register map as the report prints it, typed once more: the generated one must be the same.

Everything else, RTL, firmware and tests alike, takes the map from rtl/regs/mmcs.rdl; a slip there
would be a slip everywhere.
"""

import pytest

from mmcs import regs

pytestmark = pytest.mark.req("MAP-1")

# §4.3.3 and figure 5.1, then table 4.1 and table 5.1
ADDRESSES = {
    "WINDOW_BASE": 0x6000, "WINDOW_SIZE": 2048, "CARDS_MAX": 16, "PCCSR_BASE_CARDS": 0x300 >> 5,
    "PIT0": 0x401, "PIT1": 0x403, "PIT2": 0x405, "PIT_CONTROL": 0x407, "PCCSR": 0x409,
    "VECTOR": 0x441, "CARD_PPI_A": 0, "CARD_PPI_B": 1, "CARD_PPI_C": 2, "CARD_PPI_CONTROL": 3,
    "CARD_ENC1_MSB": 4, "CARD_ENC1_LSB": 5, "CARD_ENC2_MSB": 6, "CARD_ENC2_LSB": 7,
    "CARD_DAC1_LO": 8, "CARD_DAC1_HI": 9, "CARD_DAC2_LO": 10, "CARD_DAC2_HI": 11,
    "CARD_ADC1_LO": 12, "CARD_ADC2_LO": 13, "CARD_ADC_HI": 14, "CARD_LATCH": 16,
    "CARD_LATCH_ALL": 18,
}  # fmt: skip
BITS = {
    "PCCSR_BASE": (4, 0), "PCCSR_SCLOCK_EN": (5, 5), "PCCSR_SCLOCK_LATCHED": (5, 5),
    "PCCSR_PANIC_EN": (6, 6), "PCCSR_PANIC_LATCHED": (6, 6), "PCCSR_LATCH_EN": (7, 7),
    "CARD_PPI_A_ENC_MODE": (2, 0), "CARD_PPI_A_LED1": (3, 3), "CARD_PPI_A_LED2": (4, 4),
    "CARD_PPI_A_SYN_A": (5, 5), "CARD_PPI_A_SYN_B": (6, 6), "CARD_PPI_A_SYN_I": (7, 7),
    "CARD_PPI_B_ENC_JOINT": (0, 0), "CARD_PPI_B_DAC_JOINT": (1, 1),
    "CARD_PPI_B_SCLOCK_EN": (2, 2), "CARD_PPI_B_DAC_DOUBLE": (3, 3),
    "CARD_PPI_B_INDEX_EN": (4, 4), "CARD_PPI_C_HEARTBEAT1": (0, 0),
    "CARD_PPI_C_INDEX1": (1, 1), "CARD_PPI_C_HEARTBEAT2": (2, 2), "CARD_PPI_C_INDEX2": (3, 3),
    "CARD_PPI_C_ADC_READY": (4, 4), "CARD_DAC1_HI_CODE": (3, 0), "CARD_DAC2_HI_CODE": (3, 0),
    "CARD_ADC_HI_CODE1": (3, 0), "CARD_ADC_HI_CODE2": (7, 4),
}  # fmt: skip


def test_addresses_and_fields():
    assert {name: getattr(regs, name) for name in ADDRESSES} == ADDRESSES
    for name, (high, low) in BITS.items():
        assert getattr(regs, f"{name}_BM") == (2 << high) - (1 << low), name
        assert getattr(regs, f"{name}_BP") == low, name


def test_nothing_else_is_on_the_map():
    chips = ("PIT_", "PPI_")  # words of the chips themselves, from their data sheets
    fields = {n[:-3] for n in vars(regs) if n.endswith("_BM") and not n.startswith(chips)}
    assert fields == set(BITS), "mmcs.rdl and this file's BITS"
    others = {n for n in vars(regs) if n.isupper() and not n.endswith(("_BM", "_BP", "_GC"))}
    assert others - {"PPI_MODE_BOARD"} == set(ADDRESSES), "mmcs.rdl and this file's ADDRESSES"


def test_a_card_answers_to_its_number():
    assert regs.card_offset(0, 0) == 0x001
    assert regs.card_offset(15, 0x12) == 0x3C0 | 0x12 << 1 | 1
