# SPDX-License-Identifier: Apache-2.0
"""What auto-tune promised, and whether the axis does it."""

from dataclasses import asdict

import numpy as np

from mmcs.runs.metrics import step_response
from mmcs.scenario.identify import Motor
from mmcs.scenario.predict import step as predicted_step

HELD_OFF = 2.0  # counts: more of them, and an integral is tried
NEAR_RISE, NEAR_MS = 1.4, 10.0  # a measured rise may be so much longer than the predicted one
MORE_OVERSHOOT = 10.0  # per cent, than predicted


def predict(motor: Motor, param: dict, t: float, size: float, seconds: float, away: float) -> dict:
    """The step that the motor's numbers promise, with limit and friction."""
    rows = max(2, int(min(seconds, 4.0) / t))
    y = predicted_step(motor, param, t, round(size), rows, away)
    at = np.arange(rows) * t
    told = asdict(step_response(at, y, 0.0, 0.0, round(size)))
    return told | {"t": at.tolist(), "y": y.tolist()}


def judge(measured: dict, predicted: dict) -> tuple[bool, str]:
    """Whether the axis does what was promised, and a sentence."""
    wrong = []
    rise, promised = measured["rise_ms"], predicted["rise_ms"]
    if rise is None:
        wrong.append("the step does not arrive")
    elif promised is not None and rise > NEAR_RISE * promised + NEAR_MS:
        wrong.append(f"it rises in {rise:.0f} ms instead of {promised:.0f}")
    over = measured["overshoot_pct"] - predicted["overshoot_pct"]
    if over > MORE_OVERSHOOT:
        wrong.append(f"it overshoots by {measured['overshoot_pct']:.0f} %")
    off = abs(measured["steady_error_counts"])
    if off > max(HELD_OFF, 0.02 * abs(measured["size"])):
        promised_off = abs(predicted["steady_error_counts"])
        wrong.append(f"it ends {off:.0f} counts off ({promised_off:.0f} predicted)")
    if wrong:
        return False, f"Not good enough: {', '.join(wrong)}."
    return (
        True,
        f"As designed: rise {rise:.0f} ms ({promised or 0:.0f} predicted), {off:.0f} counts off.",
    )
