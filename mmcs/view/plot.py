# SPDX-License-Identifier: Apache-2.0
"""The picture of a run: setpoint and position, joint angle, error and current of every axis."""

from pathlib import Path

import numpy as np

from mmcs import logcols
from mmcs.errors import one_line
from mmcs.view import chart
from mmcs.view.chart import GREY, Cell

BLUE, ORANGE, RED = "#1f5fa8", "#d9822b", "#b3363e"
MAX_POINTS = 4000
HEIGHTS = (2.2, 1.2, 1.2, 1.2)
LABELS = (
    ("position", "counts"),
    ("joint angle", "deg"),
    ("error", "counts"),
    ("current", "D/A units"),
)


def grid(names: list[str], heights: tuple, labels: tuple) -> tuple[list[list[Cell]], tuple]:
    """A column of cells, one above the other, for each axis, and the picture's size in points."""
    axes = len(names)
    wide, high = 72 * max(7.0, 3.0 * axes), 72 * 7.4
    left, right, top, bottom, between, beneath = 68, 11, 52, 32, 54, 12
    width = (wide - left - right - (axes - 1) * between) / axes
    room = (high - top - bottom - (len(heights) - 1) * beneath) / sum(heights)
    columns = []
    for axis, name in enumerate(names):
        above = top
        column = []
        for row, share in enumerate(heights):
            cell = Cell(left + axis * (width + between), above, width, share * room)
            cell.labels = labels[row] if axis == 0 else ()
            column.append(cell)
            above += share * room + beneath
        column[0].title = f"axis {axis}" + (f" ({one_line(name)})" if name else "")
        column[-1].below = "s"
        columns.append(column)
    return columns, (wide, high)


def write_plot(result, path) -> None:
    """Into an SVG file, or a text stream."""
    robot = result.setup.robot
    names = [robot.axis_name(axis) for axis in range(result.setup.axes)]
    columns, size = grid(names, HEIGHTS, LABELS)
    for axis, column in enumerate(columns):
        _draw_axis(result, axis, column)
    title = one_line(f"{result.setup.name}: {result.setup.scenario.description}")
    text = chart.picture(sum(columns, []), *size, title)
    if hasattr(path, "write"):
        path.write(text)
    else:
        Path(path).write_text(text)


def _draw_axis(result, axis: int, cells) -> None:
    log = result.log
    stride = max(1, len(log) // MAX_POINTS)
    log = log[::stride]
    t = log[:, 0]
    setpoint, encoder, velocity, error, current, errcode, angle = (
        logcols.column(log, axis, name) for name in logcols.FIELDS
    )
    params = result.setup.params[axis]
    in_velocity = params["mode"] == "velocity"
    what, y = ("velocity", velocity) if in_velocity else ("encoder", encoder)
    top, arm, wrong, amps = cells
    top.line(t, setpoint, ORANGE, 1.2, steps=True, label="setpoint" if axis == 0 else "")
    top.line(t, y, BLUE, 1.2, label=what if axis == 0 else "")
    if in_velocity:
        top.labels = ("counts/sample",)
    arm.line(t, np.degrees(angle), BLUE, 1.0)
    wrong.line(t, error, RED, 0.8)
    wrong.rule(GREY, 0.6, y=0.0)
    amps.line(t, current, BLUE, 0.7, steps=True)
    if np.abs(current).max(initial=0) > 0.9 * params["ilim"]:
        for limit in (-params["ilim"], params["ilim"]):
            amps.rule(GREY, 0.8, y=limit, dash="1 2")
    for when in t[np.flatnonzero(np.diff(errcode) > 0) + 1]:
        top.rule(RED, 0.8, x=when, dash="4 2")
