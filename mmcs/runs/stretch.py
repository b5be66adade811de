# SPDX-License-Identifier: Apache-2.0
"""A run that only a stretch of is traced: the machine changes builds on the way, by snapshots."""

from pathlib import Path

import numpy as np

from mmcs.errors import RunError


class Changing:
    """A Sim for a session: the machine without waveforms, but for a stretch with them.

    Times are of power-on. A stretch that begins before `start`, the start of motion, is reached
    from power-on with waveforms: only then are there instants to change at.
    """

    def __init__(self, quick, traced, path: Path, stretch: tuple[float, float], start: float):
        self._quick, self._traced, self._path = quick, traced, path
        self._from, self._to = stretch
        self._pending: list[np.ndarray] = []  # rows of the log that nobody has taken yet
        self._now, self._left = quick, False
        if self._from < start:
            self._open()

    def __getattr__(self, name):
        return getattr(self._now, name)

    def _open(self) -> None:
        self._now = self._traced
        self._traced.trace(self._path, self._from, self._to)

    def run(self, until_s: float) -> bool:
        if self._now is self._quick and not self._left and until_s >= self._from:
            self._hand_over(self._quick, self._traced, self._from)
            self._open()
        if self._now is self._traced and until_s >= self._to:
            try:
                self._hand_over(self._traced, self._quick, until_s)
            except RunError:
                return False  # an assertion has failed
            self._now, self._left = self._quick, True
        return self._now.run(until_s)

    def play(self, script, until: float) -> tuple[int, str]:
        """As Sim.play(); the script goes on in the other build."""
        begins = self._now is self._quick and not self._left
        for t in (self._from - script.start, until) if begins else (until,):
            if t <= until:
                result = script.act(self._now, t)
                if result[0] or not self.run(script.start + t):
                    return result[0] or 1, result[1]
        return 0, ""

    def _hand_over(self, old, new, at: float) -> None:
        """old runs until `at`; new is then where old was last idle before."""
        self._pending.append(old.take_log())
        last = old.snapshot(at)
        new.restore_bytes(old.snapshot_bytes(last), old.history_bytes())

    def take_log(self) -> np.ndarray:
        rows = [*self._pending, self._now.take_log()]
        self._pending = []
        return np.concatenate(rows)
