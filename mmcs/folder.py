# SPDX-License-Identifier: Apache-2.0
"""The folder of a run's results: whole or not at all, whatever ends the run and whenever.

New results are made in a folder of their own inside it; until the last of them is there the earlier
results stand. The report leaves first and comes last: a folder without it is no run.
"""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mmcs.errors import InputError

RESULTS = ("report.json", "log.csv", "bus.csv", "plot.svg", "run.mmcs")
STAGE, LOCK = ".new", ".lock"


def check_folder(folder: Path) -> None:
    """A folder of results is made, or refused, before the work and not after it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.one(folder, "", None, f"cannot be made: {error.strerror}") from None
    _check_writable(folder)


def check_file(path: Path) -> Path:
    """So is a file of results, in a folder that is there."""
    if path.is_dir():
        raise InputError.one(path, "", None, "is a folder, and the name of a result")
    if "\0" in str(path) or path.exists() and not path.is_file():
        raise InputError.one(path, "", None, "cannot be the name of a result: give that of a file")
    if not path.parent.is_dir():
        raise InputError.one(path, "", None, "its folder does not exist")
    _check_writable(path.parent)
    return path


def _check_writable(folder: Path) -> None:
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise InputError.one(folder, "", None, f"cannot be written: {error.strerror}") from None


@contextmanager
def writing(folder: Path) -> Iterator[Path]:
    """Where this run may put its results. InputError when another run is at work here."""
    with lock(folder, "run"):
        stage = folder / STAGE
        shutil.rmtree(stage, ignore_errors=True)
        try:  # a signal may come with the folder just made
            stage.mkdir()
            yield stage
            for path in stage.iterdir():
                _sync(path)
            for name in RESULTS:
                (folder / name).unlink(missing_ok=True)
            for name in reversed(RESULTS):
                if (stage / name).exists():
                    os.replace(stage / name, folder / name)
        finally:
            shutil.rmtree(stage, ignore_errors=True)


def lock(folder: Path, what: str):
    """Held as long as it is open. InputError when another one is at work in the folder."""
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    held = open(os.open(folder / LOCK, flags, 0o666), "r+b", buffering=0)  # noqa: SIM115
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        held.close()
        allowed = f"another {what} is writing here; wait for its end, or give another --out"
        raise InputError.one(folder, "", None, allowed) from None
    return held


def _sync(path: Path) -> None:
    """A file's content is on the disk before its name is: a power cut leaves no empty results."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A name to write to; what is written becomes the file at once, when it is whole."""
    part = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield part
        _sync(part)
        os.replace(part, path)
    except OSError as error:
        error.filename = error.filename or str(path)  # a full disk names none
        raise
    finally:
        part.unlink(missing_ok=True)
