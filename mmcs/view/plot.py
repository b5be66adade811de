# SPDX-License-Identifier: Apache-2.0
"""The picture of a run: setpoint and position, joint angle, error and current of every axis."""

from __future__ import annotations

import numpy as np

from mmcs import logcols
from mmcs.errors import one_line
from mmcs.view import svg

BLUE, ORANGE, GREY, RED = "#1f5fa8", "#d9822b", "#8a8f98", "#b3363e"
MAX_POINTS = 4000
ROWS = ("position", "angle", "error", "current")
HEIGHTS = (2.2, 1.2, 1.2, 1.2)
LABELS = ("position\ncounts", "joint angle\ndeg", "error\ncounts", "current\nD/A units")


def style():
    """pyplot, set up so that the same data draws the same SVG file."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update(
        {
            "font.size": 9,
            "font.family": "sans-serif",
            "svg.fonttype": "none",
            "svg.hashsalt": "mmcs",  # the same run draws the same file
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": GREY,
            "text.parse_math": False,  # a $ in a description is a $
            "axes.grid": True,
            "grid.color": "#e4e6ea",
            "grid.linewidth": 0.6,
        }
    )
    import matplotlib.pyplot as plt

    return plt


def write_plot(result, path, form: str | None = None) -> None:
    """path: of a file, whose ending says the format, or a stream with `form`."""
    plt = style()
    axes = result.setup.axes
    figure, grid = plt.subplots(
        len(ROWS), axes, sharex=True, squeeze=False, figsize=(max(7.0, 3.0 * axes), 7.4),
        height_ratios=HEIGHTS,
    )  # fmt: skip
    for axis in range(axes):
        _draw_axis(result, axis, grid[:, axis])
    for row, label in enumerate(LABELS):
        grid[row][0].set_ylabel(label)
    grid[0][0].legend(loc="best", frameon=False)
    place(figure, grid)
    title = one_line(f"{result.setup.name}: {result.setup.scenario.description}")
    figure.suptitle(title, x=0.01, ha="left", size=11)
    svg.save(figure, path, form)
    plt.close(figure)


def place(figure, grid) -> None:
    """Cells and labels at fixed distances: to ask all texts for their sizes takes half the time."""
    wide, high = figure.get_size_inches()
    rows, axes = grid.shape
    left, right, top, bottom, between, beneath = 0.95, 0.15, 0.72, 0.45, 0.75, 0.16  # inches
    cell = (wide - left - right - (axes - 1) * between) / axes
    mean = (high - top - bottom - (rows - 1) * beneath) / rows
    figure.subplots_adjust(
        left / wide, bottom / high, 1 - right / wide, 1 - top / high, between / cell, beneath / mean
    )
    for axes in grid.flat:
        axes.yaxis.set_label_coords(-0.6 / cell, 0.5)


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
    name = result.setup.robot.axis_name(axis)
    top.set_title(f"axis {axis}" + (f" ({one_line(name)})" if name else ""), loc="left", size=10)
    top.step(t, setpoint, where="post", color=ORANGE, lw=1.2, label="setpoint")
    top.plot(t, y, color=BLUE, lw=1.2, label=what)
    if in_velocity:
        top.set_ylabel("counts/sample")
    arm.plot(t, np.degrees(angle), color=BLUE, lw=1.0)
    wrong.plot(t, error, color=RED, lw=0.8)
    wrong.axhline(0, color=GREY, lw=0.6)
    amps.step(t, current, where="post", color=BLUE, lw=0.7)
    if np.abs(current).max(initial=0) > 0.9 * params["ilim"]:
        for limit in (-params["ilim"], params["ilim"]):
            amps.axhline(limit, color=GREY, lw=0.8, ls=":")
    for when in t[np.flatnonzero(np.diff(errcode) > 0) + 1]:
        top.axvline(when, color=RED, lw=0.8, ls="--")
    amps.set_xlabel("s")
