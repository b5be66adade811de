# SPDX-License-Identifier: Apache-2.0
"""How far the joints of a robot move after each way to stop it, at moments of all its motions.

A motion is run once, with snapshots; each stop begins at one and ends when all joints are at rest.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmcs import ROBOTS
from mmcs.errors import InputError
from mmcs.scenario.files import find_robot, is_robot, named, read_scenario
from mmcs.scenario.load import load, load_robot
from mmcs.scenario.setup import Setup
from mmcs.sweeps.faults import Fault
from mmcs.sweeps.workers import or_failed

WAYS = {  # what happens at the moment: an entry of [[event]] or [[call]]
    "button": {"input": "estop", "value": 1},
    "cable pulled": {"input": "cable", "value": 0},
    "power lost": {"input": "pc_power", "value": 0},
    "MSTOP": {"request": "MSTOP"},
    "host dead": {"input": "host_dead", "value": 1},
    "host stalled, 80 ms": {"input": "host_stall", "value": 80},
    "interrupts lost": {"input": "irq_lost", "value": 1},
    "SYSRESET*, 0.1 ms": {"input": "sysreset", "value": 1, "for": 1e-4},
}
MOMENTS = 20  # of each motion
LONGEST_S = 2.0  # that a stop is watched


def motions(words: tuple[str, ...], sets: tuple[str, ...]) -> tuple[list[Setup], dict[str, str]]:
    """The setups of scenarios, or of all scenarios of a robot that stop nothing by themselves; and
    of those left out the reason. A robot that no scenario names moves as others with as many axes;
    a name of both is the robot's.

    Raises InputError where none is left.
    """
    if not words:
        raise InputError.one("--stops", "", None, "wants a robot, or scenarios")
    found: list[Setup] = []
    out: dict[str, str] = {}
    for word in words:
        robot = word in named(ROBOTS) or is_robot(word)
        for name, more in _of_robot(word) if robot else [(word, ())]:
            setup = load(name, (*sets, *more))
            keys = ("event", "process", "program")
            if has := next((key for key in keys if getattr(setup.scenario, key)), ""):
                out[setup.name] = f"it has a [[{has}]]"
            else:
                found.append(setup)
    if not found:
        told = "; ".join(f"{name}: {why}" for name, why in out.items()) or "no scenario moves it"
        raise InputError.one("--stops", "", " ".join(words), f"nothing to stop: {told}")
    return found, out


def _of_robot(word: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Names of the scenarios that move a robot, and their --set."""
    path, robot = load_robot(word)
    own, alike = [], []
    beside = [] if path.parent.name == "robots" else sorted(path.parent.glob("*.toml"))
    for name in (*named(), *map(str, beside)):
        file = named().get(name) or Path(name)
        data = {} if is_robot(str(file)) else read_scenario(file)[0]
        if not data.get("robot") or name.startswith("fault_"):
            continue
        other = find_robot(data["robot"], file)
        if other.resolve() == path.resolve():
            own.append((name, ()))
        elif len(load_robot(str(other))[1].axis) == len(robot.axis):
            alike.append((name, (f"robot={path.resolve()}",)))
    yield from own or alike


@or_failed
def run_motion(task: tuple[Setup, int]) -> dict:
    """{"moved"}: of each way and moment [way, at, degrees of each joint, whether all rest]."""
    from mmcs.sweeps.twin import Twin

    setup, count = task
    twin = Twin(setup)
    try:
        until = setup.scenario.duration
        moments = [round(until * n / count, 4) for n in range(count)]
        rows = [[way, at, *_moved(twin, way, at)] for way in WAYS for at in moments]
    finally:
        twin.close()
    return {"moved": rows}


def _moved(twin, way: str, at: float) -> tuple[list[float], bool]:
    entry = {"at": at, **WAYS[way]}
    if "for" in entry:
        entry["until"] = round(at + entry.pop("for"), 7)
    kind = "call" if "request" in entry else "event"
    fault = Fault(0, twin.setup.name, "kill", way, at, **{kind: entry})
    angles, rests = twin.stopped(fault, LONGEST_S)
    far = np.degrees(np.abs(angles - angles[0]).max(axis=0) / twin.scale)
    return [round(float(deg), 2) for deg in far], rests


def worst(found: dict[str, dict], setups: list[Setup]) -> tuple[list[str], list[list[str]]]:
    """A table: of each way and joint the most degrees and counts, and where that was."""
    robot = setups[0].robot
    axes = range(max(setup.axes for setup in setups))
    heads = ["stopped by", *(f"{robot.axis_name(n)}, °" for n in axes), "counts", "worst in"]
    lines = []
    for way in WAYS:
        rows = [(name, *row[1:]) for name, one in found.items() for row in one["moved"]
                if row[0] == way]  # fmt: skip
        cells, most = [], (-1.0, 0, "")
        for n in axes:
            name, at, far, rests = max((r for r in rows if n < len(r[2])), key=lambda r: r[2][n])
            cells.append(f"{'' if rests else '≥ '}{far[n]:.1f}")
            most = max(most, (far[n], n, f"{name} at {at:g} s"))
        counts = np.radians(most[0]) * abs(robot.counts_per_rad(most[1]))
        lines.append([way, *cells, f"{counts:.0f}", most[2]])
    return heads, lines


def markdown(heads: list[str], lines: list[list[str]]) -> str:
    rows = [heads, ["---"] * len(heads), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n"
