# SPDX-License-Identifier: Apache-2.0
"""A quadrature decoder on pins: counts, and tells what no encoder may do."""

import cocotb
from cocotbext.mmcs import Pins, Watch, logger, number, whole
from cocotbext.quadrature.source import PHASES


class QuadratureDecoder:
    """Follows lane `lane` of A, B and, if there is one, I; each a handle or `Pins`.

    `count` goes up while A leads B; `errors` holds the ns at which both lines moved at once, or
    an edge came sooner than `shortest_ns` after the last; with `fail` the first fails the test.
    `indices` holds (ns, count) of each rising index.
    """

    def __init__(self, a, b, i=None, lane: int = 0, *, shortest_ns: float = 0, fail: bool = True):
        self._handles = [h.handle if isinstance(h, Pins) else h for h in (a, b, i) if h is not None]
        for handle in self._handles:
            whole("lane", lane, 0, len(handle) - 1)
        self.lane, self.fail = lane, fail
        self.limit = number("shortest_ns", shortest_ns, 0, 1e12)
        self.count, self.edges = 0, 0
        self.errors: list[float] = []
        self.indices: list[tuple[float, int]] = []
        self.shortest_ns = float("inf")  # seen between two edges
        self.log = logger("quadrature", self._handles[0])
        self._watch = Watch(*self._handles)
        self._task = cocotb.start_soon(self._run())

    def stop(self) -> None:
        self._watch.stop()
        self._task.cancel()

    def _look(self) -> list[int]:
        """Unknown lines count as low."""
        levels = []
        for handle in self._handles:
            value = handle.value
            levels.append(int(value) >> self.lane & 1 if value.is_resolvable else 0)
        return levels

    async def _run(self) -> None:
        await self._watch.rest()
        was, last = self._look(), float("-inf")
        while True:
            ns = await self._watch.settled()
            now = self._look()
            moved = (PHASES.index(tuple(now[:2])) - PHASES.index(tuple(was[:2]))) % 4
            if moved:
                self.edges += 1
                self.shortest_ns = min(self.shortest_ns, ns - last)
                if ns - last < self.limit:
                    self._error(ns, f"an edge {ns - last:g} ns after the last, not {self.limit:g}")
                last = ns
            if moved == 2:
                self._error(ns, "A and B moved at once")
            else:
                self.count += (0, 1, 0, -1)[moved]
            if now[2:] > was[2:]:
                self.indices.append((ns, self.count))
            was = now

    def _error(self, ns: float, what: str) -> None:
        self.errors.append(ns)
        self.log.warning("at %g ns: %s", ns, what)
        if self.fail:
            raise AssertionError(f"quadrature at {ns:g} ns: {what}")
