# SPDX-License-Identifier: Apache-2.0
"""Finds and reads the files: which one a name means, and TOML with its mistakes told."""

from __future__ import annotations

import functools
import itertools
import json
import os
import re
import stat
import tomllib
from collections.abc import Iterator
from pathlib import Path

from mmcs import ROBOTS, SCENARIOS
from mmcs.errors import InputError, suggest

MAX_TOML = 1 << 20  # bytes of a file; the longest of ours has twenty thousand
MAX_TABLE = 8 << 20
MAX_LINE = 16 << 10  # of a log; one of 32 axes has three thousand
MAX_JSON = 96 << 20
MAX_FILES = 16 << 20  # of a scenario, together
MOST_VALUES = 2_000_000  # of a JSON text
LONG_KEY = re.compile(
    r"""(?<![\w"'.-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){100}"""
)
DEEPEST = 10  # levels of tables and lists in a file; a good one has four


def named(folder: Path = SCENARIOS) -> dict[str, Path]:
    """The files of a folder and of those in it, by name."""
    return {path.stem: path for path in sorted(folder.rglob("*.toml"), key=lambda p: p.stem)}


def scenario_names() -> list[str]:
    return list(named())


def find(name: str, folder: Path = SCENARIOS, what: str = "scenario") -> Path:
    """The file that a name from the folder, or a path, means."""
    if name.endswith(".toml") or "/" in name:
        path = Path(name)
        if _is_file(path):
            return path
        known = named(folder).get(path.stem)
        hint = f"; there is {short(known)}" if known else ""
        raise InputError.one(name, "", None, f"no such {what} file{hint}")
    known = named(folder)
    if name in known:
        return short(known[name])
    hint = suggest(name, known) or "; there are: " + ", ".join(known)
    raise InputError.one(f'"{name}"', "", None, f"no such {what}{hint}")


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long
        return False


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


class Files:
    """The files that scenarios name, each read once: a run is of the files as they were then."""

    def __init__(self, parsed: dict[Path, dict] | None = None):
        self._texts: dict[Path, str] = {}
        self._tables = dict(parsed or {})

    def text(self, path: Path, most: int = MAX_TOML) -> str:
        """Raises ValueError with one sentence."""
        if path not in self._texts:
            self._texts[path] = read_text(path, most)
        return self._texts[path]

    def toml(self, path: Path) -> dict:
        """Raises InputError."""
        if path not in self._tables:
            self._tables[path] = read_toml(path, self)
        return self._tables[path]


def read_toml(path: Path, files: Files | None = None) -> dict:
    try:
        text = (files or Files()).text(path)
    except ValueError as error:
        raise InputError.one(path, "", None, str(error)) from None
    if text.startswith("\ufeff"):
        raise InputError.one(path, "", None, "begins with a byte-order mark: save it without")
    try:
        data = parse_toml(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError.one(path, *_where(str(error), text)) from None
    except ValueError as error:
        raise InputError.one(path, "", None, str(error)) from None
    return data


def parse_toml(text: str) -> dict:
    """As tomllib, which leaves open what no scenario needs: ValueError with a sentence for it."""
    if LONG_KEY.search(text):  # for which tomllib takes a time that grows with its square
        raise ValueError(f"nests deeper than {DEEPEST} levels")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError(f"nests deeper than {DEEPEST} levels") from None
    except ValueError:  # Python's own limit
        raise ValueError("holds a whole number of thousands of digits") from None
    level = [data]
    for _ in range(DEEPEST):
        inner = [v for d in level for v in (d.values() if isinstance(d, dict) else d)]
        level = [v for v in inner if isinstance(v, dict | list)]
    if level:
        raise ValueError(f"nests deeper than {DEEPEST} levels")
    return data


def _where(message: str, text: str) -> tuple[str, None, str]:
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", message)
    if found:
        what, line, column = found.groups()
    else:  # "(at end of document)"
        lines = text.splitlines() or [""]
        what, line, column = message.partition(" (at")[0], len(lines), len(lines[-1]) + 1
    return f"line {line}, column {column}", None, f"not valid TOML: {what}"


def read_scenario(path: Path, below: tuple[Path, ...] = ()) -> tuple[dict, dict[str, Path]]:
    """The scenario with what it extends, and which keys came from which other file.

    A key of the file replaces the same key of the one it extends; only tables, like [host], are
    merged key by key. below: the files that extend this one.
    """
    data = read_toml(path)
    if "extends" not in data:
        return data, {}
    name = data.pop("extends")
    if not isinstance(name, str) or not name:
        allowed = "must be the name of a scenario, or the path of one from this file's folder"
        raise InputError.one(path, "extends", name, allowed)
    try:
        is_path = name.endswith(".toml") or "/" in name
        base = find(str(path.parent / name) if is_path else name)
    except InputError as error:
        raise InputError.one(path, "extends", name, error.mistakes[0].allowed) from None
    files = (*below, path.resolve())
    if base.resolve() in files:
        raise InputError.one(path, "extends", name, "extends itself, at last: name another one")
    out, origins = read_scenario(base, files)
    _move(out, base.resolve().parent)
    origins = dict.fromkeys(out, base) | origins
    for key, value in data.items():
        if isinstance(value, dict) and isinstance(out.get(key), dict):
            out[key] = out[key] | value
        else:
            out[key] = value
        origins.pop(key, None)
    return out, origins


def _move(data: dict, folder: Path) -> None:
    """Paths within data, which count from this folder, in full."""
    motions = data.get("motion", [])
    tables = [m for m in motions if isinstance(m, dict)] if isinstance(motions, list) else []
    for table, key in [(data, "robot"), *((motion, "file") for motion in tables)]:
        name = table.get(key)
        if isinstance(name, str) and (key == "file" or name.endswith(".toml") or "/" in name):
            table[key] = str(folder / name)


def description(path: Path) -> str:
    """The one-line description, or why there is none; needs no schema and so is quick."""
    try:
        return str(read_scenario(path)[0].get("description", ""))
    except InputError as error:
        return f"(broken: {error})"


def find_robot(name: str, scenario: Path) -> Path:
    if name.endswith(".toml") or "/" in name:
        return find(str(scenario.parent / name), ROBOTS, "robot")
    return find(name, ROBOTS, "robot")


def is_robot(name: str) -> bool:
    """A robot file's path, or the name of a robot that is not also a scenario's."""
    if name.endswith(".toml") or "/" in name:
        path = Path(name)
        if not _is_file(path):
            return False
        try:
            data = read_toml(path)
        except InputError:
            return path.resolve().parent == ROBOTS
        return "axis" in data and "robot" not in data
    return name not in named() and name in named(ROBOTS)
