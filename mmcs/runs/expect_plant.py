# SPDX-License-Identifier: Apache-2.0
"""Judges what the log and the physics show: signals, movement, calibration, refusals."""

import errno
import math

import numpy as np

from mmcs import logcols, mcdef
from mmcs.scenario.scenario import (
    CalibrationExpect,
    PhysicsExpect,
    RefusedExpect,
    SignalExpect,
)

AT_REST = 1e-3  # rad/s of the joint
ADC_ZERO, ADC_VOLTS = 2048, 10 / 2048
FIGURES = {
    "mean": np.mean,
    "rms": lambda x: np.sqrt(np.mean(np.square(x))),
    "lowest": np.min,
    "highest": np.max,
    "last": lambda x: x[-1],
}


def verdict(what: str, value: float | None, band: list[float]) -> dict:
    ok = value is not None and band[0] <= value <= band[1]
    shown = "never" if value is None else f"{value:g}"
    return {"what": f"{what}: {shown}", "ok": bool(ok)}


def band_text(band: list[float]) -> str:
    low, high = band
    if low == high:
        return f"= {high:g}"
    return f"within ±{high:g}" if low == -high else f"in {low:g}..{high:g}"


def axes_of(entry, result):
    return range(result.setup.axes) if entry.axis == "all" else entry.axis


def banded(entry, result, keys):
    """(axis, key, band) of what is expected of each axis."""
    for place, axis in enumerate(axes_of(entry, result)):
        for key in keys:
            band = getattr(entry, key)
            if band is not None:
                yield axis, key, band[place] if isinstance(band[0], list) else band


def signal(entry: SignalExpect, result) -> list[dict]:
    verdicts = []
    t = result.log[:, 0]
    inside = (t >= entry.after) & (t <= entry.until)
    for axis, name, band in banded(entry, result, FIGURES):
        values = logcols.column(result.log, axis, entry.signal)[inside]
        value = round(float(FIGURES[name](values)), 3) if len(values) else None
        what = f"axis {axis} {entry.signal} {name} {band_text(band)}"
        verdicts.append(verdict(what, value, band))
    return verdicts


def truth_columns(result, axis: int) -> tuple[np.ndarray, ...]:
    """Angle, velocity and current of a joint at the looks of the session."""
    first = 2 + 3 * axis
    return tuple(result.truth[:, first + k] for k in range(3))


def moved_deg(result, axis: int, after: float) -> float:
    """Farthest from where the joint was at `after`."""
    angle = truth_columns(result, axis)[0][result.truth[:, 0] >= after - 1e-9]
    return math.degrees(float(np.abs(angle - angle[0]).max())) if len(angle) else 0.0


def rest_ms(result, axis: int, after: float) -> float | None:
    """From `after` until the joint stays at rest; None if it does not."""
    t, velocity = result.truth[:, 0], truth_columns(result, axis)[1]
    moving = np.flatnonzero(np.abs(velocity) > AT_REST)
    if len(moving) == 0:
        return 0.0
    if moving[-1] + 1 >= len(t):
        return None
    return max(0.0, float(t[moving[-1] + 1] - after) * 1e3)


def off_counts(result, axis: int) -> float:
    """Where the joint is at the end, minus where its encoder says, in counts of a good encoder."""
    motor, truth = result.setup.motors()[axis], result.witnesses[axis]
    turned = (truth["angle"] - motor["angle0"]) * result.setup.robot.counts_per_rad(axis)
    return round(turned - result.states[axis]["encnow"], 1)


def physics(entry: PhysicsExpect, result) -> list[dict]:
    figures = {
        "moved_deg": ("moved", " deg", lambda n: round(moved_deg(result, n, entry.after), 4)),
        "rest_ms": ("at rest", " ms", lambda n: rest_ms(result, n, entry.after)),
        "current_a": ("current", " A", lambda n: round(result.witnesses[n]["current"], 4)),
        "off_counts": ("true minus encoder", " counts", lambda n: off_counts(result, n)),
    }
    verdicts = []
    for axis, key, band in banded(entry, result, figures):
        name, unit, figure = figures[key]
        what = f"joint {axis} {name} {band_text(band)}{unit}"
        verdicts.append(verdict(what, figure(axis), band))
    return verdicts


def index_counts(result, axis: int) -> list[int]:
    """The counts at the index that the driver reported: bits 16-31 of errcode, signed."""
    counts, before = [], 0
    for value in logcols.column(result.log, axis, "errcode"):
        code = int(value)
        if code & ~before & mcdef.MERR_ZINDEX:
            counts.append(((code >> 16) + 0x8000) % 0x10000 - 0x8000)
        before = code
    return counts


def calibrate(result, axis: int) -> tuple[list[int], int] | None:
    """(found, true): the disc's absolute count where the encoder reads 0. None: no index.

    Found as a user's program does, once for every index that was reported: the potentiometer says
    in which revolution the index lies, the count at the index where in it.
    """
    counts = index_counts(result, axis)
    if not counts or axis not in result.pots:
        return None
    motor, (code, encoder) = result.setup.motors()[axis], result.pots[axis]
    per_rad, per_rev = result.setup.robot.counts_per_rad(axis), motor["counts_per_rev"]
    volts = (code - ADC_ZERO) * ADC_VOLTS
    angle = (volts - motor["pot_offset"]) / motor["pot_v_per_rad"]
    rough = angle * per_rad - encoder  # what we look for, as far as the potentiometer tells
    offset = motor["encoder_offset"] * per_rev / (2 * math.pi)
    true = math.floor(motor["angle0"] * per_rad + offset + 0.5)
    return [round((rough + offset + n) / per_rev) * per_rev - n for n in counts], true


def calibration(entry: CalibrationExpect, result) -> list[dict]:
    verdicts = []
    for axis, _, band in banded(entry, result, ["error_counts"]):
        done = calibrate(result, axis)
        if not entry.found and axis not in result.pots:
            verdicts.append({"what": f"axis {axis} looks for its index: never asked", "ok": False})
            continue
        if not entry.found or done is None:
            what = f"axis {axis} index {'found' if entry.found else 'not found'}"
            verdicts.append({"what": what, "ok": (done is not None) == entry.found})
            continue
        found, true = done
        marks = f"{len(found)} mark{'s' * (len(found) > 1)}"
        what = f"axis {axis} calibrated at {marks}, error {band_text(band)} counts"
        for error in sorted({n - true for n in found}):
            verdicts.append(verdict(what, error, band))
    return verdicts


def refused(entry: RefusedExpect, result) -> list[dict]:
    seen = [(name, errno.errorcode.get(number, str(number))) for name, number in result.refused]
    what = f"{entry.request} refused with {entry.error}"
    what += "" if seen else ": nothing was refused"
    return [{"what": what, "ok": (entry.request, entry.error) in seen}]
