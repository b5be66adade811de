# SPDX-License-Identifier: Apache-2.0
"""`mmcs compare A B`: two runs over each other, axis by axis."""

from pathlib import Path

import numpy as np

from mmcs.errors import InputError, one_line
from mmcs.view import chart
from mmcs.view.plot import BLUE, GREY, MAX_POINTS, ORANGE, grid
from mmcs.view.runs import Run

SIGNALS = ("encoder", "error", "current")
FIGURES = {
    "rms_error_counts": "rms error\ncounts", "rise_ms": "rise\nms", "final_counts": "final\ncounts",
}  # fmt: skip
LABELS = (("position", "counts"), ("error", "counts"), ("current", "D/A"))


def differences(a: Run, b: Run) -> list[dict]:
    """Per axis: the largest difference of each signal at the samples that both have. If they have
    none, as with another host: of the encoder at those of A, on straight lines between B's."""
    if a.axes != b.axes:
        names = [getattr(run, "folder", run) for run in (a, b)]
        raise InputError.one(names[1], "", None, f"has {b.axes} axes, {names[0]} has {a.axes}")
    at, other = a.log[:, 0], b.log[:, 0]
    times = np.intersect1d(at, other)
    signals = SIGNALS
    if len(times) == 0 and len(other):
        times, signals = at[(at >= other[0]) & (at <= other[-1])], SIGNALS[:1]
    out = []
    for axis in range(a.axes):
        seen = {"axis": axis, "name": a.report["axes"][axis].get("name", "")}
        seen |= dict.fromkeys(SIGNALS)
        for signal in signals if len(times) else ():
            of_a, of_b = (np.interp(times, r.log[:, 0], r.column(axis, signal)) for r in (a, b))
            seen[signal] = float(np.abs(of_a - of_b).max())
        out.append(seen)
    return out


def write_comparison(a: Run, b: Run, path: Path) -> list[dict]:
    found = differences(a, b)
    names = [str(axis.get("name", "")) for axis in a.report["axes"]]
    columns, size = grid(names, (1.0,) * len(SIGNALS), LABELS)
    runs = [_label(a, b), _label(b, a)]
    for axis, column in enumerate(columns):
        for cell, signal in zip(column, SIGNALS, strict=True):
            for run, colour, width, name in ((a, BLUE, 1.6, runs[0]), (b, ORANGE, 0.9, runs[1])):
                label = name if cell is columns[0][0] else ""
                _line(cell, run, axis, signal, colour, width, label=label)
        _line(column[0], a, axis, "setpoint", GREY, 0.7, steps=True)
    path.write_text(chart.picture(sum(columns, []), *size, " and ".join(runs)))
    return found


def print_comparison(a: Run, b: Run, found: list[dict]) -> None:
    """A table: how far the signals are apart at most, and rms error, rise and end of A and B."""
    from mmcs.screen import echo, shown, table

    head = [f"{name}\napart,\n{unit}" for name, (_, unit) in zip(SIGNALS, LABELS, strict=True)]
    head += [f"{heading}\nA | B" for heading in FIGURES.values()]
    rows = []
    for seen, *axes in zip(found, a.report["axes"], b.report["axes"], strict=True):
        figures = (" | ".join(shown(axis.get(key)) for axis in axes) for key in FIGURES)
        name = f"{seen['axis']} {seen['name']}"
        rows.append((name, *(shown(seen[signal]) for signal in SIGNALS), *figures))
    echo(table(f"A {_label(a, b)}, B {_label(b, a)}", ("axis", *head), rows, left=1))
    if found[0][SIGNALS[1]] is None:
        echo("-: sampled at other times; the encoder of B is taken between its samples")


def _line(cell, run: Run, axis: int, signal: str, *look, **more) -> None:
    stride = max(1, len(run.log) // MAX_POINTS)
    cell.line(run.log[::stride, 0], run.column(axis, signal)[::stride], *look, **more)


def _label(run: Run, other: Run) -> str:
    name = run.report["scenario"]
    return one_line(name if name != other.report["scenario"] else f"{name} in {run.folder.name}")
