# SPDX-License-Identifier: Apache-2.0
"""Judges a run against the scenario's expectations."""

import numpy as np

from mmcs import logcols
from mmcs.runs import expect_plant as plant
from mmcs.runs.expect_plant import band_text as _band
from mmcs.runs.expect_plant import verdict as _verdict
from mmcs.scenario.scenario import AxisExpect, EventExpect, StatsExpect

PLANT = {
    "signal": plant.signal,
    "physics": plant.physics,
    "calibration": plant.calibration,
    "refused": plant.refused,
}
NOTE_CHARS = 99  # of an event's text are kept
AXIS_UNITS = {
    "rise_ms": ("rise", " ms"),
    "overshoot_pct": ("overshoot", " %"),
    "settle_ms": ("settling", " ms"),
    "steady_error_counts": ("steady error", " counts"),
    "final_counts": ("final position", " counts"),
    "peak_error_counts": ("peak error", " counts"),
}


def judge(result, axes: list[dict]) -> list[dict]:
    """One {"what", "ok"} per single expectation, in the order of the file."""
    verdicts = []
    for entry in result.setup.scenario.expect:
        if isinstance(entry, AxisExpect):
            verdicts += _axis(entry, result, axes)
        elif isinstance(entry, StatsExpect):
            verdicts += _stats(entry, result.stats)
        elif isinstance(entry, EventExpect):
            verdicts.append(_event(entry, result))
        elif entry.kind in PLANT:
            verdicts += PLANT[entry.kind](entry, result)
    unexpected = [name for name, _ in result.refused]
    for entry in result.setup.scenario.expect:
        if entry.kind == "refused" and entry.request in unexpected:
            unexpected.remove(entry.request)
    verdicts += [{"what": f"the driver grants {name}", "ok": False} for name in unexpected]
    if result.assertion:
        text = next((n["text"] for n in reversed(result.notes) if n["kind"] == "assert"), "")
        verdicts.append(
            {"what": f"no assertion of the machine fails: {text}".rstrip(": "), "ok": False}
        )
    if result.ended:
        what = f"the run goes to its end: {result.ended} at {result.simulated_s:.3f} s"
        verdicts.append({"what": what, "ok": False})
    return verdicts


def _axis(entry: AxisExpect, result, axes: list[dict]) -> list[dict]:
    verdicts = []
    for axis, key, band in plant.banded(entry, result, AXIS_UNITS):
        encoder, error = (logcols.column(result.log, axis, name) for name in ("encoder", "error"))
        seen = axes[axis] | {
            "final_counts": float(encoder[-1]) if len(encoder) else None,
            "peak_error_counts": float(np.abs(error).max()) if len(error) else None,
        }
        name, unit = AXIS_UNITS[key]
        what = f"axis {axis} {name} {_band(band)}{unit}"
        verdicts.append(_verdict(what, seen[key], band))
    return verdicts


def _stats(entry: StatsExpect, stats: dict) -> list[dict]:
    names = [name for name in StatsExpect.model_fields if name != "kind"]
    bands = {name: getattr(entry, name) for name in names}
    return [
        _verdict(f"{name.replace('_', ' ')} {_band(band)}", stats[name], band)
        for name, band in bands.items()
        if band is not None
    ]


def _event(entry: EventExpect, result) -> dict:
    begin = result.motion_start_s + entry.after
    end = float("inf") if entry.within_ms is None else begin + entry.within_ms / 1e3
    kinds = [entry.event] if isinstance(entry.event, str) else entry.event
    kind = [
        note
        for note in result.notes
        if note["kind"] in kinds
        and begin <= note["t"] <= end
        and (entry.axis is None or note["axis"] == entry.axis)
    ]
    hits = [note for note in kind if entry.text is None or entry.text in note["text"]]
    what = f"event {' or '.join(kinds)}"
    what += "" if entry.axis is None else f" of axis {entry.axis}"
    what += "" if entry.text is None else f' "{entry.text}"'
    what += " seen" if entry.seen else " not seen"
    what += "" if entry.within_ms is None else f" within {entry.within_ms:g} ms"
    if hits:
        what += f": at {(hits[0]['t'] - begin) * 1e3:.1f} ms"
        return {"what": what, "ok": entry.seen}
    unknown = _unknown(entry, result, kind, end)
    what += f": cannot be decided, {unknown}" if unknown else ""
    return {"what": what, "ok": not entry.seen and not unknown}


def _unknown(entry: EventExpect, result, kind: list[dict], end: float) -> str:
    """Why it is not known that nothing of the sort happened; "" when it is known."""
    if result.notes_lost and result.notes[-1]["t"] <= end:
        return (
            f"only the first {len(result.notes)} of {len(result.notes) + result.notes_lost} "
            f"events are kept, up to {result.notes[-1]['t']:.3f} s"
        )
    if entry.text is not None and any(len(note["text"]) >= NOTE_CHARS for note in kind):
        return f"an event's text is cut after {NOTE_CHARS} characters"
    return ""
