# SPDX-License-Identifier: Apache-2.0
"""Script words for the 8254, clock by clock: writes, reads, CLK pulses."""

from cocotbext import conformance
from cocotbext.conformance.i8254 import BOTH, LSB, MSB

from cocotb_tests.chips.replay import CASCADE, I8254, VARIANT, Script
from cocotb_tests.models import i8254

__all__ = ["BOTH", "LSB", "MSB", "Pit"]


class Pit(Script, conformance.Pit):
    CHIP = I8254
    PINS, OUTS = i8254.PINS, i8254.OUTS
    IDLE = {"d": 0, "a": 0, "cs_n": 1, "rd_n": 1, "wr_n": 1, "rise": 0, "fall": 0, "gate": 7}

    def __init__(self, variant: str = "", cascade: bool = False) -> None:
        super().__init__(variant)
        self.chmos, self.cascade = variant == "chmos", cascade
        self.VARIANT = (VARIANT if self.chmos else 0) | (CASCADE if cascade else 0)

    def model(self):
        # the bench's CHMOS part takes both bytes of a count together
        return i8254.I8254(not self.chmos, self.cascade, split=not self.chmos)

    # Bus. The pins change to rubbish when the strobe ends: the chip must have captured them.
    def write(self, addr: int, data: int, **with_end) -> None:
        self.step(cs_n=0, wr_n=0, a=addr, d=data)
        pins = {"rise": 0, "fall": 0} | with_end
        self.step(cs_n=1, wr_n=1, a=~addr & 3, d=~data & 0xFF, **pins)
        self.step(0, rise=0, fall=0)

    def read(self, addr: int, want: int, note: str = "") -> None:
        self.step(cs_n=0, rd_n=0, a=addr)
        self.seen(note or f"read of {addr}", d_o=want, oe=1)
        self.step(cs_n=1, rd_n=1, a=~addr & 3)

    # CLK: its edges, the rise before the fall in one clock.
    def pulse(self, times: int = 1, mask: int = 1) -> None:
        self.step(times, rise=mask, fall=mask)
        self.step(0, rise=0, fall=0)

    def rise(self, mask: int = 1) -> None:
        self.step(rise=mask)
        self.step(0, rise=0)

    def fall(self) -> None:
        self.step(fall=1)
        self.step(0, fall=0)
