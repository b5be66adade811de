# SPDX-License-Identifier: Apache-2.0
"""A stimulus as a line of text: what pins do, and when."""

from collections.abc import Awaitable, Callable


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
