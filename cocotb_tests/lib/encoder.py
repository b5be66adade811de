# SPDX-License-Identifier: Apache-2.0
"""Quadrature encoders on pins: speed, direction, index, glitches."""

from cocotb.triggers import Timer

# {B, A} by quarter period: A leads B, so going up this list counts up
PHASES = ((0, 0), (1, 0), (1, 1), (0, 1))


class Pins:
    """A packed input of the design whose bits belong to different models."""

    def __init__(self, handle, value: int = 0):
        self.handle, self.value = handle, value
        handle.value = value

    def set(self, bit: int, level: int) -> None:
        new = self.value & ~(1 << bit) | (level & 1) << bit
        if new != self.value:
            self.value = new
            self.handle.value = new


class EncoderSource:
    """One encoder of `lines` lines on bit `axis` of the three inputs."""

    def __init__(self, a: Pins, b: Pins, i: Pins, axis: int, *, lines: int = 0):
        self.a, self.b, self.i, self.axis, self.lines = a, b, i, axis, lines
        self.count = 0  # what an ideal counter would show, not wrapped

    @property
    def phase(self) -> int:
        return self.count % 4

    def _drive(self) -> None:
        a, b = PHASES[self.phase]
        self.a.set(self.axis, a)
        self.b.set(self.axis, b)
        if self.lines:
            self.i.set(self.axis, int(self.count % (4 * self.lines) == 0))

    def step(self, direction: int) -> None:
        """One count at this instant."""
        self.count += direction
        self._drive()

    async def move(self, counts: int, ns_per_count: float) -> None:
        direction = 1 if counts > 0 else -1
        ps = int(ns_per_count * 1000) & ~1
        for _ in range(abs(counts)):
            self.step(direction)
            await Timer(ps, "ps")

    async def glitch(self, ns: float, line: str = "a") -> None:
        """A pulse on one line that comes back: one count there and back, if it is seen at all."""
        pins = self.a if line == "a" else self.b
        level = pins.value >> self.axis & 1
        pins.set(self.axis, 1 - level)
        await Timer(int(ns * 1000), "ps")
        pins.set(self.axis, level)

    def jump(self) -> None:
        """Both lines at once: an illegal transition, which counts nothing."""
        a, b = PHASES[(self.phase + 2) % 4]
        self.a.set(self.axis, a)
        self.b.set(self.axis, b)
        self.count += 2

    async def index(self, ns: float) -> None:
        self.i.set(self.axis, 1)
        await Timer(int(ns * 1000), "ps")
        self.i.set(self.axis, 0)
