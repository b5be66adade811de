# SPDX-License-Identifier: Apache-2.0
"""Sheet 9: a motor found from a recording, proved on another motion, and servoed."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs import plant_of
from mmcs_labs.marks import Question, Verdict, figure, near
from mmcs_labs.trial import Gains

PROOF = ("motion.0.amplitude=420", "motion.0.hz=4")
MOST_OFF = 0.03  # of the travel
RISE_MS, OVER_PCT, OFF_COUNTS = 40.0, 3.0, 8.0
STEPS = 20  # of the model in a sample


class Servo(Gains):
    ic_pos: int = 0
    ic_neg: int = 0


Acceleration = Annotated[float, Field(gt=0, le=1e6)]
Units = Annotated[float, Field(ge=0, le=2047)]
Lag = Annotated[float, Field(ge=0, le=1000)]


def motor(run):
    return run("excite.toml").result.setup.robot.axis[0]


def units(run, torque: float) -> float:
    """A torque in D/A units."""
    found = motor(run)
    return torque / (found.km * found.amp_gain * 10 / 2048)


def g(answer, run) -> Verdict:
    true = plant_of(motor(run)).g
    return near(answer.g, true, round(0.03 * true), "counts/s^2", "accelerations at two currents")


def model(answer, t: np.ndarray, current: np.ndarray) -> np.ndarray:
    """The counts that the four numbers make of a current; it acts from the next sample on."""
    y, v, out = 0.0, 0.0, [0.0]
    for dt, u in zip(np.diff(t), np.concatenate([[0.0], current[:-2]]), strict=True):
        h = dt / STEPS
        for _ in range(STEPS):
            push = v + h * (answer.g * u - answer.lag * v)
            slow, fast = h * answer.g * answer.tc_pos, h * answer.g * answer.tc_neg
            v = push - slow if push > slow else push + fast if push < -fast else 0.0
            y += h * v
        out.append(y)
    return np.array(out)


def proof(answer, run) -> Verdict:
    if None in (answer.g, answer.tc_pos, answer.tc_neg):
        return False, "needs g, tc_pos and tc_neg"
    seen = run("excite.toml", *PROOF)
    y = seen.column("encoder")
    off = np.abs(model(answer, seen.t, seen.column("current")) - y).max() / np.ptp(y)
    told = f"your motor is up to {100 * off:.1f} % of the travel away from the real one"
    return bool(off <= MOST_OFF), f"{told}; {100 * MOST_OFF:g} % may be"


def servo(answer, run) -> Verdict:
    seen = run("step.toml", *answer.servo.sets())
    figures = seen.axes[0]
    rise, over, off = (figures[k] for k in ("rise_ms", "overshoot_pct", "steady_error_counts"))
    rests = np.ptp(seen.column("encoder", 0, 0.25)) <= 1
    good = rise is not None and rise <= RISE_MS and over <= OVER_PCT
    told = f"rise {'never' if rise is None else f'{rise:.1f} ms'}, overshoot {over:.1f} %"
    told += f", {off:.1f} counts off" + ("" if rests else ", not at rest")
    return bool(good and rests and abs(off) <= OFF_COUNTS), told


QUESTIONS = (
    Question("g", 2, Acceleration, g),
    figure("tc_pos", 1, lambda run: units(run, motor(run).coulomb_pos), 8, "D/A units",
           "where the acceleration would be 0, forwards", Units),
    figure("tc_neg", 1, lambda run: units(run, motor(run).coulomb_neg), 8, "D/A units",
           "where the acceleration would be 0, backwards", Units),
    Question("lag", 2, Lag, proof),
    Question("servo", 4, Servo, servo),
)  # fmt: skip
