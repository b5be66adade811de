# SPDX-License-Identifier: Apache-2.0
"""Reference step responses of PD position loops, and the same steps on the simulated machine.

`python -m studies.reference` measures them all and writes docs/closed_loop.md. The reference
figures come from a plant and servo model of one axis that shares nothing with this project's code.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

from mmcs import ROOT

DOCUMENT = ROOT / "docs" / "closed_loop.md"
COMPENSATION = ("off", "0.8", "1.0")


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
    from mmcs.result.report import make_report
    from mmcs.run.runner import simulate
    from mmcs.scenario.load import load

    base = "puma560" if robot == "puma560" else "lab500"
    plain = load(base, (f'robot="{robot}"',))
    factor = {"off": 0.0, "0.8": 0.8, "1.0": 1.0}[compensation]
    servo = []
    for n, motor in enumerate(plain.robot.axis):
        units = factor * units_per_nm(motor)
        pos, neg = round(units * motor.coulomb_pos), round(units * motor.coulomb_neg)
        servo.append(f"{{axis={n}, ic_pos={pos}, ic_neg={neg}}}")
    sets = (
        f'robot="{robot}"',
        f"interval_us={interval_us}",
        f"servo=[{', '.join(servo)}]",
        f'motion=[{{axis="all", kind="step", at=0.05, to={size}}}]',
        "expect=[]",
        f"duration={0.35 if interval_us < 1500 else 0.45}",
    )
    result = simulate(load(base, sets))
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
    rise, overshoot, _ = row.reference(compensation)
    seen, out = measured(row, compensation), []
    both = seen["rise_ms"] is not None and rise is not None
    if abs(seen["rise_ms"] - rise) > max(0.1 * rise, 4) if both else seen["rise_ms"] != rise:
        out.append("rise")
    if abs(seen["overshoot_pct"] - overshoot) > 3:
        out.append("overshoot")
    if abs(seen["steady_error_counts"]) > friction_bound(row, compensation) + 1:
        out.append("error")
    return out


def document() -> str:
    lines = [
        "# Step responses of the closed loop",
        "",
        "Generated by `python -m studies.reference`: PD position loops with the gains of the robot",
        "files, double-buffered D/A, default host. Coulomb compensation off, at 0.8 and at 1.0 of",
        "the friction. Each cell: rise time in ms / overshoot in % / steady error in counts, first",
        "the reference, then what the machine did. `-`: friction stops it short of 90 %.",
        "",
        "The reference is a model of plant and servo in one page of arithmetic; the machine is",
        "firmware, bus cycles, RTL and physics. *In band*: rise within 10 % or 4 ms, overshoot",
        "within 3 points, steady error at most what friction can hold, ceil((Ts - ic)/P), and one",
        "count; at all three compensations.",
        "",
        "| axis | T | step | off | 0.8 | 1.0 | in band |",
        "|---|---|---|---|---|---|---|",
    ]
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
    return "\n".join(lines) + "\n"


def _cell(figures: tuple) -> str:
    rise, overshoot, error = figures
    return f"{'-' if rise is None else format(rise, '.0f')}/{overshoot:.2g}/{error:.0f}"


if __name__ == "__main__":
    DOCUMENT.write_text(document())
