# SPDX-License-Identifier: Apache-2.0
"""How simulated time follows the clock on the wall."""

import time

# Simulated time between looks at the sockets: short while somebody talks or has been signalled, so
# that a free-running machine does not run away from its programs; it doubles up to the longest.
CHUNK_MIN_S, CHUNK_MAX_S = 50e-6, 2e-3
IDLE_S = 0.1  # longest sleep: signals are seen this often
BEHIND_S = 0.02  # jitter of the computer; what is lost beyond it is not made up


class Pace:
    def __init__(self, sim, now, speed: float | None):
        """now: the server's mmcs_server. speed: simulated seconds per second; None runs as fast as
        it goes."""
        self._sim, self._now = sim, now
        self.chunk = CHUNK_MIN_S
        self.set(speed, False)

    def set(self, speed: float | None, paused: bool) -> None:
        self._now.speed, self._now.paused = speed or 0, paused
        self.restart()

    def restart(self) -> None:
        """Time is counted from here on."""
        self._started = (time.monotonic(), self._sim.time)

    def wait(self) -> float:
        """Seconds until the next chunk is due."""
        if self._now.paused:
            return IDLE_S
        if not self._now.speed:
            return 0.0
        wall, simulated = self._started
        left = wall + (self._sim.time - simulated) / self._now.speed - time.monotonic()
        if left < -BEHIND_S:
            self.restart()
        return min(max(0.0, left), IDLE_S)

    def is_due(self) -> bool:
        return not self._now.paused and self.wait() == 0

    def talked(self) -> None:
        self.chunk = CHUNK_MIN_S

    def passed(self, signalled: bool) -> None:
        self.chunk = CHUNK_MIN_S if signalled else min(2 * self.chunk, CHUNK_MAX_S)
