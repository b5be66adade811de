# SPDX-License-Identifier: Apache-2.0
"""From a scenario's name or path to a checked setup, or to every mistake in it."""

import tempfile
from dataclasses import replace
from pathlib import Path

from mmcs import ROBOTS, setup_file
from mmcs.errors import InputError, Mistake
from mmcs.scenario.files import find, read_scenario, read_toml
from mmcs.scenario.sets import apply_sets
from mmcs.scenario.setup import Setup, check_robot, make_setup

HOSTS = ("native", "m68020")  # as MMCS_HOST_... counts them


def load(name: str, sets: tuple[str, ...] = (), /, **overrides):
    """The checked setup. Raises InputError holding every mistake found."""
    path = find(name)
    if path.suffix == ".bin":
        return _load_file(path, sets, overrides)
    data, origins = read_scenario(path)
    if "axis" in data and "robot" not in data:
        raise InputError.one(path, "", None, "is a robot file, which `mmcs check` explains")
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


def _load_file(path: Path, sets: tuple[str, ...], overrides: dict):
    """The setup of a set-up file (`mmcs compile`); with other values it is compiled anew."""
    binary = path.read_bytes()
    try:
        found = setup_file.read(binary)
        source = setup_file.source(found)
    except ValueError as error:
        raise InputError.one(path, "", None, str(error)) from None
    given = {key: value for key, value in overrides.items() if value is not None}
    data = source["data"]
    typed = apply_sets(data, sets)
    try:
        setup = setup_of(path, data | given, source["files"])
    except InputError as error:
        raise InputError(*(_of(one, path, {}, typed) for one in error.mistakes)) from None
    setup.host = HOSTS[found["config"][0].host]
    if not sets and not given:
        setup.binary = binary
    return setup


def setup_of(path: Path, data: dict, files: dict[str, str]) -> Setup:
    """Of a scenario at `path`; files: texts of its robot and tables, by their names in a record."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text)
        made = Path(folder) / f"{path.stem}.toml"
        try:
            setup = make_setup(made, data)
        except InputError as error:  # this folder will be gone
            old, new = str(made), str(path)
            told = (replace(one, file=one.file.replace(old, new)) for one in error.mistakes)
            raise InputError(*told) from None
    setup.path = path
    return setup


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
    robot, mistakes = check_robot(read_toml(path), str(path))
    if mistakes:
        raise InputError(*mistakes)
    return path, robot
