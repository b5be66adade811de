# SPDX-License-Identifier: Apache-2.0
"""From the result of a run to report.json, log.csv and the table on the terminal."""

import itertools
import json
import zlib
from dataclasses import asdict
from pathlib import Path

import numpy as np

from mmcs import __version__, logcols
from mmcs.engine.rows import blocks
from mmcs.runs import metrics
from mmcs.runs.expect import judge
from mmcs.service import log_lines

MOST_CURRENT = 2047  # of the D/A
HEADINGS = {  # of the table of axes
    "rise_ms": "rise\nms",
    "overshoot_pct": "over-\nshoot\n%",
    "settle_ms": "settled\nms",
    "steady_error_counts": "steady\nerror\ncounts",
    "rms_error_counts": "rms\nerror\ncounts",
    "final_counts": "final\ncounts",
}
NONE = "-: not a step, or never there (rise: 90 % of the step; settled: within 2 % of it)"
FEW = 6  # more met expectations than this are not listed one by one


def measure(result) -> list[dict]:
    """The figures of every axis; what does not apply is None."""
    return [_measure_axis(result, axis) for axis in range(result.setup.axes)]


def _measure_axis(result, axis: int) -> dict:
    log, params = result.log, result.setup.params[axis]
    figures = {"axis": axis, "name": result.setup.robot.axis_name(axis), "mode": params["mode"]}
    t = log[:, 0]
    signal = "velocity" if params["mode"] == "velocity" else "encoder"
    y, setpoint = (logcols.column(log, axis, name) for name in (signal, "setpoint"))
    segments = [s for s in result.setup.segments if s["axis"] == axis]
    steps = [s for s in segments if s["kind"] == "step"]
    response = metrics.Response(steady_error_counts=metrics.steady_error(t, setpoint, y))
    if steps and params["mode"] in ("position", "velocity"):
        last = steps[-1]
        later = [s["t0"] for s in segments if s["t0"] > last["t0"]]
        window = t < (later[0] - 1e-9 if later else np.inf)
        earlier = setpoint[t < last["t0"] - 1e-9]
        before = float(earlier[-1]) if len(earlier) else 0.0
        response = metrics.step_response(t[window], y[window], last["t0"], before, last["to"])
    error, current = setpoint - y, logcols.column(log, axis, "current")
    figures |= asdict(response)
    return figures | {
        "rms_error_counts": round(float(np.sqrt(np.mean(error**2))), 3) if len(log) else None,
        "final_counts": float(y[-1]) if len(log) else None,
        "peak_current": float(np.abs(current).max()) if len(log) else None,
        "limited_samples": int(limited(current, params).sum()),
    }


def limited(current: np.ndarray, params: dict) -> np.ndarray:
    """The samples in which the limit cut the current: ilim, or the D/A's own if ilimax > 0."""
    limit = params["ilim"] if params["ilimax"] == 0 else MOST_CURRENT
    cut = np.abs(current) >= min(limit, MOST_CURRENT)
    return cut & (params["mode"] != "off") & (limit > 0)


def make_report(result, host: str) -> dict:
    axes = measure(result)
    stats = result.stats
    names = ("interrupts", "missed", "overruns", "panics", "spurious", "clips", "bus_errors")
    return {
        "scenario": result.setup.name,
        "simulated_s": round(result.simulated_s, 9),
        "wall_s": round(result.wall_s, 4),
        "rtf": round(result.simulated_s / result.wall_s, 3) if result.wall_s > 0 else None,
        "clk_hz": result.clk_hz,
        "cycles": result.cycles,
        "hash": result.hash,
        "host": host,
        "cards": result.setup.scenario.cards,
        "axes": axes,
        "stats": {name: int(stats[name]) for name in names},
        "events": [dict(note) for note in result.notes],
        "events_lost": result.notes_lost,
        "expect": judge(result, axes),
        "processes": result.processes,
        "links": [
            {key: link[key] for key in ("alpha", "a", "d", "theta0")}
            for link in result.setup.robot.links()
        ],
        "version": __version__,
        "seed": result.setup.scenario.seed,
        "interval_us": result.setup.scenario.interval_us,
        "motion_start_s": round(result.motion_start_s, 9),
        "evals": int(stats["evals"]),
        "cache": {name: int(stats[f"cache_{name}"]) for name in ("hits", "misses", "bytes")},
        "bus_cycles": int(stats["bus_cycles"]),
    }


def write_report(report: dict, folder: Path) -> None:
    (folder / "report.json").write_text(json.dumps(report, indent=1) + "\n")


def write_log(result, folder: Path) -> int:
    """One row per servo sample; whole numbers are written as such. The file's CRC-32."""
    columns, crc = result.log.shape[1], 0
    with (folder / "log.csv").open("wb") as file:
        for rows in itertools.chain([None], blocks(result.log)):
            text = log_lines(columns, rows)
            crc = zlib.crc32(text, crc)
            file.write(text)
    return crc


def print_report(report: dict, result, say) -> None:
    """say(text): a line, or several."""
    from mmcs.screen import shown, table

    rows = [
        (f"{axis['axis']} {axis['name']}", axis["mode"], *(shown(axis[key]) for key in HEADINGS))
        for axis in report["axes"]
    ]
    title = f"{report['scenario']}: {result.setup.scenario.description}"
    say(table(title, ("axis", "mode", *HEADINGS.values()), rows, left=2))
    if any(axis[key] is None for axis in report["axes"] for key in HEADINGS):
        say(NONE)
    named = ("interrupts", "missed", "overruns", "panics")
    counts = ", ".join(f"{report['stats'][name]} {name}" for name in named)
    if not report["stats"]["interrupts"]:
        counts = "the driver of /dev/mc0 has had no interrupts"
    say(f"{counts}; hash {report['hash']}")
    for axis in report["axes"]:
        if axis["limited_samples"]:
            say(f"axis {axis['axis']}: the limit cut the current in "
                          f"{axis['limited_samples']} of {len(result.log)} samples")  # fmt: skip
    for note in report["events"]:
        if note["kind"] != "log":
            where = "" if note["axis"] < 0 else f" axis {note['axis']}"
            line = f"  {note['t']:.6f} s  {note['kind']}{where}: {note['text']}"
            say(line)
    if report["events_lost"]:
        say(f"  {report['events_lost']} further events are not kept: look into the first")
    for process in report["processes"]:
        if status := process.get("status"):
            say(f"  {process['run']}: status {status}")
    expected = report["expect"]
    for item in expected:
        if not item["ok"] or len(expected) <= FEW:
            verdict = "ok    " if item["ok"] else "FAILED"
            say(f"  {verdict}  {item['what']}")
    if expected:
        met = sum(item["ok"] for item in expected)
        say(f"expectations: {met} of {len(expected)} met")
    say(
        f"simulated {report['simulated_s']:.3f} s in {report['wall_s']:.2f} s: "
        f"real-time factor {report['rtf']:.2f}"
    )
