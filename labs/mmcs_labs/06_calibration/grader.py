# SPDX-License-Identifier: Apache-2.0
"""Sheet 6: where an arm is, by index and potentiometer."""

import math
from typing import Annotated

from pydantic import Field

from mmcs import calibrate, index_counts
from mmcs_labs.marks import Question, Verdict, figure

JOINTS = range(6)
PAST = 2  # counts beyond a mark: the next one is as far away as can be
MOST_TO = 1080
To = Annotated[int, Field(ge=1, le=5000)]


def index_count(run) -> int:
    return index_counts(run("calibrate.toml").result, 0)[0]


def absolute(run) -> int:
    (found,), _ = calibrate(run("calibrate.toml").result, 0)
    return found


def pose(degrees: float) -> str:
    return f"pose_deg=[{degrees}, 40.0, -170.0, 20.0, 40.0, -30.0]"


def units_per_rev(run) -> float:
    """Two poses, 80 degrees apart."""
    codes = [run("calibrate.toml", pose(d)).result.pots[0][0] for d in (-40.0, 40.0)]
    robot = run("calibrate.toml").result.setup.robot
    turned = math.radians(80.0) * abs(robot.counts_per_rad(0)) / robot.axis[0].counts_per_rev
    return abs(codes[1] - codes[0]) / turned


def cut_error(run) -> int:
    (found,), true = calibrate(run("cut.toml").result, 0)
    return found - true


def far_enough(answer, run) -> Verdict:
    if answer.to > MOST_TO:
        return False, f"{answer.to} counts are more than {MOST_TO}"
    setup = run("calibrate.toml").result.setup
    degrees = []
    for n, about in zip(JOINTS, setup.scenario.pose_deg, strict=True):
        per_rad, per_rev = setup.robot.counts_per_rad(n), setup.robot.axis[n].counts_per_rev
        mark = round(math.radians(about) * per_rad / per_rev) * per_rev
        degrees.append(math.degrees((mark + PAST) / per_rad))
    result = run("calibrate.toml", f"motion.0.to={answer.to}", f"pose_deg={degrees}").result
    for n in JOINTS:
        done = calibrate(result, n)
        if done is None:
            return False, f"joint {n + 1} finds no index: it began just past one"
        if any(found != done[1] for found in done[0]):
            return False, f"joint {n + 1} is calibrated wrongly"
    return True, "every joint finds its index, though it began just past one"


QUESTIONS = (
    figure("index_count", 1, index_count, 0, "counts", "the upper half of axis 0's errcode", int),
    figure("absolute", 2, absolute, 0, "counts",
           "the mark's absolute count, less the count at the index", int),
    figure("units_per_rev", 2, units_per_rev, 0.5, "A/D units", "the codes in two poses"),
    figure("cut_error", 2, cut_error, 0, "counts", "mmcs run cut.toml", int),
    Question("to", 3, To, far_enough),
)  # fmt: skip
