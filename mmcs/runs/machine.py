# SPDX-License-Identifier: Apache-2.0
"""The machine of a setup, built if need be; and the bar that shows how far a run is."""

import functools
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from mmcs.errors import RunError
from mmcs.scenario.setup import Setup
from mmcs.screen import console


def machine(
    setup: Setup,
    kind: str = "speed",
    skip: bool | None = None,
    host: str = "native",
    dpi: int | None = None,
    library: Path | None = None,
):
    """The setup's machine in power-on state; skip: as the scenario says, or so.

    dpi: the line to a simulator that has the machine, and not a build of ours. library: the build,
    of those who have asked for it and make many machines.
    """
    from mmcs.engine import hosts
    from mmcs.engine.build import ensure_library
    from mmcs.engine.sim import Sim

    scenario = setup.scenario
    if dpi is not None:
        return _machine_of_simulator(setup, dpi)
    if skip is None:
        skip = scenario.skip and kind == "speed"  # waveforms and assertions look at every clock
    on = hosts.config(host)
    library = library or ensure_library(
        scenario.cards, kind, scenario.clk_hz, scenario.heartbeat_us
    )
    config = setup.config() | {"skip": int(skip)} | on
    return Sim(library, config, setup.motors(), setup.links())


def _machine_of_simulator(setup: Setup, line: int):
    from mmcs.engine.build import HEARTBEAT_US, ensure_library
    from mmcs.engine.dpi import DpiSim, Line
    from mmcs.inputs import UPSET

    for event in setup.scenario.event:
        if event.input.startswith(UPSET):
            raise RunError(f"{event.input}: through DPI no register can be read or written")
    scenario = setup.scenario
    if scenario.heartbeat_us != HEARTBEAT_US:
        raise RunError(f"heartbeat_us: through DPI it must be {HEARTBEAT_US}, as the testbench has")
    testbench = Line(line, ensure_library(scenario.cards, "dpi"))
    for what, has, wanted in (
        ("NumCards", testbench.mmcs_sim_build_cards(), scenario.cards),
        ("ClkHz", testbench.mmcs_sim_build_clk_hz(), scenario.clk_hz),
    ):
        if has != wanted:
            raise RunError(f"the testbench has {what}={has}, and {setup.name} needs {wanted}")
    return DpiSim(testbench, setup.config() | {"skip": 0}, setup.motors(), setup.links())


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


@functools.cache
def _library(cards: int, clk_hz: int, heartbeat_us: int):
    from mmcs.engine.build import ensure_library

    return ensure_library(cards, "speed", clk_hz, heartbeat_us=heartbeat_us)


def library_of(setup):
    """The simulator's library that the setup runs on, which this process looks for once; builds it
    if need be."""
    scenario = setup.scenario
    return _library(scenario.cards, scenario.clk_hz, scenario.heartbeat_us)


def build_of(setup) -> str:
    """Its identity."""
    from mmcs.engine.sim import load_library, make_ffi

    library = load_library(library_of(setup))
    return make_ffi().string(library.mmcs_sim_build_id()).decode()
