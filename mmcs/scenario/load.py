# SPDX-License-Identifier: Apache-2.0
"""From a scenario's name or path to a checked setup, or to every mistake in it."""

from dataclasses import replace
from pathlib import Path

from mmcs import ROBOTS
from mmcs.errors import InputError, Mistake
from mmcs.scenario.files import find, read_scenario, read_toml
from mmcs.scenario.robot import Robot
from mmcs.scenario.schema import validate
from mmcs.scenario.sets import apply_sets
from mmcs.scenario.setup import make_setup


def load(name: str, sets: tuple[str, ...] = (), /, **overrides):
    """The checked setup. Raises InputError holding every mistake found."""
    path = find(name)
    data, origins = read_scenario(path)
    typed = apply_sets(data, sets)
    given = {key: value for key, value in overrides.items() if value is not None}
    data.update(given)
    for key in (*given, *(item.partition("=")[0] for item in sets)):
        origins.pop(key.partition(".")[0].strip(), None)
    try:
        return make_setup(path, data)
    except InputError as error:
        told = (_of(mistake, path, origins, typed) for mistake in error.mistakes)
        raise InputError(*told) from None


def _of(mistake: Mistake, path: Path, origins: dict[str, Path], typed: dict[str, str]) -> Mistake:
    """The mistake, in the file that it was inherited from, or by the name that --set gave."""
    entry, dot, key = mistake.key.rpartition(".")
    if entry in typed:
        return replace(mistake, file="--set", key=f"{typed[entry]}{dot}{key}")
    origin = origins.get(mistake.key.partition(".")[0])
    if mistake.file != str(path) or origin is None:
        return mistake
    return replace(mistake, file=str(origin))


def load_robot(name: str):
    """(path, robot). Raises InputError holding every mistake found."""
    path = find(name, ROBOTS, "robot")
    robot, mistakes = validate(Robot, read_toml(path), str(path))
    mistakes += robot.mistakes(str(path)) if robot else []
    if mistakes:
        raise InputError(*mistakes)
    return path, robot
