# SPDX-License-Identifier: Apache-2.0
"""Sheet 8: an arm's weight, and what its joints do to each other."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs import Gains, Question, Strict, Verdict, near

JOINT2, JOINT3 = 1, 2
UP = (0.12, 0.3)
MOST_ERROR, MOST_OFF, MOST_PCT = 60.0, 2.0, 25.0


class Answer(Strict):
    sag_counts: float | None = None
    gravity_units: float | None = None
    gravity_nm: float | None = None
    give_counts: float | None = None
    slow_s: Annotated[float, Field(ge=0.1, le=0.85)] | None = None
    gains: Gains | None = None


def off(seen) -> float:
    return seen.axes[JOINT2]["steady_error_counts"]


def sag(answer, run) -> Verdict:
    return near(answer.sag_counts, off(run("hold.toml")), 0.5, "counts", "the table of hold.toml")


def weight(run) -> float:
    """In D/A units."""
    heavy, weightless = (
        float(np.mean(run("updown.toml", *sets).column("current", JOINT2, *UP)))
        for sets in ((), ("gravity=false",))
    )
    return heavy - weightless


def units(answer, run) -> Verdict:
    how = "current_1 going up, less the same without gravity"
    return near(answer.gravity_units, weight(run), 8, "D/A units", how)


def torque(answer, run) -> Verdict:
    motor = run("hold.toml").result.setup.robot.axis[JOINT2]
    true = weight(run) * 10 / 2048 * motor.amp_gain * motor.km * abs(motor.gear)
    return near(answer.gravity_nm, true, 1, "N m", "D/A units to volts, amperes, torque, gear")


def give(answer, run) -> Verdict:
    true = float(np.abs(run("move.toml").column("encoder", JOINT3)).max())
    return near(answer.give_counts, true, 0.5, "counts", "encoder_2 in move.toml")


def slow(answer, run) -> Verdict:
    def error(seconds: float) -> float:
        seen = run("move.toml", f"motion.0.duration={seconds:.2f}")
        return float(np.abs(seen.column("error", JOINT2)).max())

    here, before = error(answer.slow_s), error(answer.slow_s - 0.05)
    if here > MOST_ERROR:
        return False, f"an error of {here:.0f} counts in {answer.slow_s:.2f} s: too short"
    if before <= MOST_ERROR:
        return (
            False,
            f"an error of only {before:.0f} counts with 0.05 s less: there is a shorter one",
        )
    return True, f"an error of {here:.0f} counts, with 0.05 s less of {before:.0f}"


def own(answer, run) -> Verdict:
    sets = answer.gains.sets(JOINT2)
    low, seen = off(run("hold.toml", *sets)), run("step.toml", *sets)
    pct = seen.axes[JOINT2]["overshoot_pct"]
    told = f"{low:.1f} counts off in hold.toml, overshoot {pct:.1f} % in step.toml"
    good = abs(low) <= MOST_OFF and pct <= MOST_PCT
    return good, f"{told}; at most {MOST_OFF:g} counts and {MOST_PCT:g} %"


QUESTIONS = (
    Question("sag_counts", 1, sag),
    Question("gravity_units", 2, units),
    Question("gravity_nm", 1, torque),
    Question("give_counts", 1, give),
    Question("slow_s", 2, slow),
    Question("gains", 3, own),
)
