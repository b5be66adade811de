# SPDX-License-Identifier: Apache-2.0
"""The folder of a run's results: whole or not at all, whatever ends the run and whenever.

New results are made in a folder of their own inside it. When the last of them is there, one file
says so, and from that instant on they are the results: the run moves them to their places, or, if
it was killed meanwhile, whoever looks next. Before that instant the earlier results stand.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mmcs.errors import InputError

RESULTS = ("report.json", "log.csv", "plot.svg", "run.mmcs", "run.mmsnap")
STAGE, WHOLE, LOCK = ".new", "whole.json", ".lock"


@contextmanager
def writing(folder: Path) -> Iterator[Path]:
    """Where this run may put its results. InputError when another run is at work here."""
    with (folder / LOCK).open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            allowed = "another run is writing here; wait for its end, or give another --out"
            raise InputError.one(folder, "", None, allowed) from None
        settle(folder)
        stage = folder / STAGE
        shutil.rmtree(stage, ignore_errors=True)
        stage.mkdir()
        try:
            yield stage
            names = sorted(path.name for path in stage.iterdir())
            with whole_file(stage / WHOLE) as path:
                path.write_text(json.dumps(names))
        except BaseException:
            shutil.rmtree(stage, ignore_errors=True)
            raise
        settle(folder)


def settle(folder: Path) -> None:
    """Results that are whole and not yet in their places get there."""
    if not (folder / STAGE / WHOLE).exists():
        return
    with _locked(folder, fcntl.LOCK_EX):
        stage = folder / STAGE
        try:
            names = json.loads((stage / WHOLE).read_text())
        except FileNotFoundError:  # somebody else has done it
            return
        for name in set(RESULTS) - set(names):  # of an earlier run
            (folder / name).unlink(missing_ok=True)
        for name in names:
            with suppress(FileNotFoundError):  # moved before a kill
                os.replace(stage / name, folder / name)
        (stage / WHOLE).unlink()
        shutil.rmtree(stage, ignore_errors=True)


@contextmanager
def reading(folder: Path) -> Iterator[None]:
    """All that is read meanwhile is of one run."""
    settle(folder)
    with _locked(folder, fcntl.LOCK_SH):
        yield


@contextmanager
def _locked(folder: Path, how: int) -> Iterator[None]:
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(handle, how)
        yield
    finally:
        os.close(handle)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A name to write to; what is written becomes the file at once, when it is whole."""
    part = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
