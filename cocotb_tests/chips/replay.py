# SPDX-License-Identifier: Apache-2.0
"""Replay of packed pin words against a chip bench, and scripts that build them with expectations.

A script runs against the RTL (a cocotb handle) or against the reference model (`ModelDut`), so
every directed case checks both.
"""

import os
import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path

from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotb.utils import get_sim_time
from cocotbext import conformance
from cocotbext.conformance import Row

from cocotb_tests.lib.req import test

CLOCK_NS = 10
ANALOG, I8254, I8255, THCT2000 = range(4)  # values of chip_i
VARIANT, CASCADE = 1, 2  # bits of variant_i
QUICK_OPS = int(os.environ.get("MMCS_RANDOM_OPS", "5000"))  # full depth: 100000


class Layout:
    """Names and widths of packed pins, the first in the low bits."""

    def __init__(self, fields) -> None:
        self.fields = []
        at = 0
        for name, width in fields:
            self.fields.append((name, at, (1 << width) - 1))
            at += width
        self.width = at

    def pack(self, pins: dict) -> int:
        word = 0
        for name, at, mask in self.fields:
            assert 0 <= pins[name] <= mask, f"pin {name}: {pins[name]} does not fit"
            word |= pins[name] << at
        return word

    def unpack(self, word: int) -> dict:
        return {name: word >> at & mask for name, at, mask in self.fields}


class ModelDut:
    """Stands in for a cocotb handle: `Script.run` then asks the reference model."""


class Bench:
    """The replay bench around a chip: writes stimulus, waits, reads what was seen."""

    def __init__(self, dut, chip: int) -> None:
        self.dut, self.chip = dut, chip
        self.clock = None
        self.began_ns = 0

    def clock_at(self, at: int) -> str:
        """A clock of the replay as a failure tells it, with its time in waves."""
        return f"clock {at} ({self.began_ns + at * CLOCK_NS} ns in waves)"

    async def _start(self, lines: list[str], variant: int) -> list[str]:
        dut, ident = self.dut, os.getpid()
        stim, resp = Path(f"stim_{ident}.hex"), Path(f"resp_{ident}.hex")
        stim.write_text("\n".join(lines) + "\n")
        dut.go_i.value = 0
        dut.rst_ni.value = 0
        dut.chip_i.value = self.chip
        dut.variant_i.value = variant
        dut.id_i.value = ident
        dut.length_i.value = len(lines)
        if self.clock is None:
            self.clock = Clock(dut.clk_i, CLOCK_NS, "ns")
            self.clock.start()
        await ClockCycles(dut.clk_i, 3)
        dut.rst_ni.value = 1
        await ClockCycles(dut.clk_i, 2)
        dut.go_i.value = 1
        self.began_ns = round(get_sim_time("ns")) + 2 * CLOCK_NS  # where clock 0 takes its word
        await ClockCycles(dut.clk_i, 2)
        if not int(dut.done_o.value):
            await RisingEdge(dut.done_o)
        dut.go_i.value = 0
        await ClockCycles(dut.clk_i, 2)
        seen = resp.read_text().split("\n")[:-1]
        stim.unlink()
        resp.unlink()
        return seen

    async def replay(self, words: list[int], variant: int = 0) -> list[int]:
        """One response per word, each as the clock edge that takes the word sees it."""
        assert len(words) < 262_144, "longer than the bench's memory: replay in pieces"
        lines = await self._start([f"{word:x}" for word in words], variant)
        assert len(lines) == len(words), f"{len(lines)} responses to {len(words)} words"
        try:
            return [int(line, 16) for line in lines]
        except ValueError:
            at, line = next((n, t) for n, t in enumerate(lines) if set(t) & set("xzXZ"))
            raise AssertionError(f"undefined outputs {line} at {self.clock_at(at)}") from None


def mismatch(layout: Layout, want, got: int) -> str | None:
    """None, or which output differs; `want` is a packed word or a dict of defined outputs."""
    if isinstance(want, int):
        if want == got:
            return None
        want = layout.unpack(want)
    seen = layout.unpack(got)
    wrong = [f"{k}: expected {v:#x}, got {seen[k]:#x}" for k, v in want.items() if seen[k] != v]
    return "; ".join(wrong) or None


class Script(conformance.Script):
    """A script as clocked words. Subclasses name the bench's chip, pins, model and idle state."""

    CHIP: int
    VARIANT = 0

    def __init__(self, variant: str = "") -> None:
        super().__init__(variant)
        self.layout_in, self.layout_out = Layout(self.PINS), Layout(self.OUTS)
        self.now = dict(self.IDLE)
        self.words: list[int] = []
        self.checks: list[tuple[int, dict, str]] = []

    def model(self):
        """A reference model: clock(word) gives the outputs."""
        raise NotImplementedError

    def step(self, clocks: int = 1, **pins) -> None:
        """Hold the pins, changed as given, for some clocks."""
        self.now.update(pins)
        self.words += [self.layout_in.pack(self.now)] * clocks

    def expect(self, note: str = "", **outs) -> None:
        """What the outputs are after the last step (seen by the clock that follows)."""
        self.checks.append((len(self.words), outs, note))

    def seen(self, note: str = "", **outs) -> None:
        """What the outputs are in the last clock itself, before its edge."""
        self.checks.append((len(self.words) - 1, outs, note))

    def floats(self, note: str = "") -> None:
        self.seen(note, d_o=0xFF, oe=0)

    async def run(self, dut) -> None:
        assert self.checks, "a script without an expectation proves nothing"
        self.step(2)
        bench = Bench(dut, self.CHIP)
        if isinstance(dut, ModelDut):
            model = self.model()
            responses = [model.clock(word) for word in self.words]
        else:
            responses = await bench.replay(self.words, self.VARIANT)
        for at, outs, note in self.checks:
            wrong = self.wrong(outs, self.outputs(responses[at]))
            assert not wrong, f"{bench.clock_at(at)} {note}: {wrong}"

    def outputs(self, response) -> dict:
        """A response as named outputs; the model's is a dict already where parts are undefined."""
        return response if isinstance(response, dict) else self.layout_out.unpack(response)


def script(kind: type[Script], *ids: str, **settings) -> Callable:
    """Makes a cocotb test of a function that fills a script; `ids` are those of `test`."""

    def make(fill: Callable[[Script], None]):
        @wraps(fill)
        async def play(dut) -> None:
            s = kind(**settings)
            fill(s)
            await s.run(dut)

        return test(*ids)(play)

    return make


class Scripts:
    """Its functions and texts are tests of the module, each as by script(of, req, **settings)."""

    def __init_subclass__(cls, of: type[Script], req: str, **settings):
        for name, fill in [*vars(cls).items()]:
            if not name.startswith("__"):
                _add(cls.__module__, Row(name, "", fill, (), False), of, *req.split(), **settings)


def rows(module: str, kind: type[Script], req: Callable[[Row], str]) -> None:
    """The chip's rows of the conformance kit are tests of this module; `req` gives their ids."""
    for row in kind.ROWS:
        _add(module, row, kind, *req(row).split(), variant=row.only[0] if row.only else "")


def _add(module: str, row: Row, kind: type[Script], *ids: str, **settings) -> None:
    def fill(s: Script) -> None:
        row.put(s)

    fill.__name__ = fill.__qualname__ = row.name
    fill.__module__, fill.__doc__ = module, row.section
    setattr(sys.modules[module], row.name, script(kind, *ids, **settings)(fill))
