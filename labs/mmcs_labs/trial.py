# SPDX-License-Identifier: Apache-2.0
"""Runs a sheet's scenarios with a student's values, and measures what came out."""

import shlex
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

import mmcs


class Gains(mmcs.Strict):
    """The compensator's integers, as `mmcs design --toml` prints them."""

    a0: int
    a1: int = 0
    a2: int = 0
    b0: int
    b1: int = 0
    b2: int = 0

    def sets(self, axis: int = 0) -> tuple[str, ...]:
        return tuple(f"axis.{axis}.{key}={value}" for key, value in self.model_dump().items())


@dataclass(frozen=True)
class Seen:
    """A finished run, and the command that makes it again."""

    command: str
    result: object

    @property
    def t(self) -> np.ndarray:
        return self.result.log[:, 0]

    @property
    def stats(self) -> dict:
        return self.result.stats

    def column(self, name: str, axis: int = 0, after: float = 0.0, until: float = 1e9):
        """A column of the log from `after` to `until`, seconds of motion."""
        return mmcs.column(self.result.log, axis, name)[(self.t >= after) & (self.t < until)]

    def true_speed(self, axis: int = 0) -> np.ndarray:
        """Of the joint, from the physics, rad/s."""
        return np.gradient(self.column("angle_rad", axis), self.t)

    @cached_property
    def axes(self) -> list[dict]:
        """The figures that `mmcs run` prints."""
        return mmcs.measure(self.result)

    def after(self, kind: str, text: str, moment: float) -> float | None:
        """Milliseconds from a moment of the motion to the first such event."""
        since = self.result.motion_start_s + moment
        for note in self.result.notes:
            if note["kind"] == kind and text in note["text"] and note["t"] >= since:
                return (note["t"] - since) * 1e3
        return None


Run = Callable[..., Seen]  # of a scenario's file and its overrides


@mmcs.once
def run(folder: Path, name: str, *sets: str) -> Seen:
    """Runs a scenario of a sheet with these overrides; the same run is made once."""
    words = [word for text in sets for word in ("--set", text)]
    command = shlex.join(["mmcs", "run", name, *words])
    try:
        setup = mmcs.load(folder / name, *sets)
    except mmcs.InputError as error:
        mistake = error.mistakes[0]
        raise mmcs.RunError(f"{mistake.key or name}: {mistake.allowed}") from None
    for text in mmcs.lacking_gains(setup):
        _caution(text)
    with mmcs.machine(setup, library=mmcs.library_of(setup)) as sim:
        return Seen(command, mmcs.Session(sim, setup).run())


@mmcs.once
def _caution(text: str) -> None:
    """To the teacher, once for a class."""
    mmcs.echo(f"caution: {text}", err=True)
