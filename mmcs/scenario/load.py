# SPDX-License-Identifier: Apache-2.0
"""From a scenario's name or path to a checked setup, or to every mistake in it."""

from __future__ import annotations

from mmcs import ROBOTS
from mmcs.errors import InputError
from mmcs.scenario.files import find, read_toml
from mmcs.scenario.robot import Robot
from mmcs.scenario.schema import validate
from mmcs.scenario.sets import apply_sets
from mmcs.scenario.setup import make_setup


def load(name: str, sets: tuple[str, ...] = (), **overrides):
    """The checked setup. Raises InputError holding every mistake found."""
    path = find(name)
    data = read_toml(path)
    apply_sets(data, sets)
    data.update({key: value for key, value in overrides.items() if value is not None})
    return make_setup(path, data)


def load_robot(name: str):
    """(path, robot). Raises InputError holding every mistake found."""
    path = find(name, ROBOTS, "robot")
    robot, mistakes = validate(Robot, read_toml(path), str(path))
    mistakes += robot.mistakes(str(path)) if robot else []
    if mistakes:
        raise InputError(*mistakes)
    return path, robot
