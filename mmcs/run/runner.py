# SPDX-License-Identifier: Apache-2.0
"""`mmcs run`: library, session, progress, results."""

from __future__ import annotations

import os
from pathlib import Path

from mmcs.errors import InputError, out_of_memory
from mmcs.scenario.files import short
from mmcs.scenario.setup import Setup


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
    from mmcs.record import record as records
    from mmcs.record import snapshots
    from mmcs.result import report as reports
    from mmcs.result.folder import writing
    from mmcs.screen import console as screen

    for place in [folder] + ([trace.parent] if trace else []):
        _make_folder(place)
    with writing(folder) as stage:
        result = carry_out(setup) if carry_out else simulate(setup, trace, realtime, host=host)
        report = reports.make_report(result, host)
        report["log_crc32"] = reports.write_log(result, stage)
        reports.write_report(report, stage)
        record = records.make_record(result, host)
        records.write_record(record, stage)
        lacking = [
            *_spared(
                stage / snapshots.NAME,
                lambda path: snapshots.write_snapshots(path, record, result),
            ),
            *_spared(stage / "plot.svg", lambda path: _draw(result, path)),
        ]
    console = screen()
    reports.print_report(report, result, folder, console)
    if result.first_motion_wall and started:
        # The Makefile passes the moment it started, so that installation and build count.
        began = float(os.environ.get("MMCS_STARTED") or started)
        console.print(f"time to first motion {result.first_motion_wall - began:.1f} s")
    if lacking:
        console.print(f"out of memory: without {' and '.join(lacking)}")
    console.print(f"results in {short(folder)}" + (f", trace {short(trace)}" if trace else ""))
    return all(item["ok"] for item in report["expect"])


def _spared(path: Path, write) -> list[str]:
    """Writes what results can do without; its name if there is no memory left for it."""
    try:
        write(path)
    except (MemoryError, ImportError, OSError) as error:
        if not out_of_memory(error):
            raise
        path.unlink(missing_ok=True)
        return [path.name]
    return []


def _draw(result, path: Path) -> None:
    from mmcs.view.plot import write_plot

    write_plot(result, path)


def simulate(
    setup: Setup,
    trace: Path | None = None,
    realtime: bool = False,
    snapshots_at: tuple[float, ...] = (),
    host: str = "native",
    stretch: tuple[float, float] | None = None,
):
    """Carries the setup out on the real machine; stretch: of the motion, to trace only that."""
    from mmcs.engine.hosts import image_digest
    from mmcs.record.snapshots import Taking
    from mmcs.session.machine import Tracing, machine, progress
    from mmcs.session.session import Session

    duration = setup.scenario.duration
    kind = "trace" if trace else "speed"
    with machine(setup, kind, host=host) as sim, progress(duration) as advance:
        image = image_digest(host)
        traced = Tracing(sim, trace, stretch) if trace and stretch else sim
        if trace and not stretch:
            sim.trace(trace)
        taking = Taking(traced, snapshots_at, duration)
        result = Session(taking, setup, realtime).run(advance)
        result.image, result.snapshots = image, (taking.taken(), sim.history_bytes())
        return result


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.one(folder, "", None, f"cannot be made: {error.strerror}") from None
