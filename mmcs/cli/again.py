# SPDX-License-Identifier: Apache-2.0
"""`mmcs replay` and `mmcs trace`: runs made again."""

import contextlib
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
    hash_, where, other_build = replays.replay(record)
    if where is None:
        echo(f"{record.path}: reproduced, hash {hash_}")
    else:
        echo(f"{record.path}: differs, hash {hash_} instead of {record.hash}")
        echo(f"  first at {where}")
    for text in [other_build] * bool(other_build) + (replays.cautions(record) if where else []):
        echo(f"  {text}")
    sys.exit(where is not None)


@click.command()
@click.argument("run", metavar="RUN|SCENARIO")
@click.option("--at", metavar="T|KIND", help="Seconds of motion, or panic, error...")
@click.option("--window", default=5.0, metavar="MS", help="How much is traced around it; 5 ms.")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.fst", help="The trace.")
@click.option("--view", is_flag=True, help="Open it in a viewer.")
def trace(run: str, at: str | None, window: float, out: Path | None, view: bool) -> None:
    """Waveforms of a part of a run, with a prepared view.

    RUN is a run.mmcs or its folder; a SCENARIO is run first. The run is made again, in this part
    clock by clock with all assertions live. Without --at the part begins at the first event, or
    where the motion begins.
    """
    from mmcs.folder import check_file
    from mmcs.runs import replay as replays
    from mmcs.view.waves import check_packages, open_viewer, write_views

    if out is not None and out.suffix != ".fst":
        raise InputError.one("--out", "", str(out), "must be a file name ending in .fst")
    check_packages()
    replays.check_window(window)
    record, good = _made(run, at)
    from_s, to_s = replays.stretch(record, at, window)
    path = check_file(out or replays.default_path(record, from_s, to_s))
    where, other_build = replays.trace(record, path, from_s, to_s)
    begin, end = from_s - record.motion_start_s, to_s - record.motion_start_s
    echo(f"{path}: {begin:.6f} to {end:.6f} s of motion ({from_s:.6f} s after power-on)")
    write_views(path)
    if where is None:
        echo(f"the run made again has the same hash, {record.hash}")
    else:
        echo(f"caution: this is not the same run; it differs first at {where}")
        for text in [other_build] * bool(other_build) + replays.cautions(record):
            echo(f"  {text}: `mmcs run` it again, if that is meant")
        good = False
    if view:
        open_viewer(path)
    sys.exit(0 if good else 1)


def _made(name: str, at: str | None):
    """The record of a run, or of a scenario's that is made now; and whether that was good."""
    from mmcs.place import results
    from mmcs.runs.record import read_record
    from mmcs.runs.runner import run_scenario
    from mmcs.scenario.files import named
    from mmcs.scenario.load import load

    is_scenario = name.endswith(".toml") or name in named() and not Path(name).exists()
    if not is_scenario:
        return read_record(name), True
    setup = load(name, ())
    with contextlib.suppress(TypeError, ValueError):  # the kind of an event, or nothing
        if float(at) > (most := setup.scenario.duration):
            raise InputError.one("--at", "", at, f"must be at most {most:g} s, the end of the run")
    folder = results("runs", setup.path) / setup.name
    echo(f"{name} is run first; what is in {folder} is replaced")
    good = run_scenario(setup, folder)
    return read_record(str(folder)), good
