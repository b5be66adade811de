# SPDX-License-Identifier: Apache-2.0
"""Script words for the 8255A: register writes and reads, handshake strobes."""

from cocotb_tests.chips.replay import I8255, VARIANT, Layout, Script
from cocotb_tests.models import i8255

A, B, C, CONTROL = range(4)
SETTLE = 5  # clocks after which every handshake has come to rest
IDLE = {
    "reset": 0, "cs_n": 1, "rd_n": 1, "wr_n": 1, "a": 0, "d": 0, "pa": 0xFF, "pb": 0xFF,
    "pc": 0xFF,
}  # fmt: skip
IN, OUT = Layout(i8255.PINS), Layout(i8255.OUTS)


def mode_word(a=0, a_in=0, ch_in=0, b=0, b_in=0, cl_in=0) -> int:
    return 0x80 | a << 5 | a_in << 4 | ch_in << 3 | b << 2 | b_in << 1 | cl_in


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


class Ppi(Script):
    CHIP = I8255
    PINS, OUTS, IDLE = i8255.PINS, i8255.OUTS, IDLE

    def __init__(self, readable: bool = False) -> None:
        super().__init__()
        self.readable = readable
        self.VARIANT = VARIANT if readable else 0

    def model(self):
        return Model(self.readable)

    def pins(self, note: str = "", **outs) -> None:
        """Port pins after settling; pc0…pc7 are single bits of port C."""
        self.step(SETTLE)
        self.seen(note, **outs)

    def outputs(self, response) -> dict:
        seen = super().outputs(response)
        return seen | {f"pc{n}": seen["pc"] >> n & 1 for n in range(8)}

    def write(self, addr: int, data: int) -> None:
        self.step(SETTLE, cs_n=0, wr_n=0, a=addr, d=data)
        self.step(SETTLE, cs_n=1, wr_n=1, a=addr ^ 3, d=data ^ 0xFF)

    def read(self, addr: int, want: int, note: str = "") -> None:
        self.step(SETTLE, cs_n=0, rd_n=0, a=addr)
        self.seen(note or f"read of {addr}", d_o=want, oe=1)
        self.step(SETTLE, cs_n=1, rd_n=1, a=addr ^ 3)

    def mode(self, **fields) -> None:
        self.write(CONTROL, mode_word(**fields))

    def bit(self, n: int, value: int) -> None:
        self.write(CONTROL, n << 1 | value)

    def strobe(self, bit: int, **with_low) -> None:
        """A low pulse on a port C input (STB# or ACK#)."""
        self.step(SETTLE, pc=self.now["pc"] & ~(1 << bit), **with_low)
        self.step(SETTLE, pc=self.now["pc"] | 1 << bit)
