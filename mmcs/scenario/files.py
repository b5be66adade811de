# SPDX-License-Identifier: Apache-2.0
"""Finds and reads the files: which one a name means, and TOML with its mistakes told."""

import os
import re
import tomllib
from pathlib import Path

from mmcs import ROBOTS, SCENARIOS
from mmcs.errors import InputError, suggest
from mmcs.files import MAX_TOML, read_text, short

MAX_FILES = 16 << 20  # of a scenario, together
FAULTS = SCENARIOS / "faults" / "faults.toml"
ENTRY = re.compile(r"^\[(\w+)\]$", re.M)
# Seconds from the start of motion to a fault of the table, by the scenario that its entry extends.
FAULT_S = {"arm_move": 0.1, "arm_calibrate": 0.0}
DEEPEST = 10  # levels of tables and lists in a file; a good one has four


def named(folder: Path = SCENARIOS) -> dict[str, Path]:
    """The files of a folder and of those in it, by name. An entry of the fault table has a path of
    its own, FAULTS/NAME, and is read like a file."""
    found = {path.stem: path for path in folder.rglob("*.toml") if path != FAULTS}
    if folder == SCENARIOS:
        found |= {name: FAULTS / name for name in ENTRY.findall(FAULTS.read_text())}
    return dict(sorted(found.items()))


def scenario_names() -> list[str]:
    return list(named())


def find(name: str, folder: Path = SCENARIOS, what: str = "scenario") -> Path:
    """The file that a name from the folder, or a path, means."""
    if name.endswith((".toml", ".bin")) or "/" in name:
        path = Path(name)
        if _is_file(path):
            return path
        known = named(folder).get(path.stem)
        hint = f"; there is {short(known)}" if known else ""
        no = "is a folder, and no" if os.path.isdir(name) else "no such"
        raise InputError.one(name, "", None, f"{no} {what} file{hint}")
    known = named(folder)
    if name in known:
        return short(known[name])
    names = "; see `mmcs list`" if what == "scenario" else "; there are: " + ", ".join(known)
    hint = suggest(name, known) or names
    raise InputError.one(f'"{name}"', "", None, f"no such {what}{hint}")


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long
        return False


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
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError(f"nests deeper than {DEEPEST} levels") from None
    except ValueError:  # Python's own limit
        raise ValueError("holds an integer with thousands of digits") from None
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
    data = read_toml(path) if path.resolve().parent != FAULTS else fault_scenario(path.stem)
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
    if len(files) > DEEPEST:
        raise InputError.one(path, "extends", name, f"is the {DEEPEST}th in a row: name fewer")
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


def fault_scenario(name: str) -> dict:
    """An entry of the fault table (its head says what one holds) as a file that extends another."""
    entry = {"extends": "arm_move"} | read_toml(FAULTS)[name]
    if (at := FAULT_S.get(entry["extends"])) is None:
        allowed = "must be one of " + ", ".join(FAULT_S)
        raise InputError.one(FAULTS, f"{name}.extends", entry["extends"], allowed)
    noticed, moved, stats = (entry.pop(key, None) for key in ("noticed", "moved", "stats"))
    expect = [{"kind": "event", "after": at} | event for event in noticed or []]
    if noticed == []:
        expect = [{"kind": "event", "event": ["error", "panic"], "seen": False}]
    expect += [{"kind": "stats"} | stats] if stats else []
    expect += [{"kind": "physics", "after": at} | joints for joints in moved or []]
    entry["expect"] = expect + entry.get("expect", [])
    entry["event"] = [{"at": at} | event for event in entry.get("event", [])]
    return {key: value for key, value in entry.items() if key not in ("name", "why")}


def _move(data: dict, folder: Path) -> None:
    """Paths within data, which count from this folder, in full."""
    robot = data.get("robot")
    if isinstance(robot, str) and (robot.endswith(".toml") or "/" in robot):
        data["robot"] = str(folder / robot)
    for table in tables_with_files(data).values():
        if isinstance(table["file"], str):
            table["file"] = str(folder / table["file"])


def tables_with_files(data: dict) -> dict[str, dict]:
    """The tables of a scenario, also of an unchecked one, that name a file; by the plain name that
    the file has in a record."""
    found = {}
    for key, name in (("motion", "table{}.csv"), ("card", "card{}.sv")):
        tables = data[key] if isinstance(data.get(key), list) else []
        found |= {name.format(n): table for n, table in enumerate(tables)
                  if isinstance(table, dict) and "file" in table}  # fmt: skip
    return found


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
    return name in named(ROBOTS) and name not in named()
