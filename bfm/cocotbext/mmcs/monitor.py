# SPDX-License-Identifier: Apache-2.0
"""What the monitors of all buses have in common: when they look, and what a broken rule does.

A monitor looks once at every instant at which some pin has moved, after all has settled, so that
neither the simulator's order nor that of the coroutines matters.
"""

from typing import ClassVar

import cocotb
from cocotb.utils import get_sim_time
from cocotbext.mmcs import Watch, logger, one_of
from cocotbext.mmcs.bus import Bus, ProtocolError


class Monitor:
    """`cycles` is what was seen, `broken` the rules that were broken, as (rule, ns, sentence).

    With `fail` a broken rule fails the test at once. Rules named in `allow` are not judged. A kind
    of bus has the RULES with their sentences, a _look() at the pins, and _judge() of two looks.
    """

    KIND: ClassVar[str]  # of the logger
    RULES: ClassVar[dict[str, str]]
    WATCHED: ClassVar[tuple[str, ...]]

    def __init__(self, bus: Bus, *, fail: bool, allow):
        self.bus, self.fail = bus, fail
        self.allow = {one_of("a rule to allow", rule, tuple(self.RULES)) for rule in allow}
        self.cycles: list = []
        self.broken: list[tuple[str, float, str]] = []
        self.log = logger(self.KIND, getattr(bus, bus.STROBE))
        self._now = get_sim_time("ns")
        handles = [h for name in self.WATCHED if (h := getattr(bus, name)) is not None]
        self._watch = Watch(*handles)
        self._task = cocotb.start_soon(self._run())

    def stop(self) -> None:
        self._watch.stop()
        self._task.cancel()

    async def _run(self) -> None:
        await self._watch.rest()
        was = self._look()
        while True:
            self._now = await self._watch.settled()
            now = self._look()
            self._judge(was, now)
            was = now

    def _rule(self, name: str, held: bool, detail: str = "") -> None:
        if held or name in self.allow:
            return
        sentence = self.RULES[name] + (f": {detail}" if detail else "")
        self.broken.append((name, self._now, sentence))
        self.log.warning("%s: %s", name, sentence)
        if self.fail:
            raise ProtocolError(f"{name} at {self._now} ns: {sentence}")
