# SPDX-License-Identifier: Apache-2.0
"""Reads files of the user's, which may be anything: bounded, and what is wrong in one sentence."""

import functools
import itertools
import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path

MAX_TOML = 1 << 20  # bytes of a file; the longest of ours has twenty thousand
MAX_TABLE = 8 << 20
MAX_LINE = 16 << 10  # of a log; one of 32 axes has three thousand
MAX_JSON = 96 << 20
MOST_VALUES = 2_000_000  # of a JSON text
LONGEST_S = 3600.0  # that a scenario may last


def short(path: Path) -> Path:
    """The path as one would type it from here."""
    try:
        return path.resolve().relative_to(Path.cwd())
    except ValueError:
        return path


def open_file(path: Path):
    """A file of the user's, to read its bytes. ValueError with one sentence for what is none: who
    waits for the other end of a pipe waits for ever."""
    file = open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb")  # noqa: SIM115
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise ValueError("cannot be read: it is a pipe, a device or a folder")
    return file


def log_lines(file, most: int) -> Iterator[list[bytes]]:
    """The lines of an open log.csv, so many at once. ValueError with one sentence for a line that
    does not end."""
    lines = iter(functools.partial(file.readline, MAX_LINE), b"")
    while group := list(itertools.islice(lines, most)):
        if len(max(group, key=len)) == MAX_LINE:
            raise ValueError(f"its log.csv has a line of more than {MAX_LINE >> 10} KB")
        yield group


def read_bytes(path: Path, most: int) -> bytes:
    """The same whole, if it is not endless."""
    if "\0" in str(path):
        raise ValueError("cannot be read: no file has such a name")
    try:
        with open_file(path) as file:
            data = file.read(most + 1)
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}") from None
    if len(data) > most:
        raise ValueError(f"is larger than {most >> 20} MB")
    return data


def read_text(path: Path, most: int = MAX_TOML) -> str:
    try:
        return read_bytes(path, most).decode("utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"is not UTF-8 text (byte {error.start})") from None


def loads(text: str | bytes) -> object:
    """JSON; ValueError with a sentence for anything else."""
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
    if sum(map(text.count, "[{,")) > MOST_VALUES:  # each would take fifty times its text
        raise ValueError(f"it holds more than {MOST_VALUES} values")
    try:
        return json.loads(text)
    except (RecursionError, ValueError):
        raise ValueError("it is no JSON") from None


def read_json(path: Path) -> object:
    """ValueError with a sentence for what is no JSON, or far too much of it."""
    return loads(read_text(path, MAX_JSON))


def is_name(text: str) -> bool:
    """Whether results may be called so: a name and no way to another folder."""
    return text not in ("", ".", "..") and "/" not in text and "\0" not in text
