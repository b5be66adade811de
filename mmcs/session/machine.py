# SPDX-License-Identifier: Apache-2.0
"""The machine of a setup, built if need be; and the bar that shows how far a run is."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from pathlib import Path

from mmcs.scenario.setup import Setup
from mmcs.screen import console


def machine(setup: Setup, kind: str = "speed", skip: bool | None = None, host: str = "native"):
    """The setup's machine in power-on state; skip: as the scenario says, or so."""
    from mmcs.engine import hosts
    from mmcs.engine.build import ensure_library
    from mmcs.engine.sim import Sim

    scenario = setup.scenario
    if skip is None:
        skip = scenario.skip and kind == "speed"  # waveforms and assertions look at every clock
    on = hosts.config(host)
    library = ensure_library(scenario.cards, kind, scenario.clk_hz, soc=host == "rv32")
    config = setup.config() | {"skip": int(skip)} | on
    return Sim(library, config, setup.motors(), setup.links())


class Tracing:
    """A Sim that traces a stretch of the motion, told in seconds since its start."""

    def __init__(self, sim, path: Path, stretch: tuple[float, float]):
        self._sim, self._path, self._stretch = sim, path, stretch

    def __getattr__(self, name):
        return getattr(self._sim, name)

    def start_motion(self, client: int) -> int:
        start = self._sim.time
        self._sim.trace_window(self._path, *(start + seconds for seconds in self._stretch))
        return self._sim.start_motion(client)


@contextmanager
def progress(duration: float):
    """A bar, once the run has taken a second, if somebody watches."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    began, bar, task = time.monotonic(), None, None

    def advance(done: float) -> None:
        nonlocal bar, task
        if bar is None and time.monotonic() - began > 1.0:
            columns = (TextColumn("{task.completed:.2f} s of {task.total:g} s simulated"),
                       BarColumn(), TimeRemainingColumn())  # fmt: skip
            bar = Progress(*columns, console=console(stderr=True), transient=True)
            bar.start()
            task = bar.add_task("run", total=duration)
        if bar is not None:
            bar.update(task, completed=done)

    try:
        yield advance
    finally:
        if bar is not None:
            bar.stop()
