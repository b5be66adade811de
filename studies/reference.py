# SPDX-License-Identifier: Apache-2.0
"""Reference step responses of PD position loops, and the same steps on the simulated machine.

`python -m studies.reference` measures them all and writes docs/evidence/closed_loop.md. The figures
of ROWS come from a plant and servo model of one axis that shares nothing with this project's code,
with the gains of reference_gains.toml and a current limit of 1024; those of the robot's own gains
come from one_axis.py.
"""

import argparse
import functools
import math
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mmcs import ROOT, load, make_report, simulate, step_response
from studies.one_axis import move
from tools.pages import fill

DOCUMENT = ROOT / "docs" / "evidence" / "closed_loop.md"
COMPENSATION = ("off", "0.8", "1.0")
GAINS = tomllib.loads(Path(__file__).with_name("reference_gains.toml").read_text())
ILIM = 1024
BAND_MS = 2.0
SHIPPED = (200, 1000)  # steps of the robot's own gains


class Row(NamedTuple):
    """A step of one axis; per compensation: rise ms (None: never reaches 90 %), overshoot %,
    steady error in counts."""

    robot: str
    axis: int
    interval_us: int
    size: int
    off: tuple | None
    most: tuple
    full: tuple

    def reference(self, compensation: str) -> tuple | None:
        return dict(zip(COMPENSATION, (self.off, self.most, self.full), strict=True))[compensation]


NEVER = None
ROWS = [
    Row("lab500", 0, 1000, 200, (NEVER, 0, 25), (46, 0, 5), (42, 0, 1)),
    Row("lab500", 0, 1000, 1000, (49, 0, 25), (46, 0, 5), (45, 0, 1)),
    Row("lab500", 0, 2000, 1000, (92, 0, 62), (70, 0, 13), (66, 0, 1)),
    Row("lab1000", 0, 1000, 1000, (53, 0, 49), (45, 0, 10), (43, 0, 1)),
    Row("puma560", 0, 1000, 200, (69, 0, 12), (58, 0, 3), (56, 0, 0)),
    Row("puma560", 1, 1000, 200, (50, 0, 7), (46, 0, 2), (45, 0, 0)),
    Row("puma560", 2, 1000, 200, (51, 0, 8), (44, 0, 2), (43, 0, 0)),
    Row("puma560", 3, 1000, 200, (50, 0, 9), (43, 0, 2), (42, 0, 0)),
    Row("puma560", 4, 1000, 200, (48, 0, 6), (43, 0, 1), (42, 0, 0)),
    Row("puma560", 5, 1000, 200, (44, 0, 3), (42, 0, 1), (42, 0, 0)),
    Row("puma560", 0, 1000, 1000, (100, 0, 7), (100, 0.3, -2), (100, 0.4, 0)),
    Row("puma560", 1, 1000, 1000, (62, 1.5, -4), (62, 2.2, -1), (62, 2.4, 0)),
    Row("puma560", 3, 1000, 1000, (52, 0, 9), (51, 0, 2), (51, 0, 0)),
    Row("puma560", 1, 1000, -1000, (60, 4.5, 7), (60, 4.9, 2), (60, 5.0, 0)),
    Row("puma560", 0, 2000, 200, (NEVER, 0, 31), (82, 0, 7), (74, 0, 1)),
    Row("puma560", 1, 2000, 200, (108, 0, 17), (70, 0, 4), (66, 0, 0)),
    Row("puma560", 3, 2000, 200, (NEVER, 0, 22), (72, 0, 5), (64, 0, 1)),
    Row("puma560", 1, 2000, 1000, (86, 0, 16), (82, 0, 4), (82, 0, 1)),
]


def units_per_nm(motor) -> float:
    """D/A units that give one N m: 2048 units are 10 V into the amplifier."""
    return 2048 / (10 * motor.amp_gain * motor.km)


@functools.cache
def measure(robot: str, interval_us: int, size: int, compensation: str):
    """All axes of the robot make the step at once, each on its own; the result and its report."""
    base = "puma560" if robot == "puma560" else "lab500"
    counts = ["robot.axis.0.counts_per_rev=4000"] if robot == "lab1000" else []
    plain = load(base, *counts)
    factor = {"off": 0.0, "0.8": 0.8, "1.0": 1.0}[compensation]
    servo = [f'{{axis="all", ilim={ILIM}}}']
    for n, gains in enumerate(GAINS.get(robot, {}).get(f"pd_{interval_us}us", ())):
        servo.append(f"{{axis={n}, a0={gains[0]}, a1={gains[1]}, b0={gains[2]}, b1=0}}")
    for n, motor in enumerate(plain.robot.axis):
        units = factor * units_per_nm(motor)
        pos, neg = round(units * motor.coulomb_pos), round(units * motor.coulomb_neg)
        servo.append(f"{{axis={n}, ic_pos={pos}, ic_neg={neg}}}")
    sets = (
        *counts,
        f"interval_us={interval_us}",
        f"servo=[{', '.join(servo)}]",
        f'motion=[{{axis="all", kind="step", at=0.05, to={size}}}]',
        "expect=[]",
        f"duration={0.35 if interval_us < 1500 else 0.45}",
    )
    result = simulate(load(base, *sets))
    return result, make_report(result, "native")


def friction_bound(row: Row, compensation: str) -> int:
    """The largest error that friction can hold: ceil((Ts - ic) / P) counts."""
    result, _ = measure(row.robot, row.interval_us, row.size, compensation)
    motor, params = result.setup.robot.axis[row.axis], result.setup.params[row.axis]
    gain = (params["a0"] + params["a1"]) / params["b0"]
    units = units_per_nm(motor)
    stuck = max(
        units * motor.stiction_pos - params["ic_pos"], units * motor.stiction_neg - params["ic_neg"]
    )
    return math.ceil(stuck / gain)


def measured(row: Row, compensation: str) -> dict:
    return measure(row.robot, row.interval_us, row.size, compensation)[1]["axes"][row.axis]


def outside(row: Row, compensation: str) -> list[str]:
    """Which figures of the machine leave the band round the reference: rise, overshoot, error."""
    bound = friction_bound(row, compensation) + 1
    return _outside(measured(row, compensation), row.reference(compensation)[:2], 3, 0, bound)


def _outside(seen: dict, near: tuple, pct: float, error: float, counts: float) -> list[str]:
    rise, overshoot = near
    both = seen["rise_ms"] is not None and rise is not None
    left = {"rise": abs(seen["rise_ms"] - rise) > BAND_MS if both else seen["rise_ms"] != rise,
            "overshoot": abs(seen["overshoot_pct"] - overshoot) > pct,
            "error": abs(seen["steady_error_counts"] - error) > counts}  # fmt: skip
    return [name for name, is_off in left.items() if is_off]


@functools.cache
def shipped(size: int):
    """The report of a step of all six joints of the PUMA with the gains of its file."""
    motion = f'motion=[{{axis="all", kind="step", at=0.05, to={size}}}]'
    return make_report(simulate(load("puma560", motion, "expect=[]", "duration=0.4")), "native")


@functools.cache
def modelled(axis: int, size: int) -> tuple:
    """The same step of one joint by one_axis.py: rise, overshoot, steady error."""
    robot = load("puma560").robot
    law = robot.servo(axis, 1000)
    log = move(robot.axis[axis], law, lambda t: size if t > 0.0495 else 0, 1e-3, 0.4)
    y = np.array([count for _, count, _ in log], dtype=float)
    r = step_response(np.arange(len(y)) * 1e-3, y, 0.05, 0, size)
    return r.rise_ms, r.overshoot_pct, r.steady_error_counts


def outside_shipped(axis: int, size: int) -> list[str]:
    """Where the machine leaves the band round one_axis.py."""
    *near, error = modelled(axis, size)
    return _outside(shipped(size)["axes"][axis], near, 1, error, 3)


def document() -> str:
    return fill(DOCUMENT, {"steps": _steps(), "shipped": _shipped()})


def _steps() -> list[str]:
    lines = ["| axis | T | step | off | 0.8 | 1.0 | in band |", "|---|---|---|---|---|---|---|"]
    for row in ROWS:
        cells, left = [], []
        for compensation in COMPENSATION:
            seen = measured(row, compensation)
            figures = (seen["rise_ms"], seen["overshoot_pct"], seen["steady_error_counts"])
            left += [f"no: {figure} at {compensation}" for figure in outside(row, compensation)]
            cells.append(f"{_cell(row.reference(compensation))} → {_cell(figures)}")
        cells.append("; ".join(left) or "yes")
        name = row.robot.upper() if row.robot.startswith("lab") else f"J{row.axis + 1}"
        lines.append(
            f"| {name} | {row.interval_us // 1000} ms | {row.size} | " + " | ".join(cells) + " |"
        )
    return lines


def _shipped() -> list[str]:
    lines = [
        "| axis | " + " | ".join(f"step of {size}" for size in SHIPPED) + " | in band |",
        "|---|" + "---|" * len(SHIPPED) + "---|",
    ]
    for axis in range(6):
        cells, left = [], []
        for size in SHIPPED:
            seen = shipped(size)["axes"][axis]
            figures = (seen["rise_ms"], seen["overshoot_pct"], seen["steady_error_counts"])
            cells.append(f"{_cell(modelled(axis, size))} → {_cell(figures)}")
            left += [f"no: {figure} at {size}" for figure in outside_shipped(axis, size)]
        lines.append(f"| J{axis + 1} | {' | '.join(cells)} | {'; '.join(left) or 'yes'} |")
    return lines


def _cell(figures: tuple) -> str:
    rise, overshoot, error = figures
    return f"{'-' if rise is None else format(rise, '.0f')}/{overshoot:.2g}/{error:.0f}"


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    DOCUMENT.write_text(document())
