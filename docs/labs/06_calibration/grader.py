# SPDX-License-Identifier: Apache-2.0
"""Sheet 6: where an arm is, by index and potentiometer."""

import math
from typing import Annotated

from pydantic import Field

from mmcs import Question, Strict, Verdict, calibrate, index_counts, near

JOINTS = range(6)
PAST = 2  # counts beyond a mark: the next one is as far away as can be
MOST_TO = 1080


class Answer(Strict):
    index_count: int | None = None
    absolute: int | None = None
    units_per_rev: float | None = None
    cut_error: int | None = None
    to: Annotated[int, Field(ge=1, le=5000)] | None = None


def index_count(answer, run) -> Verdict:
    true = index_counts(run("calibrate.toml").result, 0)[0]
    return near(answer.index_count, true, 0, "counts", "the upper half of axis 0's errcode")


def absolute(answer, run) -> Verdict:
    (found,), _ = calibrate(run("calibrate.toml").result, 0)
    how = "the mark's absolute count, less the count at the index"
    return near(answer.absolute, found, 0, "counts", how)


def pose(degrees: float) -> str:
    return f"pose_deg=[{degrees}, 40.0, -170.0, 20.0, 40.0, -30.0]"


def units_per_rev(answer, run) -> Verdict:
    """Two poses, 80 degrees apart."""
    codes = [run("calibrate.toml", pose(d)).result.pots[0][0] for d in (-40.0, 40.0)]
    robot = run("calibrate.toml").result.setup.robot
    turned = math.radians(80.0) * abs(robot.counts_per_rad(0)) / robot.axis[0].counts_per_rev
    true = abs(codes[1] - codes[0]) / turned
    return near(answer.units_per_rev, true, 0.5, "A/D units", "the codes in two poses")


def cut_error(answer, run) -> Verdict:
    (found,), true = calibrate(run("cut.toml").result, 0)
    return near(answer.cut_error, found - true, 0, "counts", "mmcs run cut.toml")


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
    Question("index_count", 1, index_count),
    Question("absolute", 2, absolute),
    Question("units_per_rev", 2, units_per_rev),
    Question("cut_error", 2, cut_error),
    Question("to", 3, far_enough),
)
