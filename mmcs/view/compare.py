# SPDX-License-Identifier: Apache-2.0
"""`mmcs compare A B`: two runs over each other, axis by axis."""

from pathlib import Path

import numpy as np

from mmcs.errors import InputError, one_line
from mmcs.view import svg
from mmcs.view.plot import BLUE, GREY, ORANGE, place, style
from mmcs.view.runs import Run

ROWS = (("encoder", "position\ncounts"), ("error", "error\ncounts"), ("current", "current\nD/A"))


def differences(a: Run, b: Run) -> list[dict]:
    """Per axis: the largest difference of each row's signal at the samples that both have."""
    if a.axes != b.axes:
        names = [getattr(run, "folder", run) for run in (a, b)]
        raise InputError.one(names[1], "", None, f"has {b.axes} axes, {names[0]} has {a.axes}")
    times = np.intersect1d(a.log[:, 0], b.log[:, 0])
    rows_a, rows_b = (np.isin(run.log[:, 0], times) for run in (a, b))
    out = []
    for axis in range(a.axes):
        seen = {"axis": axis, "name": a.report["axes"][axis].get("name", "")}
        for signal, _ in ROWS:
            delta = a.column(axis, signal)[rows_a] - b.column(axis, signal)[rows_b]
            seen[signal] = float(np.abs(delta).max()) if len(delta) else None
        out.append(seen)
    return out


def write_comparison(a: Run, b: Run, path: Path) -> list[dict]:
    found = differences(a, b)
    plt = style()
    figure, grid = plt.subplots(
        len(ROWS), a.axes, sharex=True, squeeze=False,
        figsize=(max(7.0, 3.0 * a.axes), 6.0),
    )  # fmt: skip
    names = [_label(a, b), _label(b, a)]
    for axis in range(a.axes):
        for row, (signal, label) in enumerate(ROWS):
            cell = grid[row][axis]
            for run, colour, width, name in ((a, BLUE, 1.6, names[0]), (b, ORANGE, 0.9, names[1])):
                cell.plot(run.log[:, 0], run.column(axis, signal), color=colour, lw=width,
                          label=name)  # fmt: skip
            if signal == "encoder":
                cell.step(a.log[:, 0], a.column(axis, "setpoint"), where="post", color=GREY, lw=0.7)
                title = a.report["axes"][axis].get("name", "")
                cell.set_title(
                    f"axis {axis}" + (f" ({one_line(str(title))})" if title else ""), loc="left"
                )
            if axis == 0:
                cell.set_ylabel(label)
        grid[-1][axis].set_xlabel("s")
    grid[0][0].legend(loc="best", frameon=False)
    place(figure, grid)
    svg.save(figure, path)
    plt.close(figure)
    return found


def _label(run: Run, other: Run) -> str:
    name = run.report["scenario"]
    return one_line(name if name != other.report["scenario"] else f"{name} in {run.folder.name}")
