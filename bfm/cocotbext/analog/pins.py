# SPDX-License-Identifier: Apache-2.0
"""A voltage into an A/D's pin, a voltage out of a D/A's: signed, full scale is half the range."""

import math

import cocotb
from cocotb.triggers import First, ReadOnly, Timer
from cocotb.utils import get_sim_time
from cocotbext.mmcs import Pins, logger, number, seeded, whole

WIDTH = 16  # lines of one channel
FULL_V = 10.0  # of which the most negative number stands for the opposite


class _Scale:
    """Volts and numbers of one channel."""

    def __init__(self, width: int, full_v: float):
        self.width = whole("width", width, 2, 64)
        self.full_v = number("full_v", full_v, 1e-6, 1e6)
        self.top = 1 << width - 1

    def number(self, volts: float) -> int:
        """The nearest number; the top one where full scale itself has none."""
        return max(-self.top, min(self.top - 1, round(volts / self.full_v * self.top)))

    def signed(self, bits: int) -> int:
        return bits - 2 * self.top if bits & self.top else bits


class AnalogSource:
    """A voltage on channel `lane` of a packed input: a handle, or `Pins` that channels share.

    `noise_v`: the standard deviation of what is added to every value, from the seed.
    """

    def __init__(
        self, pins, lane: int = 0, *, width: int = WIDTH, full_v: float = FULL_V,
        noise_v: float = 0.0, seed=None,
    ):  # fmt: skip
        self.scale = _Scale(width, full_v)
        self.pins = pins if isinstance(pins, Pins) else Pins(pins, width=width)
        if self.pins.width != width:
            raise ValueError(f"pins of {self.pins.width} lines a channel, not {width}")
        self.lane = whole("lane", lane, 0, self.pins.lanes - 1)
        self.noise_v = number("noise_v", noise_v, 0, full_v)
        self.random = seeded(seed)
        self.log = logger("analog", self.pins.handle)
        self.volts = 0.0  # as asked for, without noise

    def set(self, volts: float) -> None:
        """This voltage from now on."""
        self.volts = number("volts", volts, -self.scale.full_v, self.scale.full_v)
        noise = self.random.gauss(0.0, self.noise_v) if self.noise_v else 0.0
        self.pins.set(self.lane, self.scale.number(volts + noise))

    def raw(self, value: int) -> None:
        """This number, without noise."""
        top = self.scale.top
        self.pins.set(self.lane, whole("value", value, -top, top - 1))
        self.volts = value * self.scale.full_v / top

    async def ramp(self, to: float, seconds: float, step_s: float) -> None:
        """Straight from the present voltage."""
        start = self.volts
        number("volts", to, -self.scale.full_v, self.scale.full_v)
        await self.follow(lambda t: start + (to - start) * t / seconds, seconds, step_s)

    async def sine(
        self, amplitude: float, hz: float, seconds: float, step_s: float, offset: float = 0.0
    ) -> None:
        number("amplitude and offset", abs(amplitude) + abs(offset), 0, self.scale.full_v)
        number("hz", hz, 0, 1e12)
        turn = 2 * math.pi * hz
        await self.follow(lambda t: offset + amplitude * math.sin(turn * t), seconds, step_s)

    async def follow(self, volts, seconds: float, step_s: float) -> None:
        """A voltage by the time in seconds, in steps of `step_s`; it ends with the last."""
        if not callable(volts):
            raise TypeError(f"volts is a function of the time, not {volts!r}")
        number("seconds", seconds, 1e-12, 1e6)
        number("step_s", step_s, 1e-12, seconds)
        begin = get_sim_time("ps")
        steps = round(seconds / step_s)
        for n in range(steps + 1):
            if n:
                wait = round(begin + n * step_s * 1e12) - round(get_sim_time("ps"))
                await Timer(max(1, wait), "ps")
            self.set(volts(n * step_s))
        self.log.debug("%g V after %g s", self.volts, seconds)


class AnalogSink:
    """The voltage on channel `lane` of a packed output."""

    def __init__(self, handle, lane: int = 0, *, width: int = WIDTH, full_v: float = FULL_V):
        self.scale, self.handle = _Scale(width, full_v), handle
        self.lane = whole("lane", lane, 0, len(handle) // width - 1)
        self.log = logger("analog", handle)
        self.history: list[tuple[float, float]] = []  # ns, volts; once `record()` was called
        self._task = None

    def raw(self) -> int:
        value = self.handle.value
        if not value.is_resolvable:
            raise ValueError(f"{self.handle._path} is {value}: not driven, or not known")
        bits = int(value) >> self.scale.width * self.lane
        return self.scale.signed(bits & 2 * self.scale.top - 1)

    def volts(self) -> float:
        return self.raw() * self.scale.full_v / self.scale.top

    def record(self) -> None:
        """Keeps every change from now on, the present value first."""
        if self._task is None:
            self._task = cocotb.start_soon(self._record())

    def stop(self) -> None:
        if self._task:
            self._task.cancel()
            self._task = None

    async def _record(self) -> None:
        while True:
            await ReadOnly()
            volts = self.volts()
            if not self.history or self.history[-1][1] != volts:
                self.history.append((get_sim_time("ns"), volts))
                self.log.debug("%g V", volts)
            await self.handle.value_change

    async def reaches(self, volts: float, within: float, ns: float) -> float:
        """The ns until it is within so many volts of that; AssertionError if not in `ns`."""
        number("volts", volts, -self.scale.full_v, self.scale.full_v)
        number("within", within, 0, self.scale.full_v)
        begin = get_sim_time("ns")
        limit = Timer(round(number("ns", ns, 0.001, 1e12) * 1000), "ps")
        while abs(self.volts() - volts) > within:
            if await First(self.handle.value_change, limit) is limit:
                raise AssertionError(
                    f"{self.handle._path}, lane {self.lane}: {self.volts():g} V after {ns:g} ns, "
                    f"not {volts:g} V within {within:g} V"
                )
        return get_sim_time("ns") - begin
