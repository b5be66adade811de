# SPDX-License-Identifier: Apache-2.0
"""Reference model of the AD574A converter: transfer function, start, busy, outputs. §5.3.2."""

PINS = (
    ("ce", 1), ("cs_n", 1), ("rc_n", 1), ("a0", 1), ("mode12", 1), ("span10", 1), ("vin", 16),
)  # fmt: skip
OUTS = (("db", 12), ("oe", 1), ("sts", 1))


def code(vin: int, span10: int) -> int:
    """Offset binary, transitions at the half-LSB points; `vin` signed, 32768 = 10 V."""
    full_scale = 16384 if span10 else 32768
    lsb = full_scale // 2048
    return max(0, min(4095, (vin + full_scale + lsb // 2) // lsb))


class Ad574:
    """`clock` returns None for outputs that the data sheet leaves open in that state."""

    def __init__(self, conv: int) -> None:
        self.conv = conv
        self.left = 0
        self.start = False
        self.result = None
        self.next = None

    def clock(self, word: int) -> dict:
        ce, cs_n, rc_n = word & 1, (word >> 1) & 1, (word >> 2) & 1
        a0, mode12, span10 = (word >> 3) & 1, (word >> 4) & 1, (word >> 5) & 1
        vin = (word >> 6) & 0xFFFF
        if vin & 0x8000:
            vin -= 0x10000
        sts = 1 if self.left else 0
        selected = ce and not cs_n and rc_n
        seen = {"sts": sts}
        if not selected:
            seen["oe"] = 0
        elif not sts:
            seen["oe"] = 1
            if self.result is not None:
                if mode12:
                    seen["db"] = self.result
                else:  # left-justified on DB11..DB4
                    seen["byte"] = (self.result & 0xF) << 4 if a0 else self.result >> 4
        start = bool(ce and not cs_n and not rc_n)
        if self.left:
            self.left -= 1
            if not self.left:
                self.result = self.next
        elif start and not self.start:
            self.left = self.conv
            self.next = code(vin, span10)
        self.start = start
        return seen
