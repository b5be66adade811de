# SPDX-License-Identifier: Apache-2.0
"""The 8254 against its reference model, clock by clock over random operations. §4.3.3.

MMCS_RANDOM_OPS sets the operations per mode (full depth 100000). A mismatch names the seed, the
operation and both values; the same seed gives the same stimulus everywhere.
"""

import os
import random
from bisect import bisect_right
from itertools import cycle, product

import cocotb

from cocotb_tests.chips.pit import BOTH, LSB, MSB, Pit
from cocotb_tests.chips.replay import CASCADE, I8254, QUICK_OPS, VARIANT, Bench, Layout, mismatch
from cocotb_tests.lib.req import test
from cocotb_tests.models import i8254

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)

IDLE = 0x1C00  # CS#, RD#, WR# high
CS, RD, WR = 0x400, 0x800, 0x1000
RISES, FALLS = 0x0E000, 0x70000
OPS_PER_PIECE = 20_000
OUT = Layout(i8254.OUTS)


class Stimulus:
    """Random operations on three counters as packed words; `starts[n]` is where operation n is."""

    def __init__(self, seed: str, modes: tuple[int, ...], ops: int) -> None:
        self.rng = random.Random(seed)
        self.modes = modes
        self.words: list[int] = []
        self.starts: list[int] = []
        self.texts: list[str] = []
        self.gate = 7
        self.bcd = [0, 0, 0]
        self.rw = [3, 3, 3]
        for n in range(3):
            self._control(n)
            self._count(n)
        while len(self.starts) < ops:
            self._operation()
        self._emit(IDLE, 3)
        self._clocks()

    def _emit(self, bus: int, clocks: int = 1) -> None:
        self.words += [bus | self.gate << 19] * clocks

    def _op(self, text: str) -> None:
        self.starts.append(len(self.words))
        self.texts.append(text)

    def _write(self, addr: int, data: int) -> None:
        rng = self.rng
        self._op(f"write {data:#04x} to {addr}")
        if rng.random() < 0.3:  # only the last data of a strobe counts
            self._emit(IDLE & ~CS & ~WR | addr << 8 | rng.getrandbits(8))
        self._emit(IDLE & ~CS & ~WR | addr << 8 | data)
        end = rng.choice((0, 0, 0, CS, WR))  # either strobe may go first
        self._emit((IDLE & ~end) | rng.getrandbits(10))

    def _read(self, addr: int) -> None:
        rng = self.rng
        self._op(f"read {addr}")
        self._emit(IDLE & ~CS & ~RD | addr << 8, rng.choice((1, 1, 1, 2, 3, 9)))
        end = rng.choice((0, 0, 0, CS, RD))
        self._emit((IDLE & ~end) | rng.getrandbits(10))

    def _control(self, n: int) -> None:
        rng = self.rng
        mode = rng.choice(self.modes)
        if mode in (2, 3) and rng.random() < 0.3:
            mode += 4
        self.rw[n] = rng.choice((1, 1, 2, 3, 3, 3))
        self.bcd[n] = int(rng.random() < 0.3)
        self._write(3, n << 6 | self.rw[n] << 4 | mode << 1 | self.bcd[n])

    def _byte(self, n: int, high: bool) -> int:
        rng = self.rng
        if high and rng.random() < 0.9:
            return 0
        value = rng.choice((rng.randrange(10), rng.randrange(20), rng.randrange(100)))
        if self.bcd[n]:
            return int(str(value % 100), 16)
        return rng.getrandbits(8) if rng.random() < 0.05 else value

    def _count(self, n: int) -> None:
        for high in (False, True) if self.rw[n] == 3 else (self.rw[n] == 2,):
            self._write(n, self._byte(n, high))

    def _operation(self) -> None:
        rng = self.rng
        n, kind = rng.randrange(3), rng.random()
        if kind < 0.30:
            self._read(n)
        elif kind < 0.40:
            self._write(3, n << 6 | rng.getrandbits(4))
        elif kind < 0.52:
            self._write(3, 0xC0 | rng.getrandbits(5) << 1)
        elif kind < 0.66:
            self._count(n)
        elif kind < 0.70:
            self._write(n, self._byte(n, rng.random() < 0.5))
        elif kind < 0.74:
            self._control(n)
            if rng.random() < 0.9:
                self._count(n)
        elif kind < 0.90:
            self._op(f"gate of {n}")
            self.gate ^= 1 << n
            if rng.random() < 0.5:
                self._emit(IDLE, rng.choice((1, 1, 2, 3)))
                self.gate ^= 1 << n
            self._emit(IDLE)
        else:
            self._op("wait")
            self._emit(IDLE, rng.randrange(2, 40))
        self._emit(IDLE, rng.choice((0, 0, 1, 2, 5)))

    def _clocks(self) -> None:
        """CLK of each counter: a full pulse in every clock, or any legal order of its edges."""
        if self.rng.random() < 0.4:
            self.words = [w | RISES | FALLS for w in self.words]
            return
        streams = []
        for n in range(3):
            edges, high = [], False
            busy = self.rng.choice((0.3, 0.6, 0.95))
            for _ in range(self.rng.randrange(1500, 2000)):
                if self.rng.random() > busy:
                    edges.append(0)
                elif high:
                    edges.append(0x10000 << n)
                    high = False
                else:
                    high = self.rng.random() < 0.5
                    edges.append((0x2000 if high else 0x12000) << n)
            if high:
                edges.append(0x10000 << n)
            streams.append(cycle(edges))
        self.words = [w | a | b | c for w, a, b, c in zip(self.words, *streams, strict=False)]


async def compare(dut, modes: tuple[int, ...], name: str, ops: int, pick: int = 0) -> None:
    bench, done, piece, out_edges = Bench(dut, I8254), 0, 0, 0
    nulls = {0: 0, 1: 0}
    while done < ops:
        seed = f"{os.environ.get('COCOTB_RANDOM_SEED', '1989')}-{name}-{piece}"
        stimulus = Stimulus(seed, modes, min(OPS_PER_PIECE, ops - done))
        plain = not pick & VARIANT  # the other part is an 82C54 that takes both bytes together
        model = i8254.I8254(nmos=plain, cascade=bool(pick & CASCADE), split=plain)
        want = [model.clock(word) for word in stimulus.words]
        got = await bench.replay(stimulus.words, pick)
        if want != got:
            at = next(k for k, (w, g) in enumerate(zip(want, got, strict=True)) if w != g)
            op = bisect_right(stimulus.starts, at) - 1
            recent = ", ".join(stimulus.texts[max(0, op - 12) : op + 1])
            raise AssertionError(
                f"seed {seed} operation {op} ({stimulus.texts[op]}) {bench.clock_at(at)}: "
                f"{mismatch(OUT, want[at], got[at])}; before it: {recent}"
            )
        done += len(stimulus.starts)
        piece += 1
        out_edges += sum(1 for g in got if g >> 12)
        for counter in model.counters:
            nulls[counter.null] += 1
    dut._log.info(f"{name}: {done} operations, {out_edges} clocks with OUT edges compared")
    assert done >= ops
    assert out_edges > ops // 50, f"{out_edges} OUT edges in {ops} operations prove little"


@test("PIT-1")
@cocotb.parametrize(mode=range(6))
async def random_mode(dut, mode):
    await compare(dut, (mode,), f"mode{mode}", QUICK_OPS)


@test("PIT-1")
async def random_mixed_modes(dut):
    """Any mode after any other, in every phase."""
    await compare(dut, (0, 1, 2, 3, 4, 5), "mixed", QUICK_OPS)


@test("PIT-1")
async def random_chmos_part(dut):
    await compare(dut, (0, 0, 0, 1, 2, 3, 4, 5), "chmos", QUICK_OPS // 2, VARIANT)


@test("PIT-1", "PIT-2")
async def random_cascade(dut):
    await compare(dut, (0, 2, 2, 2, 3, 3, 4), "cascade", QUICK_OPS // 2, CASCADE)


# What a counter meets at every stage, in this order; `first` and `second` are the bytes of a count.
TOUR = """control status look count more clk trigger clk clk status look read latch clk latch read
    counts read both look read low clk clk high clk clk count clk"""
BYTES_APART = "first read clk second look count look"
TO_ZERO = "clk trigger to_zero"
BEGIN = "control count trigger clk clk"
ENDS = f"{BEGIN} latch {BEGIN} stop"
ENDS_BETWEEN_BYTES = f"{BEGIN} first {BEGIN} look"


class Tour(Pit):
    """One counter through all that can happen to it, in one mode and format."""

    def tour(self, n: int, mode: int, rw: int, bcd: int) -> None:
        value, more = (0x0100, 0x0200) if rw == MSB else (7, 9)
        acts = {
            "control": lambda: self.cw(n, mode, rw, bcd),
            "count": lambda: self.count(n, value),
            "more": lambda: self.count(n, more),
            "first": lambda: self.write(n, 5),
            "second": lambda: self.write(n, 0),
            "clk": lambda: self.pulse(1, 1 << n),
            "to_zero": lambda: self.pulse((3 * 256 if rw == MSB else value) + 6, 1 << n),
            "trigger": lambda: self.trigger(1 << n),
            "low": lambda: self.gate(0, 1 << n),
            "high": lambda: self.gate(1, 1 << n),
            "latch": lambda: self.latch(n),
            "status": lambda: self.read_back(n, status=True),
            "counts": lambda: self.read_back(n, count=True),
            "both": lambda: self.read_back(n, count=True, status=True),
            "look": lambda: self.look(n),
            "read": lambda: [self.look(n) for _ in range(1 + (rw == BOTH))],
            "stop": lambda: self.cw(n, 0),
        }
        parts = [TOUR, TO_ZERO, ENDS]
        if rw == BOTH:
            parts = [TOUR, BYTES_APART, TO_ZERO, ENDS_BETWEEN_BYTES, ENDS]
        for word in " ".join(parts).split():
            acts[word]()

    def look(self, n: int) -> None:
        self.step(cs_n=0, rd_n=0, a=n)
        self.step(cs_n=1, rd_n=1)


@test("PIT-1")
async def tour_of_every_mode_and_format(dut):
    """Modes as written, 6 and 7 are 2 and 3; each counter takes a third of them."""
    script = Tour()
    for mode, (number, (rw, bcd)) in product(
        range(8), enumerate(product((LSB, MSB, BOTH), (0, 1)))
    ):
        script.tour((mode + number) % 3, mode, rw, bcd)
    script.step(2)
    model = script.model()
    want = [model.clock(word) for word in script.words]
    got = await Bench(dut, I8254).replay(script.words)
    for at, (w, g) in enumerate(zip(want, got, strict=True)):
        assert w == g, f"clock {at}: {mismatch(OUT, w, g)}"
