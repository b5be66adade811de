# SPDX-License-Identifier: Apache-2.0
"""What the bus models share: checks of arguments, handles by name, packed pins, logging."""

import logging
import random

import cocotb
from cocotb.triggers import Event, ReadOnly
from cocotb.utils import get_sim_time


def whole(what: str, value, least: int, most: int | None = None) -> int:
    """The value, if it is a whole number in range; else one sentence that says what is."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"{what} is a whole number, not {value!r}")
    if value < least or (most is not None and value > most):
        end = "or more" if most is None else f"to {most:#x}" if most > 999 else f"to {most}"
        shown = f"{value:#x}" if abs(value) > 999 else value
        raise ValueError(f"{what} is {least} {end}, not {shown}")
    return value


def number(what: str, value, least: float, most: float) -> float:
    """The value, if it is a number in range."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{what} is a number, not {value!r}")
    if not least <= value <= most:  # NaN is in no range
        raise ValueError(f"{what} is {least:g} to {most:g}, not {value:g}")
    return value


def one_of(what: str, value, choices):
    if value not in choices:
        raise ValueError(f"{what} is one of {', '.join(map(str, choices))}, not {value!r}")
    return value


def span(what: str, value, least: int = 0) -> tuple[int, int]:
    """A time in ns as (shortest, longest); one number stands for both."""
    low, high = value if isinstance(value, tuple) and len(value) == 2 else (value, value)
    whole(what, low, least)
    whole(f"{what}, the longest", high, low)
    return low, high


def check_time_step() -> None:
    """The models wait for picoseconds: a simulator with coarser steps cannot."""
    exponent = cocotb.simulator.get_precision()
    if exponent > -12:
        raise RuntimeError(
            f"the simulator's time step is 1e{exponent} s, but these models need 1 ps: give the "
            'design `timescale 1ns/1ps, or cocotb\'s runner timescale=("1ns", "1ps")'
        )


def seeded(seed) -> random.Random:
    """A generator of its own; without a seed that of the cocotb run."""
    return random.Random(cocotb.RANDOM_SEED if seed is None else whole("seed", seed, 0))


def find(dut, prefix: str, names: dict[str, str], optional=()) -> dict:
    """Handles by short name; those in `optional` may be missing and are None then."""
    found = {}
    for short, name in names.items():
        handle = getattr(dut, f"{prefix}_{name}", None)
        if handle is None and short not in optional:
            raise AttributeError(f"{dut._path} has no signal {prefix}_{name}")
        found[short] = handle
    return found


def logger(kind: str, handle) -> logging.Logger:
    """cocotb.KIND.PATH: the whole kind, or one model, can be turned up by itself."""
    return logging.getLogger(f"cocotb.{kind}.{getattr(handle, '_path', handle)}")


def pin(handle) -> int:
    """The value of a line or of lines; what nobody knows yet counts as high, as at rest."""
    value = handle.value
    return int(value) if value.is_resolvable else (1 << len(handle)) - 1


class Watch:
    """Waits for instants at which some of the lines have moved, and for all to have settled then.

    So neither the simulator's order nor that of the coroutines matters to who looks at them.
    """

    def __init__(self, *handles):
        self._moved = Event()
        self._tasks = [cocotb.start_soon(self._watch(handle)) for handle in handles]

    async def _watch(self, handle) -> None:
        while True:
            await handle.value_change
            self._moved.set()

    async def rest(self) -> None:
        """To the end of this instant, whatever has moved."""
        await ReadOnly()
        self._moved.clear()

    async def settled(self) -> float:
        """The ns of the next such instant."""
        await self._moved.wait()
        await self.rest()
        return get_sim_time("ns")

    def stop(self) -> None:
        for task in self._tasks:
            task.cancel()


class Pins:
    """A packed input of the design: `width` bits for each lane, lanes of different models."""

    def __init__(self, handle, value: int = 0, *, width: int = 1):
        check_time_step()
        self.lanes = len(handle) // whole("width", width, 1, len(handle))
        self.handle, self.width = handle, width
        self.value = whole("value", value, 0, (1 << len(handle)) - 1)
        handle.value = value

    def set(self, lane: int, level: int) -> None:
        mask, at = (1 << self.width) - 1, lane * self.width
        new = self.value & ~(mask << at) | (level & mask) << at
        if new != self.value:
            self.value = new
            self.handle.value = new

    def get(self, lane: int) -> int:
        return self.value >> lane * self.width & (1 << self.width) - 1


def lane_of(pins: Pins, lane: int) -> int:
    return whole("lane", lane, 0, pins.lanes - 1)
