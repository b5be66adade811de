# SPDX-License-Identifier: Apache-2.0
"""The fewest of random actions that still fail."""

from collections.abc import Callable


def shrunk(actions: list, fails: Callable[[list], bool]) -> list:
    """Of actions that fail together: some that still do, while without any one of them none does.
    Leaves out halves first, then quarters, at last single ones."""
    size = len(actions)
    while True:
        size, before, at = max(size // 2, 1), len(actions), 0
        while at < len(actions):
            fewer = actions[:at] + actions[at + size :]
            if fails(fewer):
                actions = fewer
            else:
                at += size
        if size == 1 and len(actions) == before:
            return actions
