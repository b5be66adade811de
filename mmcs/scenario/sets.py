# SPDX-License-Identifier: Apache-2.0
"""`--set key.path=value`: puts values where a key says, before anything is checked."""

import tomllib

from mmcs.errors import InputError, show, suggest
from mmcs.scenario.files import DEEPEST, parse_toml
from mmcs.scenario.robot import MotorValues
from mmcs.scenario.scenario import Servo

# Of a table that a key without its entry number reaches: model, what its keys begin with, a key.
TABLES = {
    "servo": (Servo, "", "servo parameter", "b0"),
    "motor": (MotorValues, "robot.", "value of a robot's axis", "inertia"),
}


def apply_sets(data: dict, sets: tuple[str, ...]) -> dict[str, str]:
    """Applies `--set key.path=value`; a value is TOML, or a bare word taken as a string.

    Returns what was typed for the entries that it made: {"servo.4": "axis.0"}.
    """
    typed = {}
    for item in sets:
        key, text = split_set(item)
        set_key(data, key, parse_value(text, key))
        for table, (_, prefix, *_) in TABLES.items():
            parts = [part.strip() for part in key.split(".")]
            if parts[: len(prefix.split("."))] == [*prefix.split(".")[:-1], "axis"]:
                typed[f"{table}.{len(data[table]) - 1}"] = ".".join(parts[:-1])
    return typed


def split_set(item: str, option: str = "--set", example: str = "servo.0.ilim=500"):
    """(key, text of the value)."""
    key, equals, text = item.partition("=") if isinstance(item, str) else (str(item), "", "")
    if not equals or not all(part.strip() for part in key.split(".")):
        raise InputError.one(option, str(item), None, f"must be key=value, like {example}")
    return key.strip(), text


def parse_value(text: str, key: str, option: str = "--set") -> object:
    try:
        return parse_toml(f"v = {text}")["v"]
    except tomllib.TOMLDecodeError:
        return text
    except ValueError as error:
        raise InputError.one(option, key, None, str(error)) from None


def set_key(data: dict, key: str, value: object, option: str = "--set") -> None:
    """Puts a value where the key says.

    `axis.N.KEY` is a servo parameter, `robot.axis.N.KEY` a value of the robot file; N may be `all`.
    """
    parts = [part.strip() for part in key.split(".")]
    if len(parts) > DEEPEST:
        raise InputError.one(option, "", key, f"names more than {DEEPEST} levels")
    item = f"{key}={show(value)}"
    if parts[0] == "axis" and "axis" not in data:
        _add_entry(data, "servo", parts, value, option)
        return
    if parts[:2] == ["robot", "axis"]:
        _add_entry(data, "motor", parts[1:], value, option)
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


def _add_entry(data: dict, table: str, parts: list[str], value: object, option: str) -> None:
    """A new entry in [[servo]] or [[motor]], after those of the file: the last one counts."""
    model, prefix, what, example = TABLES[table]
    key = prefix + ".".join(parts)
    names = [name for name in model.model_fields if name != "axis"]
    if len(parts) != 3 or not (parts[1] == "all" or parts[1].isascii() and parts[1].isdigit()):
        allowed = (
            f"must be {prefix}axis.N.KEY or {prefix}axis.all.KEY, like {prefix}axis.0.{example}"
        )
        raise InputError.one(option, key, None, allowed)
    if parts[2] not in names:
        hint = suggest(parts[2], names) or "; there are: " + ", ".join(names)
        if table == "servo" and parts[2] in MotorValues.model_fields:
            hint = f'; did you mean "robot.{key}"?'
        raise InputError.one(option, key, None, f"no such {what}{hint}")
    entries = data.setdefault(table, [])
    if not isinstance(entries, list):
        raise InputError.one(option, key, None, f'"{table}" is a value and has no keys')
    axis = "all" if parts[1] == "all" else int(parts[1][:9])
    entries.append({"axis": axis, parts[2]: value})


def _index(data: list, part: str, item: str, option: str) -> int:
    if part.isascii() and part.isdigit() and len(part) < 9 and int(part) < len(data):
        return int(part)
    allowed = f"0 to {len(data) - 1}" if data else "nothing, the list is empty"
    raise InputError.one(option, item, None, f'"{part}" must be an entry number: {allowed}')
