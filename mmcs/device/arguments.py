# SPDX-License-Identifier: Apache-2.0
"""What a message asks, checked before anything is done (docs/use/protocol.md)."""

from __future__ import annotations

import tomllib

from mmcs import ROOT, mcdef
from mmcs.device.wire import EINVAL

REQUESTS = tomllib.loads((ROOT / "sim" / "service" / "messages.toml").read_text())


class Refused(Exception):
    """A request cannot be done: the driver's errno, and a sentence."""

    def __init__(self, number: int, text: str = ""):
        super().__init__(text)
        self.number, self.text = number, text


class Arguments:
    """What a request says, as messages.toml has it; anything else is Refused by name."""

    def __init__(self, said: dict, axes: int):
        self._said = said
        self.id, self.op = said.get("id"), self.text("op")
        self._known = REQUESTS.get(self.op, {})
        self._sizes = {"axes": axes, "last axis": axes - 1}

    def __getitem__(self, name: str):
        kind, *bounds = self._known[name]
        return getattr(self, kind)(name, *(self._sizes.get(bound, bound) for bound in bounds))

    def __contains__(self, name: str) -> bool:
        return name in self._said

    def is_null(self, name: str) -> bool:
        return self._said.get(name) is None

    def integer(self, name: str, low: int, high: int, default: int | None = None) -> int:
        value = self._said.get(name, default)
        if type(value) is not int or not low <= value <= high:
            raise Refused(EINVAL, f"{name}: a whole number from {low} to {high}")
        return value

    def number(self, name: str, low: float, high: float, default: float | None = None) -> float:
        value = self._said.get(name, default)
        if type(value) not in (int, float) or not low <= value <= high:
            raise Refused(EINVAL, f"{name}: a number from {low:g} to {high:g}")
        return float(value)

    def flag(self, name: str, default: bool | None = None) -> bool:
        value = self._said.get(name, default)
        if type(value) is not bool:
            raise Refused(EINVAL, f"{name}: true or false")
        return value

    def text(self, name: str, *choices: str) -> str:
        value = self._said.get(name)
        if type(value) is not str or (choices and value not in choices):
            raise Refused(EINVAL, f"{name}: " + (" or ".join(choices) or "a text"))
        return value

    def integers(self, name: str, most: int) -> list[int]:
        values = self._said.get(name)
        if type(values) is not list or len(values) > most or not all(map(_fits, values)):
            raise Refused(EINVAL, f"{name}: at most {most} whole numbers of 32 bits")
        return values

    def param(self, key: str) -> dict[str, int]:
        values = self._said.get(key)
        known = [n for n, _ in mcdef.make_ffi().typeof("struct mc_param").fields]
        if type(values) is not dict or not values:
            raise Refused(EINVAL, f"{key}: an object with fields of struct mc_param")
        for name, value in values.items():
            if name not in known or not _fits(value):
                raise Refused(EINVAL, f"{key}: {name} is no field, or not a number of 32 bits")
        return {name: value for name, value in values.items() if name != "which"}


def _fits(value) -> bool:
    return type(value) is int and -(1 << 31) <= value < 1 << 31
