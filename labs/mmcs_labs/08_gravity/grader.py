# SPDX-License-Identifier: Apache-2.0
"""Sheet 8: an arm's weight, and what its joints do to each other."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs_labs.marks import Question, Verdict, edge, figure
from mmcs_labs.trial import Gains

JOINT2, JOINT3 = 1, 2
UP = (0.12, 0.3)
MOST_ERROR, MOST_OFF, MOST_PCT = 60.0, 2.0, 25.0
Slow = Annotated[float, Field(ge=0.1, le=0.85)]


def off(seen) -> float:
    return seen.axes[JOINT2]["steady_error_counts"]


def weight(run) -> float:
    """In D/A units."""
    heavy, weightless = (
        float(np.mean(run("updown.toml", *sets).column("current", JOINT2, *UP)))
        for sets in ((), ("gravity=false",))
    )
    return heavy - weightless


def torque(run) -> float:
    motor = run("hold.toml").result.setup.robot.axis[JOINT2]
    return weight(run) * 10 / 2048 * motor.amp_gain * motor.km * abs(motor.gear)


def give(run) -> float:
    return float(np.abs(run("move.toml").column("encoder", JOINT3)).max())


def error(run, seconds: float) -> float:
    seen = run("move.toml", f"motion.0.duration={seconds:.2f}")
    return float(np.abs(seen.column("error", JOINT2)).max())


def own(answer, run) -> Verdict:
    sets = answer.gains.sets(JOINT2)
    low, seen = off(run("hold.toml", *sets)), run("step.toml", *sets)
    pct = seen.axes[JOINT2]["overshoot_pct"]
    told = f"{low:.1f} counts off in hold.toml, overshoot {pct:.1f} % in step.toml"
    good = abs(low) <= MOST_OFF and pct <= MOST_PCT
    return good, f"{told}; at most {MOST_OFF:g} counts and {MOST_PCT:g} %"


QUESTIONS = (
    figure("sag_counts", 1, lambda run: off(run("hold.toml")), 0.5, "counts",
           "the table of hold.toml"),
    figure("gravity_units", 2, weight, 8, "D/A units",
           "current_1 going up, less the same without gravity"),
    figure("gravity_nm", 1, torque, 1, "N m", "D/A units to volts, amperes, torque, gear"),
    figure("give_counts", 1, give, 0.5, "counts", "encoder_2 in move.toml"),
    edge("slow_s", 2, Slow, error, MOST_ERROR, -0.05, "an error of {:.0f} counts in {:.2f} s",
         "short"),
    Question("gains", 3, Gains, own),
)  # fmt: skip
