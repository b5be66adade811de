# SPDX-License-Identifier: Apache-2.0
"""Script words for the 8255A, clock by clock, and its settled model."""

from cocotbext import conformance
from cocotbext.conformance.i8255 import CONTROL, SETTLE, A, B, C, mode_word

from cocotb_tests.chips.replay import I8255, VARIANT, Layout, Script
from cocotb_tests.models import i8255

__all__ = ["CONTROL", "IDLE", "SETTLE", "A", "B", "C", "Ppi", "mode_word", "settled"]

IDLE = conformance.Ppi.IDLE
IN, OUT = Layout(i8255.PINS), Layout(i8255.OUTS)


class Model:
    """The settled model on clocked words: it is asked once for each change of the pins."""

    def __init__(self, readable: bool) -> None:
        self.chip = i8255.I8255(readable)
        self.seen, self.last = {}, None

    def clock(self, word: int) -> dict:
        if word != self.last:
            self.seen, self.last = self.chip.settle(word), word
        return self.seen


def settled(want: dict, got: int) -> str:
    """What differs, of the outputs that are defined and the port C pins that are driven."""
    seen = OUT.unpack(got)
    want = dict(want)
    mask = want.pop("pc_mask", 0xFF)
    seen["pc"] &= mask
    wrong = [f"{k}: expected {v:#x}, got {seen[k]:#x}" for k, v in want.items() if seen[k] != v]
    return "; ".join(wrong)


class Ppi(Script, conformance.Ppi):
    CHIP = I8255
    PINS, OUTS = i8255.PINS, i8255.OUTS

    def __init__(self, variant: str = "") -> None:
        super().__init__(variant)
        self.VARIANT = VARIANT if variant == "82c55a" else 0

    def model(self):
        return Model(bool(self.VARIANT))

    def write(self, addr: int, data: int) -> None:
        self.step(SETTLE, cs_n=0, wr_n=0, a=addr, d=data)
        self.step(SETTLE, cs_n=1, wr_n=1, a=addr ^ 3, d=data ^ 0xFF)

    def read(self, addr: int, want: int, note: str = "") -> None:
        self.step(SETTLE, cs_n=0, rd_n=0, a=addr)
        self.seen(note or f"read of {addr}", d_o=want, oe=1)
        self.step(SETTLE, cs_n=1, rd_n=1, a=addr ^ 3)
