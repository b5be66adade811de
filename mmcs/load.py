# SPDX-License-Identifier: Apache-2.0
"""From a scenario's name or path to a checked setup, or to every mistake in it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from mmcs import ROBOTS, SCENARIOS
from mmcs.errors import InputError, show, suggest

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


def apply_sets(data: dict, sets: tuple[str, ...]) -> None:
    """Applies `--set key.path=value`; a value is TOML, or a bare word taken as a string."""
    for item in sets:
        key, text = split_set(item)
        set_key(data, key, parse_value(text, key))


def split_set(item: str, option: str = "--set", example: str = "servo.0.ilim=500"):
    """(key, text of the value)."""
    key, equals, text = item.partition("=")
    if not equals or not all(part.strip() for part in key.split(".")):
        raise InputError.one(option, item, None, f"must be key=value, like {example}")
    return key.strip(), text


def parse_value(text: str, key: str, option: str = "--set") -> object:
    try:
        return parse_toml(f"v = {text}")["v"]
    except tomllib.TOMLDecodeError:
        return text
    except ValueError as error:
        raise InputError.one(option, key, None, str(error)) from None


def set_key(data: dict, key: str, value: object, option: str = "--set") -> None:
    """Puts a value where the key says; `axis.N.KEY` and `axis.all.KEY` are servo parameters."""
    parts = [part.strip() for part in key.split(".")]
    if len(parts) > DEEPEST:
        raise InputError.one(option, "", key, f"names more than {DEEPEST} levels")
    item = f"{key}={show(value)}"
    if parts[0] == "axis" and "axis" not in data:
        _set_servo(data, parts, value, option)
        return
    *heads, last = parts
    for part in heads:
        if isinstance(data, list):
            data = data[_index(data, part, item, option)]
        else:
            data = data.setdefault(part, {})
        if not isinstance(data, dict | list):
            raise InputError.one(option, item, None, f'"{part}" is a value and has no keys')
    if isinstance(data, list):
        data[_index(data, last, item, option)] = value
    else:
        data[last] = value


def _set_servo(data: dict, parts: list[str], value: object, option: str) -> None:
    """A servo entry of its own, after those of the file: the last one counts."""
    from mmcs.scenario import Servo

    key = ".".join(parts)
    names = [name for name in Servo.model_fields if name != "axis"]
    if len(parts) != 3 or not (parts[1] == "all" or parts[1].isascii() and parts[1].isdigit()):
        raise InputError.one(
            option, key, None, "must be axis.N.KEY or axis.all.KEY, like axis.0.b0"
        )
    if parts[2] not in names:
        hint = suggest(parts[2], names) or "; there are: " + ", ".join(names)
        raise InputError.one(option, key, None, f"no such servo parameter{hint}")
    servo = data.setdefault("servo", [])
    if not isinstance(servo, list):
        raise InputError.one(option, key, None, '"servo" is a value and has no keys')
    axis = "all" if parts[1] == "all" else int(parts[1][:9])
    servo.append({"axis": axis, parts[2]: value})


def _index(data: list, part: str, item: str, option: str) -> int:
    if part.isascii() and part.isdigit() and len(part) < 9 and int(part) < len(data):
        return int(part)
    allowed = f"0 to {len(data) - 1}" if data else "nothing, the list is empty"
    raise InputError.one(option, item, None, f'"{part}" must be an entry number: {allowed}')


def load(name: str, sets: tuple[str, ...] = (), **overrides):
    """The checked setup. Raises InputError holding every mistake found."""
    from mmcs.setup import make_setup

    path = find(name)
    data = read_toml(path)
    apply_sets(data, sets)
    data.update({key: value for key, value in overrides.items() if value is not None})
    return make_setup(path, data)


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


def load_robot(name: str):
    """(path, robot). Raises InputError holding every mistake found."""
    from mmcs.robot import Robot
    from mmcs.schema import validate

    path = find(name, ROBOTS, "robot")
    robot, mistakes = validate(Robot, read_toml(path), str(path))
    mistakes += robot.mistakes(str(path)) if robot else []
    if mistakes:
        raise InputError(*mistakes)
    return path, robot
