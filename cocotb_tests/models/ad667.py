# SPDX-License-Identifier: Apache-2.0
"""Reference model of the AD667 D/A: four latches in two ranks. Report §5.3.3."""

PINS = (("cs_n", 1), ("a_n", 4), ("d", 12))
OUTS = (("code", 12),)


class Ad667:
    def __init__(self) -> None:
        self.rank1 = self.rank2 = 0x800

    def clock(self, word: int) -> int:
        cs_n, a_n, data = word & 1, (word >> 1) & 0xF, (word >> 5) & 0xFFF
        before = self.rank2
        if not cs_n:
            for nibble in range(3):
                if not (a_n >> nibble) & 1:
                    mask = 0xF << (4 * nibble)
                    self.rank1 = (self.rank1 & ~mask) | (data & mask)
            if not a_n & 8:
                self.rank2 = self.rank1
        return before
