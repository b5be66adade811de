# SPDX-License-Identifier: Apache-2.0
"""Finds and reads the files: which one a name means, and TOML with its mistakes told."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from mmcs import ROBOTS, SCENARIOS
from mmcs.errors import InputError, suggest

DEEPEST = 10  # levels of tables and lists in a file; a good one has four


def scenario_names() -> list[str]:
    return sorted(path.stem for path in SCENARIOS.glob("*.toml"))


def find(name: str, folder: Path = SCENARIOS, what: str = "scenario") -> Path:
    """The file that a name from the folder, or a path, means."""
    if name.endswith(".toml") or "/" in name:
        path = Path(name)
        if _is_file(path):
            return path
        raise InputError.one(name, "", None, f"no such {what} file")
    path = folder / f"{name}.toml"
    if _is_file(path):
        return short(path)
    known = sorted(p.stem for p in folder.glob("*.toml"))
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


def read_toml(path: Path) -> dict:
    try:
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        raise InputError.one(path, "", None, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError.one(path, "", None, f"is not UTF-8 text (byte {error.start})") from None
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


def description(path: Path) -> str:
    """The one-line description, or why there is none; needs no schema and so is quick."""
    try:
        return str(read_toml(path).get("description", ""))
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
    return not _is_file(SCENARIOS / f"{name}.toml") and _is_file(ROBOTS / f"{name}.toml")
