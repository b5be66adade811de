# SPDX-License-Identifier: Apache-2.0
"""`mmcs replay` and `mmcs trace`: a run made again from its record."""

import math
from pathlib import Path

from mmcs import __version__
from mmcs.engine.hosts import check, image_digest
from mmcs.errors import InputError
from mmcs.files import read_json, short
from mmcs.runs.record import Record, first_difference
from mmcs.scenario.compiled import digest
from mmcs.view.moments import LEAST_MS


def replay(record: Record) -> tuple[str, str | None, str]:
    """The hash that comes out now, where the replay first differs (None: nowhere), and what is said
    of another build ("": it is the same)."""
    from mmcs.runs.runner import simulate

    result = simulate(record.setup(), host=check(record.host, record.path, "host"))
    return result.hash, _difference(record, result), _other_build(record, result)


def _difference(record: Record, result) -> str | None:
    if result.hash == record.hash:
        return None
    where = first_difference(record, result.checkpoints)
    return where or "the registers at the end; all samples agree"


def _other_build(record: Record, result) -> str:
    """What is said of another build of the simulator; "": it is the same."""
    same = record.build == result.build
    return "" if same else f"recorded by build {record.build}, this is {result.build}"


def cautions(record: Record) -> list[str]:
    """What may explain a difference."""
    found = []
    if record.version != __version__:
        found.append(f"recorded by version {record.version}, this is {__version__}")
    for program in record.data.get("program", []):
        if program.get("digest") != digest(program["run"]):
            found.append(f"files that {program['run']!r} names have changed since the record")
    image, now = record.text.get("image", ""), image_digest(record.host)
    if image != now:
        found.append(f"recorded with the firmware image {image}, this one is {now}")
    return found


# --- a stretch with waveforms ------------------------------------------------------------------


def check_window(window_ms: float) -> None:
    if not LEAST_MS <= window_ms < math.inf:
        raise InputError.one("--window", "", window_ms, f"must be {LEAST_MS:g} ms or more")


def stretch(record: Record, at: str | None, window_ms: float) -> tuple[float, float]:
    """From and to, in seconds since power-on; `at` is a time since the motion began, or the kind
    of an event in the run's report."""
    end = record.motion_start_s + record.data["duration"]
    half = window_ms * 5e-4
    if at is None:
        return _first_moment(record, 2 * half, end)
    try:
        middle = record.motion_start_s + float(at)
    except ValueError:
        middle = _event_time(record, at)
    if not 0 <= middle <= end:
        allowed = f"must be {-record.motion_start_s:.4f} to {record.data['duration']:g}"
        raise InputError.one("--at", "", at, allowed + " s; the motion begins at 0")
    return max(0.0, middle - half), min(end, middle + half)


def _first_moment(record: Record, window_s: float, end: float) -> tuple[float, float]:
    """From the first event, or the first setpoint."""
    begin = record.motion_start_s + record.setup().moment()
    begin = max(record.motion_start_s, min(begin, end - window_s))
    return begin, min(end, begin + window_s)


def _event_time(record: Record, kind: str) -> float:
    file = record.path.with_name("report.json")
    try:
        events = read_json(file)["events"]
        times = [float(e["t"]) for e in events if e["kind"] == kind]
        kinds = ", ".join(sorted({e["kind"] for e in events})) or "none"
    except (ValueError, KeyError, TypeError):
        allowed = f"must be a time in seconds: {file} with the run's events is not there"
        raise InputError.one("--at", "", kind, allowed) from None
    if times:
        return times[0]
    allowed = f"must be a time in seconds, or the kind of an event of this run ({kinds})"
    raise InputError.one("--at", "", kind, allowed)


def trace(record: Record, path: Path, from_s: float, to_s: float) -> tuple[str | None, str]:
    """Makes the run again with waveforms of this stretch: where it differs (None: nowhere), and
    what is said of another build.

    The stretch is the trace build's, clock by clock, with assertions; the rest is without
    waveforms. The hash at the end is of all of it, which proves that the waveforms are those of the
    run.
    """
    from mmcs.runs.machine import machine, progress
    from mmcs.runs.session import session_of
    from mmcs.runs.stretch import Changing

    host = check(record.host, record.path, "host")
    setup = record.setup()
    with (
        machine(setup, host=host) as quick,
        machine(setup, "trace", host=host) as traced,
        progress(setup.scenario.duration) as advance,
    ):
        # programs stay with one machine
        start = math.inf if setup.scenario.program else record.motion_start_s
        sim = Changing(quick, traced, path, (from_s, to_s), start)
        result = session_of(sim, setup).run(advance)
    other = _other_build(record, result)
    if result.assertion:
        notes = [n["text"] for n in result.notes if n["kind"] == "assert"]
        return "an assertion of the model fails: " + (notes or ["no text"])[-1], other
    return _difference(record, result), other


def default_path(record: Record, from_s: float, to_s: float) -> Path:
    middle = (from_s + to_s) / 2 - record.motion_start_s
    return short(record.path.parent) / f"{record.scenario}_{middle:.6f}.fst"
