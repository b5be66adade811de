# SPDX-License-Identifier: Apache-2.0
"""`--set key.path=value`: puts values where a key says, before anything is checked."""

from __future__ import annotations

import tomllib

from mmcs.errors import InputError, show, suggest
from mmcs.scenario.files import DEEPEST, parse_toml
from mmcs.scenario.scenario import Servo


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
