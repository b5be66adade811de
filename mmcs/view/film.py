# SPDX-License-Identifier: Apache-2.0
"""`mmcs export film RUN`: the arm in three dimensions, as an animation."""

import os
from pathlib import Path

import numpy as np

from mmcs.errors import InputError
from mmcs.scenario.arm import link_frame
from mmcs.view.plot import BLUE, GREY, ORANGE
from mmcs.view.runs import Run

GIF_FPS = 20
MAX_FRAMES = 200
COLOURS = 32
VIEW = {"elev": 22, "azim": -60}


def style() -> None:
    """Of matplotlib, whose import a backend of a notebook's would end."""
    os.environ.pop("MPLBACKEND", None)
    import matplotlib

    matplotlib.rcParams.update({
        "font.size": 9, "axes.spines.top": False, "axes.spines.right": False,
        "axes.edgecolor": GREY, "axes.grid": True, "grid.color": "#e4e6ea", "grid.linewidth": 0.6,
    })  # fmt: skip


def arm_points(links: list[dict], angles: np.ndarray) -> np.ndarray:
    """Corners of the arm in the base frame, m: base, then two per link (along d, then along a)."""
    frame, points = np.eye(4), [np.zeros(3)]
    for link, q in zip(links, angles, strict=True):
        points.append((frame @ np.array([0, 0, link["d"], 1]))[:3])
        frame = frame @ link_frame(link["alpha"], link["a"], link["d"], q + link["theta0"])
        points.append(frame[:3, 3].copy())
    # The flange has no length of its own; a short tool shows which way it points.
    points.append((frame @ np.array([0, 0, 0.1, 1]))[:3])
    return np.array(points)


def poses(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the arm's corners at each of them."""
    links = run.report.get("links") or []
    if not links:
        raise InputError.one(run.folder, "", None, "its robot has no [[link]]: there is no arm")
    angles = np.column_stack([run.column(axis, "angle_rad") for axis in range(run.axes)])
    return run.log[:, 0], np.array([arm_points(links, row) for row in angles])


def write_gif(run: Run, path: Path, slower: float = 1.0) -> int:
    """The arm, beside it the joints' motion and, of a run with bus.csv, VME cycles of the sample.
    Returns the number of pictures; `slower` = 4 shows a second in four."""
    style()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    t, arm = poses(run)
    frames = max(2, min(MAX_FRAMES, round((t[-1] - t[0]) * slower * GIF_FPS)))
    figure = Figure(figsize=(8.4, 4.2), dpi=80)
    canvas = FigureCanvasAgg(figure)
    cell = figure.add_axes((0, 0, 0.46, 0.95), projection="3d")
    motion, bus = (
        figure.add_axes((0.54, 0.58, 0.43, 0.32)),
        figure.add_axes((0.54, 0.12, 0.43, 0.26)),
    )
    cycles = _cycles(run)
    images = []
    for k in np.linspace(0, len(t) - 1, frames).round().astype(int):
        cell.clear()
        _draw(cell, arm, int(k))
        cell.set_title(f"{t[k]:.3f} s", size=10)
        _draw_motion(motion, run, int(k))
        _draw_bus(bus, run, cycles, int(k))
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        images.append(
            picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        )
    duration = round((t[-1] - t[0]) * slower * 1000 / frames)
    images[0].save(path, save_all=True, append_images=images[1:], duration=duration, loop=0)
    return frames


def _draw_motion(cell, run: Run, k: int) -> None:
    """Counts of all joints, up to sample k."""
    cell.clear()
    t = run.log[:, 0]
    for axis in range(run.axes):
        counts = run.column(axis, "encoder")
        cell.plot(t, counts, color="#d0d3d8", lw=1)
        cell.plot(t[: k + 1], counts[: k + 1], color=BLUE, lw=1.4)
    cell.set_title("motors (plant), encoder counts", size=9, loc="left")
    cell.set(xlim=(t[0], t[-1]))
    cell.tick_params(labelsize=7)


def _cycles(run: Run) -> np.ndarray:
    """Begin and end in s since power-on, and whether it writes, of each cycle of bus.csv."""
    file = run.folder / "bus.csv"
    if not file.is_file():
        return np.empty((0, 3))
    rows = np.genfromtxt(file, delimiter=",", skip_header=1, usecols=(0, 1, 2), dtype=str)
    writes = rows[:, 2] == "write"
    return np.column_stack([rows[:, :2].astype(float) / run.report["clk_hz"], writes])


def _draw_bus(cell, run: Run, cycles: np.ndarray, k: int) -> None:
    """The VME cycles between the sample before k and k: reads and writes of the driver."""
    cell.clear()
    cell.set_axis_off()
    if not len(cycles):
        return
    interval = run.log[1, 0] - run.log[0, 0]
    ends = run.report["motion_start_s"] + run.log[k, 0]
    own = cycles[(cycles[:, 0] >= ends - interval) & (cycles[:, 0] < ends)]
    for begin, end, writes in own:
        at, height = 1e6 * (begin - ends + interval), 0.8
        cell.bar(at, height, 1e6 * (end - begin), int(writes), align="edge",
                 color=ORANGE if writes else BLUE)  # fmt: skip
    cell.set_axis_on()
    cell.set(
        xlim=(0, 1e6 * interval), ylim=(0, 2), yticks=[0.4, 1.4], yticklabels=["read", "write"]
    )
    cell.set_title(f"VME cycles (driver) in this sample, us: {len(own)}", size=9, loc="left")
    cell.tick_params(labelsize=7)


def _draw(cell, arm: np.ndarray, k: int) -> None:
    """The arm at sample k, where it began in grey, and the way of its flange."""
    reach = float(np.abs(arm[:, :, :2]).max()) * 1.05
    height = max(float(arm[:, :, 2].max()) * 1.05, reach)
    cell.plot(*arm[0].T, color=GREY, lw=1.2, alpha=0.6)
    cell.plot(*arm[: k + 1, -1].T, color=ORANGE, lw=1.0)
    corners = arm[k]
    cell.plot(*corners.T, color=BLUE, lw=4, solid_capstyle="round", solid_joinstyle="round")
    cell.plot(*corners[:-1:2].T, ls="", marker="o", ms=4, color="white", mec=BLUE)
    shadow = corners.copy()
    shadow[:, 2] = 0
    cell.plot(*shadow.T, color="#d0d3d8", lw=2)
    cell.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(0, height))
    cell.set_box_aspect((2 * reach, 2 * reach, height), zoom=1.25)
    cell.view_init(**VIEW)
    for axis in (cell.xaxis, cell.yaxis, cell.zaxis):
        axis.set_ticklabels([])
        axis.set_pane_color((1, 1, 1, 0))
