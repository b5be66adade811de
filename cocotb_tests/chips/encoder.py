# SPDX-License-Identifier: Apache-2.0
"""Script words for the encoder chip: quadrature steps, byte reads and writes."""

from cocotb_tests.chips.replay import THCT2000, VARIANT, Layout, Script
from cocotb_tests.models import thct2000

IDLE = {
    "reset": 0, "clk_en": 1, "m": 5, "a": 0, "b": 0, "latch": 0, "cs_n": 1, "rd_n": 1, "wr_n": 1,
    "rs": 0, "d": 0, "other": 0,
}  # fmt: skip
IN = Layout(thct2000.PINS)
MSB, LSB = 0, 1
GREY = ((0, 0), (1, 0), (1, 1), (0, 1))  # (A, B) counting up


class Encoder(Script):
    CHIP = THCT2000
    PINS, OUTS, IDLE = thct2000.PINS, thct2000.OUTS, IDLE

    def __init__(self, mode: int = 5, filtered: bool = False) -> None:
        super().__init__()
        self.VARIANT = VARIANT if filtered else 0
        self.phase = 0
        self.step(2, m=mode)

    def model(self):
        return thct2000.Thct2000()

    def outputs(self, response) -> dict:
        seen = super().outputs(response)
        if "d_o" not in seen:
            seen["d_o"] = None
        return seen

    def turn(self, steps: int, clocks: int = 1) -> None:
        """Quadrature steps, up or down, one every `clocks` clocks."""
        for _ in range(abs(steps)):
            self.phase = (self.phase + (1 if steps > 0 else -1)) % 4
            a, b = GREY[self.phase]
            self.step(clocks, a=a, b=b)

    def settle(self) -> None:
        """Lets the synchroniser empty."""
        self.step(4)

    def read(self, rs: int, want: int, note: str = "") -> None:
        self.step(3, cs_n=0, rd_n=0, rs=rs)
        self.seen(note or ("LSB" if rs else "MSB"), d_o=want, oe=1)
        self.step(2, cs_n=1, rd_n=1, rs=1 - rs)

    def write(self, rs: int, data: int) -> None:
        self.step(2, cs_n=0, wr_n=0, rs=rs, d=data)
        self.step(2, cs_n=1, wr_n=1, rs=1 - rs, d=~data & 0xFF)

    def value(self, want: int, note: str = "", first: int = MSB) -> None:
        want &= 0xFFFF
        for rs in (first, 1 - first):
            self.read(rs, want & 0xFF if rs else want >> 8, f"{note} {'LSB' if rs else 'MSB'}")

    def init(self, value: int, first: int = MSB) -> None:
        for rs in (first, 1 - first):
            self.write(rs, value & 0xFF if rs else value >> 8)

    def other(self) -> None:
        """The board is accessed, this chip is not."""
        self.step(4, other=1)
        self.step(1, other=0)

    def latch(self) -> None:
        self.step(latch=1)
        self.step(latch=0)

    def count(self, want: int, note: str = "") -> None:
        """The counter itself, after settling."""
        self.settle()
        self.expect(note, count=want & 0xFFFF)
