# SPDX-License-Identifier: Apache-2.0
"""Sheet 3: dry friction measured, compensated, and fought by an integral."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs_labs.marks import Question, Verdict, figure

Units = Annotated[int, Field(ge=0, le=2047)]
NEAR_GOAL, AT_REST = 3, 1  # counts


def stuck(run) -> float:
    return 200 - run("step.toml").column("encoder", 0, 0.2, 0.25)[-1]


def breakaway(answer, run) -> Verdict:
    def moved(units: int) -> float:
        return run("torque.toml", f"motion.0.to={units}").column("encoder")[-1]

    if moved(answer.breakaway) == 0:
        return False, f"at {answer.breakaway} the motor stays where it is"
    less = max(0, answer.breakaway - 4)
    if moved(less) != 0:
        return False, f"at {less} it moves already"
    return True, f"at {answer.breakaway} it moves, at {less} it does not"


def coulomb(run) -> float:
    found = []
    for units in (200, 300):
        seen = run("torque.toml", f"motion.0.to={units}")
        t = seen.t[seen.t >= 0.04]
        found.append(2 * np.polyfit(t, seen.column("encoder", 0, 0.04), 2)[0])
    return 200 - found[0] * 100 / (found[1] - found[0])


def compensation(answer, run) -> Verdict:
    ic = answer.ic
    for robot, name in (("lab500", "cold"), ("./warm.toml", "warm")):
        sets = (f"robot={robot}", 'axis.0.flags=["coulcomp"]')
        seen = run("step.toml", *sets, f"axis.0.ic_pos={ic}", f"axis.0.ic_neg={ic}")
        for goal, after, until in ((200, 0.18, 0.25), (0, 0.42, 0.5)):
            y = seen.column("encoder", 0, after, until)
            if np.ptp(y) > AT_REST:
                return False, f"the {name} motor hunts over {np.ptp(y):g} counts at {goal}: less"
            if abs(y[-1] - goal) > NEAR_GOAL:
                return False, f"the {name} motor stops {abs(y[-1] - goal):g} counts off {goal}"
    return True, "both motors stop within 3 counts of both goals, and rest"


def hunt(run) -> float:
    return float(np.ptp(run("integral.toml").column("encoder", 0, 1.0)))


QUESTIONS = (
    figure("stuck_counts", 1, stuck, 1, "counts", "encoder_0 before it steps back"),
    Question("breakaway", 2, Units, breakaway),
    figure("coulomb", 2, coulomb, 5, "D/A units",
           "accelerations at 200 and 300 D/A units, parabolas through encoder_0"),
    Question("ic", 3, Units, compensation),
    figure("hunt_counts", 2, hunt, 1, "counts", "encoder_0 from 1 s to 2 s"),
)  # fmt: skip
