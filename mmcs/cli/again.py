# SPDX-License-Identifier: Apache-2.0
"""`mmcs replay` and `mmcs trace`: runs made again."""

import sys
from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.screen import echo

_run = click.argument("run", metavar="RUN")


@click.command()
@_run
def replay(run: str) -> None:
    """Make a run again from its record: status 0 the same to the bit, 1 it differs.

    RUN is a run.mmcs, its folder, or the name of a scenario that has run.
    """
    from mmcs.runs import replay as replays
    from mmcs.runs.record import read_record

    record = read_record(run)
    hash_, where = replays.replay(record)
    if where is None:
        echo(f"{record.path}: reproduced, hash {hash_}")
        return
    echo(f"{record.path}: differs, hash {hash_} instead of {record.hash}")
    echo(f"  first at {where}")
    for text in replays.cautions(record):
        echo(f"  {text}")
    sys.exit(1)


@click.command()
@_run
@click.option("--at", required=True, metavar="T|KIND", help="Seconds of motion, or panic, error...")
@click.option("--window", default=2.0, metavar="MS", help="How long the stretch is, around it.")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.fst", help="The trace.")
@click.option("--view", is_flag=True, help="Open it in a viewer.")
def trace(run: str, at: str, window: float, out: Path | None, view: bool) -> None:
    """Waveforms of a stretch of a run that was not traced.

    RUN is a run.mmcs, its folder, or the name of a scenario that has run. The run is made again
    from the nearest of its snapshots, in the stretch clock by clock with all assertions live.
    """
    from mmcs.folder import check_file
    from mmcs.runs import replay as replays
    from mmcs.runs.record import read_record
    from mmcs.view.waves import open_viewer, write_views

    if out is not None and out.suffix != ".fst":
        raise InputError.one("--out", "", str(out), "must be a file name ending in .fst")
    record = read_record(run)
    from_s, to_s = replays.stretch(record, at, window)
    path = check_file(out or replays.default_path(record, from_s, to_s))
    snapshot, where = replays.trace(record, path, from_s, to_s)
    begin, end = from_s - record.motion_start_s, to_s - record.motion_start_s
    echo(f"{path}: {begin:.6f} to {end:.6f} s of motion ({from_s:.6f} s after power-on)")
    origin = "power-on" if snapshot is None else f"the snapshot at {snapshot:.6f} s"
    echo(f"made again from {origin}")
    write_views(path)
    if where is not None:
        echo(f"caution: this is not the same run; it differs first at {where}")
        sys.exit(1)
    echo(f"the run made again has the same hash, {record.hash}")
    if view:
        open_viewer(path)
