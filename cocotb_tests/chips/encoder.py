# SPDX-License-Identifier: Apache-2.0
"""Script words for the encoder chip, clock by clock: byte reads and writes, the count itself."""

from cocotbext import conformance
from cocotbext.conformance.quadrature import GREY, LSB, MSB

from cocotb_tests.chips.replay import THCT2000, VARIANT, Layout, Script
from cocotb_tests.models import thct2000

__all__ = ["GREY", "IDLE", "IN", "LSB", "MSB", "Encoder"]

IDLE = conformance.Encoder.IDLE | {"clk_en": 1, "other": 0}
IN = Layout(thct2000.PINS)


class Encoder(Script, conformance.Encoder):
    CHIP = THCT2000
    PINS, OUTS, IDLE = thct2000.PINS, thct2000.OUTS, IDLE
    VARIANTS = ("thct2000",)

    def __init__(self, variant: str = "", filtered: bool = False) -> None:
        super().__init__(variant)
        self.VARIANT = VARIANT if filtered else 0
        self.step(2)

    def model(self):
        return thct2000.Thct2000()

    def read(self, rs: int, want: int, note: str = "") -> None:
        self.step(3, cs_n=0, rd_n=0, rs=rs)
        self.seen(note or ("LSB" if rs else "MSB"), d_o=want, oe=1)
        self.step(2, cs_n=1, rd_n=1, rs=1 - rs)

    def other(self) -> None:
        """The board is accessed, this chip is not."""
        self.step(4, other=1)
        self.step(1, other=0)

    def count(self, want: int, note: str = "") -> None:
        self.settle()
        self.expect(note, count=want & 0xFFFF)
