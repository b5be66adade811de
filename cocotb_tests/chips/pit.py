# SPDX-License-Identifier: Apache-2.0
"""Script words for the 8254: control words, counts, CLK pulses, reads, golden sequences."""

from cocotb_tests.chips.replay import CASCADE, I8254, VARIANT, Script
from cocotb_tests.models import i8254

LSB, MSB, BOTH = 1, 2, 3


def bcd(value: int) -> int:
    return int(str(value), 16)


class Pit(Script):
    CHIP = I8254
    PINS, OUTS = i8254.PINS, i8254.OUTS
    IDLE = {"d": 0, "a": 0, "cs_n": 1, "rd_n": 1, "wr_n": 1, "rise": 0, "fall": 0, "gate": 7}

    def __init__(self, chmos: bool = False, cascade: bool = False) -> None:
        super().__init__()
        self.chmos, self.cascade = chmos, cascade
        self.VARIANT = (VARIANT if chmos else 0) | (CASCADE if cascade else 0)
        self.rw = [0, 0, 0]

    def model(self):
        # the bench's CHMOS part takes both bytes of a count together
        return i8254.I8254(not self.chmos, self.cascade, split=not self.chmos)

    def outputs(self, response) -> dict:
        seen = super().outputs(response)
        return seen | {f"out{n}": seen["out"] >> n & 1 for n in range(3)}

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

    def cw(self, n: int, mode: int, rw: int = BOTH, bcd: int = 0, **with_end) -> None:
        self.rw[n] = rw
        self.write(3, n << 6 | rw << 4 | mode << 1 | bcd, **with_end)

    def count(self, n: int, value: int, **with_end) -> None:
        if self.rw[n] & LSB:
            last = with_end if self.rw[n] == LSB else {}
            self.write(n, value & 0xFF, **last)
        if self.rw[n] & MSB:
            self.write(n, value >> 8, **with_end)

    def program(self, mode: int, value: int, n: int = 0, rw: int = BOTH, bcd: int = 0) -> None:
        self.cw(n, mode, rw, bcd)
        self.count(n, value)

    def latch(self, n: int) -> None:
        self.write(3, n << 6)

    def read_back(self, n: int, count: bool = False, status: bool = False) -> None:
        self.write(3, 0xC0 | (not count) << 5 | (not status) << 4 | 2 << n)

    def value(self, n: int, want: int, note: str = "") -> None:
        """The count, read in the counter's format (latched before if `latch` was used)."""
        if self.rw[n] & LSB:
            self.read(n, want & 0xFF, f"{note} LSB")
        if self.rw[n] & MSB:
            self.read(n, want >> 8, f"{note} MSB")

    def status(self, n: int, out: int, null: int, low: int, note: str = "status") -> None:
        self.read_back(n, status=True)
        self.read(n, out << 7 | null << 6 | low, note)

    # Clocks and gate.
    def pulse(self, times: int = 1, mask: int = 1) -> None:
        self.step(times, rise=mask, fall=mask)
        self.step(0, rise=0, fall=0)

    def rise(self) -> None:
        self.step(rise=1)
        self.step(0, rise=0)

    def fall(self) -> None:
        self.step(fall=1)
        self.step(0, fall=0)

    def gate(self, level: int, mask: int = 1) -> None:
        self.step(gate=(self.now["gate"] & ~mask) | (mask if level else 0))

    def trigger(self, mask: int = 1) -> None:
        self.gate(0, mask)
        self.gate(1, mask)

    def out(self, want: int, n: int = 0, note: str = "") -> None:
        """OUT of counter n (compared alone) after the last step."""
        self.checks.append((len(self.words), {f"out{n}": want}, note or f"OUT{n}"))

    def word(self, word: str) -> None:
        """A pair of golden(), or a string of outs()."""
        (self.golden if ":" in word else self.outs)(word)

    def golden(self, text: str, n: int = 0) -> None:
        """`OUT:CE OUT:CE …`, one pair for each CLK pulse; CE read through the counter latch."""
        for at, pair in enumerate(text.split()):
            out, ce = pair.split(":")
            self.pulse(mask=1 << n)
            note = f"pulse {at + 1} ({pair})"
            self.out(int(out), n, note)
            self.latch(n)
            self.value(n, int(ce, 16), note)

    def outs(self, text: str, n: int = 0) -> None:
        """OUT after each CLK pulse, as a string of 0 and 1."""
        for at, level in enumerate(text.replace(" ", "")):
            self.pulse(mask=1 << n)
            self.out(int(level), n, f"OUT{n} after pulse {at + 1}")
