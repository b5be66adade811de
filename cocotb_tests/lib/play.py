# SPDX-License-Identifier: Apache-2.0
"""A stimulus as a line of text: what pins do, and when."""

from collections.abc import Awaitable, Callable

from cocotb.triggers import Timer
from cocotbext.mmcs.bus import Bus


async def play(
    text: str, put: Callable[[str, int], None], wait: Callable[[float], Awaitable]
) -> None:
    """In their order: `pin=value` sets a pin, a number lets so much time pass."""
    for word in text.split():
        name, is_pin, value = word.partition("=")
        if is_pin:
            put(name, int(value, 0))
        else:
            await wait(float(name))


async def drive(bus: Bus, text: str) -> None:
    """The signals of a bus by their short names; times in ns."""

    def put(name: str, value: int) -> None:
        getattr(bus, name).value = value

    await play(text, put, lambda ns: Timer(round(ns), "ns"))
