# SPDX-License-Identifier: Apache-2.0
"""The 8255A: modes 0, 1, 2, bit set/reset, mode set, reset; directed and random. §5.3.1."""

import os
import random

from cocotb_tests.chips.ppi import CONTROL, IDLE, IN, SETTLE, A, B, C, Ppi, mode_word, settled
from cocotb_tests.chips.replay import I8255, QUICK_OPS, Bench, Scripts, rows
from cocotb_tests.lib.req import test
from cocotb_tests.models import i8255

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)


rows(__name__, Ppi, lambda row: "PPI-1")


class Ports(Scripts, of=Ppi, req="PPI-1"):
    power_up_is_all_input = "pins(pa_oe=0, pb_oe=0, pc_oe=0, oe=0, d_o=0xFF)"

    def cycle_that_ends_with_reset_is_none(s):
        """The port is neither written nor, in mode 1, read."""
        s.step(SETTLE, cs_n=0, wr_n=0, a=CONTROL, d=mode_word())
        s.step(SETTLE, reset=1)
        s.step(SETTLE, reset=0, cs_n=1, wr_n=1)
        s.pins(pa_oe=0, pb_oe=0, pc_oe=0)
        s.step(SETTLE, cs_n=0, rd_n=0, a=B)
        s.step(SETTLE, reset=1)
        s.step(SETTLE, reset=0, cs_n=1, rd_n=1)
        s.mode(b=1, b_in=1)
        s.strobe(2, pb=0x42)
        s.pins(pc1=1)

    control_word_is_write_only = "write(CONTROL, 0x89) read(CONTROL, 0xFF)"


class Walk:
    """Settled states that differ by one action each; only what the data sheet defines is done."""

    def __init__(self, seed: str, actions: int, modes: bool) -> None:
        self.rng = random.Random(seed)
        self.modes = modes
        self.pins = dict(IDLE)
        self.states: list[int] = []
        self.model = i8255.I8255()
        self.wants: list[dict] = []
        for _ in range(actions):
            self._action()

    def _state(self, **pins) -> None:
        self.pins.update(pins)
        word = IN.pack(self.pins)
        self.states.append(word)
        self.wants.append(self.model.settle(word))

    def _write(self, addr: int, data: int) -> None:
        self._state(cs_n=0, wr_n=0, a=addr, d=data)
        self._state(cs_n=1, wr_n=1)

    def _action(self) -> None:
        rng, kind = self.rng, self.rng.random()
        plain = self.model.plain_bits()
        if kind < 0.10:
            word = 0x80 | rng.getrandbits(7)
            self._write(CONTROL, word if self.modes else word & ~0x64)
        elif kind < 0.25:
            self._write(CONTROL, rng.getrandbits(4))  # set/reset of any line
        elif kind < 0.45:
            port = rng.choice((A, B) if plain != 0xFF else (A, B, C))
            self._write(port, rng.getrandbits(8))
        elif kind < 0.65:
            self._state(cs_n=0, rd_n=0, a=rng.randrange(4))
            self._state(cs_n=1, rd_n=1)
        elif kind < 0.66:
            self._state(reset=1)
            self._state(reset=0)
        elif kind < 0.80:
            # strobes stay high but for their own action
            self._state(pa=rng.getrandbits(8), pb=rng.getrandbits(8))
            self._state(pc=(rng.getrandbits(8) & plain) | (0xFF & ~plain))
        else:
            self._state(pc=self.pins["pc"] | (0xFF & ~plain))
            bit = rng.choice((2, 4, 6))
            if not plain >> bit & 1:
                self._state(pc=self.pins["pc"] & ~(1 << bit))
                self._state(pc=self.pins["pc"] | 1 << bit)
        if self.pins["pc"] | plain != 0xFF:  # a new mode found a strobe low: raise it first
            self._state(pc=self.pins["pc"] | (0xFF & ~self.model.plain_bits()))


async def compare(dut, name: str, modes: bool) -> None:
    seed = f"{os.environ.get('COCOTB_RANDOM_SEED', '1989')}-{name}"
    walk = Walk(seed, min(QUICK_OPS, 20_000), modes)
    words = [w for w in walk.states for _ in range(SETTLE)]
    got = (await Bench(dut, I8255).replay(words))[SETTLE - 1 :: SETTLE]
    assert len(got) == len(walk.wants) > QUICK_OPS // 2
    for at, (want, seen) in enumerate(zip(walk.wants, got, strict=True)):
        wrong = settled(want, seen)
        recent = [IN.unpack(w) for w in walk.states[max(0, at - 3) : at + 1]]
        assert not wrong, f"seed {seed} state {at}: {wrong}; {recent}"


@test("PPI-1")
async def random_mode0(dut):
    await compare(dut, "ppi-mode0", False)


@test("PPI-1")
async def random_all_modes(dut):
    await compare(dut, "ppi-modes", True)
