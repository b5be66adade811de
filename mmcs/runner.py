# SPDX-License-Identifier: Apache-2.0
"""`mmcs run`: library, session, progress, results."""

from __future__ import annotations

import os
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from mmcs.errors import InputError
from mmcs.load import short
from mmcs.setup import Setup


def run_scenario(
    setup: Setup,
    folder: Path,
    trace: Path | None = None,
    realtime: bool = False,
    host: str = "native",
    started: float | None = None,
    carry_out=None,
) -> bool:
    """Runs, writes folder and prints the table; True when every expectation held.

    carry_out: what makes a result of the setup, when not simulate().
    """
    from rich.console import Console

    from mmcs import record as records
    from mmcs import report as reports
    from mmcs import snapshots
    from mmcs.plot import write_plot

    for place in [folder] + ([trace.parent] if trace else []):
        _make_folder(place)
    result = carry_out(setup) if carry_out else simulate(setup, trace, realtime, host=host)
    report = reports.make_report(result, host)
    reports.write_report(report, folder)
    reports.write_log(result, folder)
    record = records.make_record(result, host)
    records.write_record(record, folder)
    snapshots.write_snapshots(folder / snapshots.NAME, record, result)
    write_plot(result, folder / "plot.svg")
    console = Console(highlight=False, soft_wrap=True)
    reports.print_report(report, result, folder, console)
    if result.first_motion_wall and started:
        # The Makefile passes the moment it started, so that installation and build count.
        began = float(os.environ.get("MMCS_STARTED") or started)
        console.print(f"time to first motion {result.first_motion_wall - began:.1f} s")
    console.print(f"results in {short(folder)}" + (f", trace {short(trace)}" if trace else ""))
    return all(item["ok"] for item in report["expect"])


def simulate(
    setup: Setup,
    trace: Path | None = None,
    realtime: bool = False,
    snapshots_at: tuple[float, ...] = (),
    host: str = "native",
):
    """Carries the setup out on the real machine."""
    from mmcs.session import Session
    from mmcs.snapshots import Taking

    duration = setup.scenario.duration
    kind = "trace" if trace else "speed"
    with machine(setup, kind, host=host) as sim, progress(duration) as advance:
        if trace:
            sim.trace(trace)
        taking = Taking(sim, snapshots_at, duration)
        result = Session(taking, setup, realtime).run(advance)
        result.snapshots = taking.taken(), sim.history_bytes()
        return result


def machine(setup: Setup, kind: str = "speed", skip: bool | None = None, host: str = "native"):
    """The setup's machine in power-on state; skip: as the scenario says, or so."""
    from mmcs import hosts
    from mmcs.build import ensure_library
    from mmcs.sim import Sim

    scenario = setup.scenario
    if skip is None:
        skip = scenario.skip and kind == "speed" and host != "rv32"
    on = hosts.config(host)
    library = ensure_library(scenario.cards, kind, scenario.clk_hz, soc=host == "rv32")
    config = setup.config() | {"skip": int(skip)} | on
    return Sim(library, config, setup.motors(), setup.links())


@contextmanager
def progress(duration: float):
    """A bar, once the run has taken a second, if somebody watches."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    began, bar, task = time.monotonic(), None, None

    def advance(done: float) -> None:
        nonlocal bar, task
        if bar is None and time.monotonic() - began > 1.0:
            columns = (TextColumn("{task.completed:.2f} s of {task.total:g} s simulated"),
                       BarColumn(), TimeRemainingColumn())  # fmt: skip
            bar = Progress(*columns, console=Console(stderr=True), transient=True)
            bar.start()
            task = bar.add_task("run", total=duration)
        if bar is not None:
            bar.update(task, completed=done)

    try:
        yield advance
    finally:
        if bar is not None:
            bar.stop()


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.one(folder, "", None, f"cannot be made: {error.strerror}") from None
