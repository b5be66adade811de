# SPDX-License-Identifier: Apache-2.0
"""Scripts of bus transactions with expectations, and the rows of a data sheet made of them."""

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass


class LeftOut(Exception):
    """The variant of the chip has not what a row uses: the row is none of its sheet."""


class Script:
    """Pins over time with expectations; a chip's class adds its pins and its words."""

    SHEET = ""
    PINS: tuple = ()  # (name, width) of each input; of each output
    OUTS: tuple = ()
    IDLE: dict = {}
    VARIANTS = ("",)  # the first is the default
    ADDRESS = "a"
    ROWS: list["Row"]

    def __init__(self, variant: str = "") -> None:
        self.variant = variant or self.VARIANTS[0]
        self.now = dict(self.IDLE)
        self.actions: list[tuple] = []  # ("pins", changes, clocks) or ("check", outs, note)

    def ports(self) -> tuple[dict, dict]:
        """Port and width of each input and output of the wrapper, by the names in scripts."""
        inputs = {name: (name, width) for name, width in self.PINS}
        outputs = {name: (name + "_o" * (name in inputs), width) for name, width in self.OUTS}
        return inputs, outputs

    def step(self, clocks: int = 1, **pins) -> None:
        """Change pins, and wait so many clocks or until the chip has settled, what is longer."""
        self.now.update(pins)
        self.actions.append(("pins", pins, clocks))

    def seen(self, note: str = "", **outs) -> None:
        """What the outputs are; `out1` is bit 1 of `out`."""
        self.actions.append(("check", outs, note))

    expect = seen  # where a script counts clocks, one clock later

    def wrong(self, outs: dict, seen: dict) -> str:
        """What differs between the outputs expected and those seen, or nothing."""

        def got(name):
            if name in seen or name[:-1] not in seen:
                return seen.get(name)
            return seen[name[:-1]] >> int(name[-1]) & 1

        found = {name: got(name) for name in outs}
        return "; ".join(
            f"{k}: expected {v:#x}, got {found[k] if found[k] is None else hex(found[k])}"
            for k, v in outs.items()
            if found[k] != v
        )

    def word(self, word: str) -> None:
        """A word of play() that is no call."""
        raise ValueError(f"{word!r} is no word of these scripts")

    def play(self, text: str) -> None:
        """Calls of a script's functions one after the other, `program(0, 4) pulse(3)`."""
        names = {"s": self}
        for kind in type(self).__mro__[-2::-1]:
            names |= vars(sys.modules[kind.__module__])
        for call, word in re.findall(r"(\w+\([^)]*\))|(\S+)", text):
            if call:
                eval(f"s.{call}", names)
            else:
                self.word(word)

    # The bus of all chips. Address and data stay until the chip has taken the end of the strobe.
    def write(self, addr: int, data: int) -> None:
        self.step(cs_n=0, d=data, **{self.ADDRESS: addr})
        self.step(wr_n=0)
        self.step(wr_n=1)
        self.step(cs_n=1, d=data ^ 0xFF, **{self.ADDRESS: addr ^ 1})

    def read(self, addr: int, want: int, note: str = "") -> None:
        self.step(cs_n=0, **{self.ADDRESS: addr})
        self.step(rd_n=0)
        self.seen(note or f"read of {addr}", d_o=want, oe=1)
        self.step(rd_n=1)
        self.step(cs_n=1, **{self.ADDRESS: addr ^ 1})

    def floats(self, note: str = "") -> None:
        """The data lines are not driven."""
        self.seen(note, oe=0)


@dataclass(frozen=True)
class Row:
    """One statement of a data sheet."""

    name: str
    section: str
    fill: str | Callable[[Script], None]
    only: tuple[str, ...]  # variants that have it; none: all
    silent: bool  # the sheet does not say it: what the cores of MMCS do

    def put(self, script: Script) -> Script:
        """The script with this row in it. Raises LeftOut."""
        if self.only and script.variant not in self.only:
            raise LeftOut
        if isinstance(self.fill, str):
            script.play(self.fill)
        else:
            self.fill(script)
        return script

    @property
    def words(self) -> str:
        return self.name.replace("_", " ")


class Rows:
    """Its functions and texts are rows of the chip `of`, from this section of the sheet."""

    def __init_subclass__(cls, of: type[Script], section: str, only=(), silent=False):
        for name, fill in vars(cls).items():
            if not name.startswith("__"):
                of.ROWS.append(Row(name, section, fill, only, silent))
