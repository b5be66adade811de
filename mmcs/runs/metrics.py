# SPDX-License-Identifier: Apache-2.0
"""The step response of an axis in four numbers, defined in docs/use/scenarios.md.

Everything is taken at servo samples, from the driver's own state: `y` is the encoder count of a
position axis and the velocity estimate of a velocity axis.
"""

from dataclasses import dataclass

import numpy as np

SETTLE_SHARE = 0.02  # of the demand ...
SETTLE_COUNTS = 2.0  # ... but at least this many counts
STEADY_SECONDS = 0.02  # the steady error is the mean over the last 20 ms


@dataclass(frozen=True)
class Response:
    rise_ms: float | None = None
    overshoot_pct: float | None = None
    settle_ms: float | None = None
    steady_error_counts: float | None = None


def step_response(
    t: np.ndarray, y: np.ndarray, start: float, before: float, target: float
) -> Response:
    """The response to a step of the setpoint at time `start` from `before` to `target`.

    t and y end with the window. The rise counts from where y was at the last sample before
    `start`. None where the response never gets there.
    """
    inside = t >= start - 1e-9
    if not inside.any():
        return Response()
    first = int(np.argmax(inside))
    y0 = float(y[max(first - 1, 0)])
    t, y = t[first:] - start, y[first:]
    steady = steady_error(t, np.full_like(y, target), y)
    size = target - before
    if size == 0:
        return Response(steady_error_counts=steady)
    part = (y - y0) / size  # an axis that friction or gravity holds off starts at 0 all the same
    low, high = _crossing(t, part, 0.1), _crossing(t, part, 0.9)
    rise = None if low is None or high is None else (high - low) * 1e3
    band = max(SETTLE_SHARE * abs(size), SETTLE_COUNTS)
    outside = np.flatnonzero(np.abs(target - y) > band)
    if len(outside) == 0:
        settle = 0.0
    elif outside[-1] + 1 < len(y):
        settle = float(t[outside[-1] + 1]) * 1e3
    else:
        settle = None
    return Response(
        rise_ms=_rounded(rise),
        overshoot_pct=_rounded(max(0.0, float(((y - target) / size).max()) * 100)),
        settle_ms=_rounded(settle),
        steady_error_counts=steady,
    )


def steady_error(t: np.ndarray, setpoint: np.ndarray, y: np.ndarray) -> float | None:
    """Setpoint minus y, mean over the last 20 ms: positive when the axis stopped short."""
    if len(t) == 0:
        return None
    tail = t > t[-1] - STEADY_SECONDS + 1e-9
    return _rounded(float(np.mean(setpoint[tail] - y[tail])))


def _crossing(t: np.ndarray, part: np.ndarray, level: float) -> float | None:
    """When `part` first reaches the level, linear between samples."""
    above = np.flatnonzero(part >= level)
    if len(above) == 0:
        return None
    k = int(above[0])
    if k == 0:
        return float(t[0])
    share = (level - part[k - 1]) / (part[k] - part[k - 1])
    return float(t[k - 1] + share * (t[k] - t[k - 1]))


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
