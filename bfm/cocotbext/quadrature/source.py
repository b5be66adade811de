# SPDX-License-Identifier: Apache-2.0
"""A quadrature encoder on pins: steps, moves, profiles with every edge at its time, and faults."""

import math

from cocotb.triggers import Timer
from cocotb.utils import get_sim_time
from cocotbext.mmcs import Pins, lane_of, logger, number, one_of, whole

# {A, B} by quarter period: A leads B, so going up this list counts up
PHASES = ((0, 0), (1, 0), (1, 1), (0, 1))


def when(share: float, v0: float, v1: float) -> float:
    """The share of the time after which that share of a way is gone, at speeds from v0 to v1."""
    # (v0 t + (v1 - v0) t^2 / 2) / ((v0 + v1) / 2) = share, in the form that loses no digits
    c = share * (v0 + v1) / 2
    return 2 * c / (v0 + math.sqrt(max(0.0, v0 * v0 + 2 * (v1 - v0) * c))) if c else 0.0


class QuadratureSource:
    """One encoder on lane `lane` of A, B and, if there is one, I; each a handle or shared `Pins`.

    `lines`: an index at every 4 x lines counts. `phase_error_deg` shifts B against A,
    `duty_error_deg` makes every high longer; 90 degrees are one count.
    """

    def __init__(
        self, a, b, i=None, lane: int = 0, *, lines: int = 0, phase_error_deg: float = 0.0,
        duty_error_deg: float = 0.0,
    ):  # fmt: skip
        pins = [p if p is None or isinstance(p, Pins) else Pins(p) for p in (a, b, i)]
        self.a, self.b, self.i = pins
        self.lane = min(lane_of(p, lane) for p in pins if p is not None)
        self.lines = whole("lines", lines, 0)
        if self.lines and self.i is None:
            raise ValueError("lines, the index's, needs the signal i")
        number("phase_error_deg", phase_error_deg, -44, 44)
        number("duty_error_deg", duty_error_deg, -44, 44)
        number("phase and duty error together", abs(phase_error_deg) + abs(duty_error_deg), 0, 44)
        b_late, low_late = phase_error_deg / 90, duty_error_deg / 90
        # how far, in counts, the edge into each phase is beyond its place
        self.shifts = (b_late + low_late, 0.0, b_late, low_late)
        self.log = logger("quadrature", self.a.handle)
        self.count = 0  # what an ideal counter would show, not wrapped
        self._rest = 0.0  # of the position that profiles have left, in counts from `count`

    @property
    def phase(self) -> int:
        return self.count % 4

    def _drive(self) -> None:
        a, b = PHASES[self.phase]
        self.a.set(self.lane, a)
        self.b.set(self.lane, b)
        if self.lines:
            self.i.set(self.lane, int(self.count % (4 * self.lines) == 0))

    def step(self, direction: int) -> None:
        """One count at this instant."""
        self.count += one_of("direction", direction, (1, -1))
        self._drive()

    def _shift(self, direction: int) -> float:
        """Of the next edge in that direction: positive is later, in its own direction."""
        return direction * self.shifts[(self.count + (direction > 0)) % 4]

    async def move(self, counts: int, ns_per_count: float) -> None:
        """So many counts, the first at once, the end one period after the last."""
        whole("counts", counts, -(1 << 62))
        number("ns_per_count", ns_per_count, 0.002, float(1 << 62))
        direction = 1 if counts > 0 else -1
        ps = int(ns_per_count * 1000) & ~1
        if not any(self.shifts):
            for _ in range(abs(counts)):
                self.step(direction)
                await Timer(ps, "ps")
            return
        lead = max(0.0, -min(direction * s for s in self.shifts))
        done = 0
        for n in range(abs(counts)):
            due = max(done, round((n + lead + self._shift(direction)) * ps))
            if due > done:
                await Timer(due - done, "ps")
            self.step(direction)
            done = due
        await Timer(max(1, round((abs(counts) + lead) * ps) - done), "ps")

    # -- profiles ------------------------------------------------------------------------------

    async def profile(self, segments) -> None:
        """Segments (seconds, speed at its begin, at its end) in counts a second, edges exact."""
        pieces = []
        for n, segment in enumerate(segments):
            if not isinstance(segment, tuple) or len(segment) != 3:
                raise TypeError(f"segment {n} is (seconds, speed, speed), not {segment!r}")
            number(f"seconds of segment {n}", segment[0], 1e-12, 1e6)
            for speed in segment[1:]:
                number(f"speed of segment {n}, counts a second,", speed, -5e11, 5e11)
            pieces.append(segment)
        begin, at = get_sim_time("ps"), 0.0
        for seconds, v0, v1 in pieces:
            turn = v0 / (v0 - v1) if v0 * v1 < 0 else 0.0
            halves = ((seconds * turn, v0, 0.0), (seconds * (1 - turn), 0.0, v1))
            for part in halves if turn else ((seconds, v0, v1),):
                await self._ramp(begin + at * 1e12, *part)
                at += part[0]
        await self._until(begin + at * 1e12)

    async def follow(self, position, seconds: float, step_s: float) -> None:
        """A position in counts by the time in seconds, straight between steps of `step_s`."""
        if not callable(position):
            raise TypeError(f"position is a function of the time, not {position!r}")
        number("seconds", seconds, 1e-12, 1e6)
        number("step_s", step_s, 1e-12, seconds)
        begin, old = get_sim_time("ps"), float(position(0.0))
        steps = math.ceil(seconds / step_s - 1e-9)
        for n in range(steps):
            t0, t1 = n * step_s, min(seconds, (n + 1) * step_s)
            new = number("the position", position(t1), -1e15, 1e15)
            speed = (new - old) / (t1 - t0)
            await self._ramp(begin + t0 * 1e12, t1 - t0, speed, speed)
            old = new
        await self._until(begin + seconds * 1e12)

    async def _ramp(self, begin_ps: float, seconds: float, v0: float, v1: float) -> None:
        """Uniformly accelerated, in one direction: an edge wherever the position passes one."""
        direction = 1 if v0 + v1 > 0 else -1
        way = (v0 + v1) / 2 * seconds * direction
        gone, v0, v1 = 0, v0 * direction, v1 * direction
        rest = self._rest * direction  # from the place of the count, in this direction
        while True:
            edge = gone + 0.5 + self._shift(direction) - rest
            if edge >= way:
                break
            at = seconds * when(max(0.0, edge) / way, v0, v1)
            await self._until(begin_ps + at * 1e12)
            self.step(direction)
            gone += 1
        self._rest = direction * (rest + way - gone)

    @staticmethod
    async def _until(ps: float) -> None:
        wait = round(ps) - round(get_sim_time("ps"))
        if wait > 0:
            await Timer(wait, "ps")

    # -- faults --------------------------------------------------------------------------------

    async def glitch(self, ns: float, line: str = "a") -> None:
        """A pulse on one line that comes back: one count there and back, if it is seen at all."""
        one_of("line", line, ("a", "b") if self.i is None else ("a", "b", "i"))
        number("ns", ns, 0.001, 1e12)
        pins = {"a": self.a, "b": self.b, "i": self.i}[line]
        level = pins.get(self.lane)
        pins.set(self.lane, 1 - level)
        await Timer(int(ns * 1000), "ps")
        pins.set(self.lane, level)

    def jump(self) -> None:
        """Both lines at once: an illegal transition, which counts nothing."""
        a, b = PHASES[(self.phase + 2) % 4]
        self.a.set(self.lane, a)
        self.b.set(self.lane, b)
        self.count += 2

    async def index(self, ns: float) -> None:
        """A pulse of the index."""
        if self.i is None:
            raise ValueError("an index needs the signal i")
        number("ns", ns, 0.001, 1e12)
        self.i.set(self.lane, 1)
        await Timer(int(ns * 1000), "ps")
        self.i.set(self.lane, 0)
