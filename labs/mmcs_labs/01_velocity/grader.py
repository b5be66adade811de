# SPDX-License-Identifier: Apache-2.0
"""Sheet 1: what the rounding of an encoder does to a velocity."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs_labs.marks import Question, Verdict, figure, near

STEADY = (0.1, 0.27)
SLOW = "motion.0.to=65"
MOST_RMS, MOST_LAG_MS = 100.0, 5.0
MOST_MISFIT = 0.5  # of the speed's own square
COUNTS_PER_RAD = 2000 / (2 * np.pi)
Share = Annotated[float, Field(ge=0, le=1)]
Weight = Annotated[float, Field(ge=-1e6, le=1e6)]
Weights = Annotated[list[Weight], Field(min_length=2, max_length=16)]


def unit(run) -> float:
    seen = run("speed.toml")
    step = np.diff(np.unique(seen.column("velocity"))).min()
    return step * 1e6 / seen.result.setup.scenario.interval_us


def zero_share(run) -> float:
    return float(np.mean(run("speed.toml", SLOW).column("velocity", 0, *STEADY) == 0))


def mean(run) -> float:
    return 1000 * float(np.mean(run("speed.toml").column("velocity", 0, *STEADY)))


def estimate(weights: list[float], seen) -> np.ndarray:
    """Of every sample, counts/s; those before the first are as the first."""
    y = np.concatenate([np.zeros(len(weights) - 1), seen.column("encoder")])
    return np.convolve(y, weights, "valid")


def own(answer, run) -> Verdict:
    for to in (650, 858):
        seen = run("speed.toml", f"motion.0.to={to}")
        steady = (seen.t >= STEADY[0]) & (seen.t < STEADY[1])
        error = estimate(answer.weights, seen)[steady] - to / 0.26
        rms = float(np.sqrt(np.mean(error**2)))
        if not rms <= MOST_RMS:
            return False, f"wrong by {rms:.0f} counts/s rms at {to / 0.26:.0f} counts/s; 100 may be"
    lag = true_lag(answer, run)
    if lag is None:
        return False, "no estimate of the speed of swing.toml, whatever its lag"
    if lag > MOST_LAG_MS:
        return False, f"{lag:.2f} ms old; 5 ms may be: fewer weights"
    return True, f"wrong by no more than 100 counts/s rms, and {lag:.2f} ms old"


def true_lag(answer, run) -> float | None:
    """None: it is no estimate of that speed, however old."""
    seen = run("swing.toml")
    speed, made = seen.true_speed() * COUNTS_PER_RAD, estimate(answer.weights, seen)
    inside = (seen.t > 0.1) & (seen.t < 0.45)

    def misfit(ms: float) -> float:
        then = np.interp(seen.t[inside] - ms / 1e3, seen.t, speed)
        return float(np.sum((made[inside] - then) ** 2))

    best = float(min(np.arange(0, 16.01, 0.05), key=misfit))
    return best if misfit(best) < MOST_MISFIT * float(np.sum(speed[inside] ** 2)) else None


def lag(answer, run) -> Verdict:
    if answer.weights is None:
        return False, "needs your weights"
    true = true_lag(answer, run)
    if true is None:
        return False, "your weights estimate no speed: none fits that of swing.toml"
    how = "where your estimate of swing.toml fits the true speed best"
    return near(answer.lag_ms, true, 0.25, "ms", how)


QUESTIONS = (
    figure("unit_cps", 1, unit, 0.5, "counts/s",
           "the least step between two values of velocity_0, by the samples of a second"),
    figure("zero_share", 1, zero_share, 0.03, "of the samples",
           f"mmcs run speed.toml --set {SLOW}", Share),
    figure("mean_cps", 2, mean, 60, "counts/s", "the mean of velocity_0, times 1000"),
    Question("weights", 4, Weights, own),
    Question("lag_ms", 2, float, lag),
)  # fmt: skip
