# SPDX-License-Identifier: Apache-2.0
"""The registers of the MMCS, PCCSR or CARD_PPI_A_LED1_BM: the numbers of mmcs_regs.h, which is
generated from rtl/regs/mmcs.rdl. _BM mask, _BP lowest bit, _GC value in place."""

import re

from mmcs import place

_text = (place.ROOT / "firmware" / "include" / "mmcs_regs.h").read_text()
_numbers = re.findall(r"^#define MMCS_(\w+) (0x[0-9A-F]+|\d+)u", _text, re.M)
globals().update({name.upper(): int(value, 0) for name, value in _numbers})


def card_offset(card: int, reg: int) -> int:
    """Window offset of register `reg` (CARD_...) of card 0-15."""
    return (card << 6) | (reg << 1) | 1
