# SPDX-License-Identifier: Apache-2.0
"""What a process makes once."""

import functools
import threading


def once(make):
    """functools.cache for what has an identity: threads that ask at the same time get one object,
    where functools.cache lets each of them make its own."""
    cached, guard = functools.cache(make), threading.Lock()
    locks: dict[tuple, threading.RLock] = {}

    @functools.wraps(make)
    def held(*given):
        with guard:
            own = locks.setdefault(given, threading.RLock())
        with own:
            return cached(*given)

    return held
