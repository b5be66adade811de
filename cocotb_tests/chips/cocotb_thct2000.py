# SPDX-License-Identifier: Apache-2.0
"""The THCT2000 encoder chip: eight modes, latch, coherent reads, speed, random. §5.3.1-5.3.2."""

import os
import random

from cocotb_tests.chips.encoder import GREY, IDLE, IN, LSB, MSB, Encoder
from cocotb_tests.chips.replay import (
    QUICK_OPS,
    THCT2000,
    Bench,
    Layout,
    ModelDut,
    Scripts,
    mismatch,
    rows,
)
from cocotb_tests.lib.req import test
from cocotb_tests.models import thct2000

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)


rows(__name__, Encoder, lambda row: "ENC-1" if row.section[:6] == "§5.3.1" else "ENC-2")


class Counting(Scripts, of=Encoder, req="ENC-1"):
    # A transition every other clock of 8 MHz, both ways, none lost
    four_million_counts_a_second = """
        turn(2000, clocks=2) count(2000) turn(-3000, clocks=2) count(-1000)"""
    both_inputs_at_once_count_nothing = """
        expect(illegal=0) step(3, a=1, b=1) step(3, a=0, b=0) step(3, a=1, b=1) step(3, a=0, b=0)
        step(3, a=1, b=1) step(3, a=0, b=0) step(3, a=1, b=1) step(3, a=0, b=0) count(0)
        expect('and it is remembered', illegal=1) turn(3) count(3, 'counting goes on')
        step(2, reset=1) step(1, reset=0) expect('until RESET', illegal=0)"""

    def both_inputs_at_once_are_legal_where_no_steps_are_counted(s):
        """Holding, and in the modes that measure an interval or a frequency; not in any other."""
        for mode in range(8):
            s.step(4, m=mode)
            s.step(4, a=1, b=1)
            s.step(4, a=0, b=0)
            s.expect(f"mode {mode}", illegal=int(mode not in (0, 6, 7)))
            s.step(2, reset=1)
            s.step(1, reset=0)

    mode6_measures_an_interval = """
        step(2, m=6) step(7, a=1) step(6, a=0) expect('starts anew', count=0)
        value(7, 'A high for 7 CLKs') step(1, a=1) step(6, a=0) expect('starts anew', count=0)
        value(1, 'A high for 1 CLKs') step(0x64, a=1) step(6, a=0) expect('starts anew', count=0)
        value(0x64, 'A high for 100 CLKs')"""

    def mode7_measures_a_frequency(s):
        s.step(2, m=7)
        for rises in (3, 0, 10):
            s.step(3, b=1)
            for _ in range(rises):
                s.step(2, a=1)
                s.step(2, a=0)
            s.settle()
            s.step(6, b=0)
            s.value(rises, f"{rises} rises of A while B is high")
            s.step(3, a=1)
            s.step(3, a=0)
            s.count(0, "not while B is low")


@test("ENC-2")
async def data_are_there_at_once(dut):
    """In the first clock of a read already, which the data sheet, and the model, leave open."""
    if isinstance(dut, ModelDut):
        return
    s = Encoder()
    for value in (0x1234, 0xEDCB, 0xA55A, 0x5AA5, 0):
        for first in (MSB, LSB):
            s.step(2, reset=1)
            s.step(2, reset=0)
            s.init(value)
            for rs in (first, 1 - first):
                for clock in range(3):
                    s.step(cs_n=0, rd_n=0, rs=rs)
                    s.seen(f"clock {clock}", d_o=value & 0xFF if rs else value >> 8, oe=1)
                s.step(2, cs_n=1, rd_n=1, rs=1 - rs)
    await s.run(dut)


@test("ENC-2")
async def a_count_between_two_written_bytes_does_not_tear_them(dut):
    for first, value in ((MSB, 0x12FF), (LSB, 0x1300)):
        s = Encoder()
        s.init(0x00FF if first == MSB else 0x0100)
        s.other()
        s.write(first, value & 0xFF if first else value >> 8)
        s.turn(1 if first == MSB else -1)
        s.settle()
        s.write(1 - first, value >> 8 if first else value & 0xFF)
        s.expect("both as written", count=value)
        await s.run(dut)


@test("ENC-2")
async def a_stray_byte_leaves_nothing_stale(dut):
    """A lone byte, read or written, first after RESET or later, and then something else."""
    for later in (False, True):
        for stray in (MSB, LSB):
            for kind in ("read", "write"):
                for first in (MSB, LSB):
                    s = Encoder()
                    if later:
                        s.init(0x1234)
                        s.value(0x1234)
                    if kind == "read":
                        s.read(stray, (0x34, 0x12)[1 - stray] if later else 0)
                    else:
                        s.write(stray, 0x77)
                    s.other()
                    s.init(0x5678, first=first)
                    for want in (0x5678, 0x5679, 0x567A):
                        s.value(want, f"{kind} of {stray}, then {first} first", first=first)
                        s.turn(1)
                        s.settle()
                    await s.run(dut)


@test("ENC-2")
async def what_ends_a_pair_and_what_does_not(dut):
    """Any other access, a mode set and RESET do; a latch does not."""

    def other(s):
        s.other()

    def mode(s):
        s.step(m=4)
        s.step(2, m=5)

    def write(s):
        s.write(LSB, 0x01)

    for ends in (other, mode, write):
        s = Encoder()
        s.init(0x30FF)
        s.read(MSB, 0x30)
        s.turn(2)
        s.settle()
        ends(s)
        s.read(LSB, 0x01, ends.__name__)
        await s.run(dut)
    s = Encoder()
    s.init(0x30FF)
    s.read(MSB, 0x30)
    s.turn(2)
    s.settle()
    s.latch()
    s.read(LSB, 0xFF, "a latch leaves the pair one sample")
    s.value(0x3101, "and is there for the next")
    await s.run(dut)


@test("ENC-2")
async def reset_ends_a_pair(dut):
    for stray in (MSB, LSB):
        s = Encoder()
        s.init(0x1234)
        s.read(stray, 0x34 if stray else 0x12)
        s.write(stray, 0x99)
        s.step(3, reset=1)
        s.step(2, reset=0)
        s.expect("RESET DRV clears the count", count=0)
        s.init(0x5601, first=1 - stray)
        s.expect(count=0x5601)
        s.value(0x5601, first=1 - stray)
        await s.run(dut)


class Bytes(Scripts, of=Encoder, req="ENC-2"):
    a_byte_written_is_stored_at_once = """
        init(0x1111) write(MSB, 0x22) expect(count=0x2211) other() write(LSB, 0x33)
        expect(count=0x2233) turn(1) settle() write(LSB, 0x44)
        expect('again the same byte', count=0x2244)"""
    # Each clock of the latch input is an event of its own: the later one stands
    latches_of_neighbouring_clocks_both_act = """
        init(50) turn(1, clocks=3) step(latch=1) step(latch=1) step(latch=0) settle()
        value(51, 'the second, which saw the edge') turn(3) settle() value(54, 'live')"""


@test("ENC-2", "LAT-1")
async def latch_takes_the_count_of_its_clock(dut):
    """The value before any count of the same clock, whatever the phase between them."""
    for delay in range(6):
        s = Encoder()
        s.turn(1, clocks=1)
        s.step(delay)
        s.step(latch=1)
        s.step(latch=0)
        s.settle()
        s.value(0 if delay < 2 else 1, f"latch {delay + 1} clocks after the edge")
        await s.run(dut)


@test("ENC-1")
async def filter_swallows_glitches(dut):
    """With Filter = 2 a pulse of one or two CLKs is nothing, a long one counts."""
    s = Encoder(filtered=True)
    for width in (1, 2):
        s.step(width, a=1)
        s.step(12, a=0)
        s.expect(f"glitch of {width}", count=0, illegal=0)
    s.turn(4, clocks=12)
    s.step(12)
    s.expect("slow turning", count=4)
    s.turn(-6, clocks=12)
    s.step(12)
    s.expect("and back", count=0xFFFE)
    if not isinstance_model(dut):
        await s.run(dut)


def isinstance_model(dut) -> bool:
    """The reference model has no filter."""
    return not hasattr(dut, "go_i")


OUT = Layout(thct2000.OUTS)


class Walk:
    """Random pins: turning at any legal speed, glitches, latches, bus, modes, resets."""

    def __init__(self, seed: str, operations: int) -> None:
        self.rng = random.Random(seed)
        self.pins = dict(IDLE)
        self.words: list[int] = []
        self.phase = 0
        self.speed = 0.5
        self.direction = 1
        self.slow = False
        self.ticked = True  # since the last move: one change per CLK, unless meant
        for _ in range(operations):
            self._operation()

    def _put(self, clocks: int = 1, **pins) -> None:
        rng = self.rng
        for _ in range(clocks):
            self.pins.update(pins)
            if self.slow:
                self.pins["clk_en"] = int(rng.random() < 0.3)
            if self.ticked and rng.random() < self.speed:
                self.ticked = False
                self.phase += self.direction
                if rng.random() < 0.1:
                    self.direction = -self.direction
                if rng.random() < 0.02 and 1 <= self.pins["m"] <= 5:
                    self.phase += 1  # both inputs at once
                self.pins["a"], self.pins["b"] = GREY[self.phase % 4]
            self.ticked |= bool(self.pins["clk_en"])
            self.words.append(IN.pack(self.pins))

    def _operation(self) -> None:
        rng, kind = self.rng, self.rng.random()
        self.speed = rng.choice((0, 0.1, 0.5, 1.0)) if rng.random() < 0.2 else self.speed
        if self.slow:
            self.speed = min(self.speed, 0.1)
        if kind < 0.45:
            self._put(rng.choice((2, 3, 4)), cs_n=0, rd_n=0, rs=rng.getrandbits(1))
            self._put(cs_n=1, rd_n=1, rs=rng.getrandbits(1))
        elif kind < 0.65:
            value = rng.choice((0, 0xFF, 0xFE, rng.getrandbits(8)))
            self._put(rng.choice((1, 2)), cs_n=0, wr_n=0, rs=rng.getrandbits(1), d=value)
            self._put(cs_n=1, wr_n=1, rs=rng.getrandbits(1), d=rng.getrandbits(8))
        elif kind < 0.85:
            self._put(rng.choice((1, 1, 4)), latch=1)
            self._put(latch=0)
        elif kind < 0.88:
            # let double changes pass the synchroniser before the mode becomes one of 0, 6, 7
            speed, self.speed, slow, self.slow = self.speed, 0, self.slow, False
            self._put(6, clk_en=1)
            self._put(1, m=rng.choice((5, 5, 5, 0, 1, 2, 3, 4, 6, 7)))
            self._put(6)
            self.speed, self.slow = speed, slow
        elif kind < 0.89:
            self._put(rng.choice((1, 3)), reset=1)
            self._put(reset=0)
        elif kind < 0.97:
            self._put(rng.choice((1, 4)), other=1)
            self._put(other=0)
        elif kind < 0.985:
            self.slow = not self.slow
            self.pins["clk_en"] = 1
        self._put(rng.choice((0, 1, 2, 6)))


@test("ENC-1", "ENC-2")
async def random_against_the_model(dut):
    seed = f"{os.environ.get('COCOTB_RANDOM_SEED', '1989')}-thct2000"
    bench, compared = Bench(dut, THCT2000), 0
    for piece in range(max(1, QUICK_OPS // 20_000)):
        words = Walk(f"{seed}-{piece}", min(QUICK_OPS, 20_000)).words
        model = thct2000.Thct2000()
        for at, (word, got) in enumerate(zip(words, await bench.replay(words), strict=True)):
            want = model.clock(word)
            wrong = mismatch(OUT, want, got)
            where = f"seed {seed}-{piece} {bench.clock_at(at)}"
            assert not wrong, f"{where}: {wrong}; pins {IN.unpack(word)}"
            compared += "d_o" in want
    assert compared > QUICK_OPS
