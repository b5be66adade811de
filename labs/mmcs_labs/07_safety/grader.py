# SPDX-License-Identifier: Apache-2.0
"""Sheet 7: who notices a fault, how soon, and what the brakes do."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs import Strict, moved_deg, rest_ms
from mmcs_labs.marks import Question, Verdict, figure

FAULT = 0.1  # s of motion
JOINTS = range(6)
BRAKED_MS = 60.0
MOST_DEG = 3.5
MOST_ASTRAY = 2.0  # times the error of an unbound joint
Coasting = Annotated[list[int], Field(max_length=6)]


class Limit(Strict):
    ilim: Annotated[int, Field(ge=0, le=100_000)]
    ilimax: Annotated[int, Field(ge=0, le=100_000)]


def rest(run) -> float:
    return rest_ms(run("estop.toml").result, 0, FAULT)


def coasting(answer, run) -> Verdict:
    result = run("estop.toml").result
    true = [n for n in JOINTS if (rest_ms(result, n, FAULT) or 1e9) > BRAKED_MS]
    for n in sorted(set(answer.coasting) - set(true)):
        return False, f"axis {n} is at rest {BRAKED_MS:g} ms after the button"
    good = set(answer.coasting) == set(true)
    return good, "they coast, the others have brakes" if good else "there are more that coast"


def cable(run) -> float:
    return max(moved_deg(run("cable.toml").result, n, FAULT) for n in JOINTS)


def limit(answer, run) -> Verdict:
    sets = tuple(f"axis.0.{key}={value}" for key, value in answer.limit.model_dump().items())
    whole = run("move.toml", *sets)
    clean = whole.after("error", "", 0.0)
    if clean is not None:
        return False, f"a false alarm {clean:.0f} ms into move.toml, where nothing fails"
    wanted = np.abs(run("move.toml").column("error", 0)).max()
    astray = np.abs(whole.column("error", 0)).max() / wanted
    if astray > MOST_ASTRAY:
        why = f"joint 1 does not keep to move.toml: {astray:.0f} times the error it has there"
        return False, why
    seen = run("cut.toml", *sets)
    moved, error = moved_deg(seen.result, 0, FAULT), seen.after("error", "", FAULT)
    when = "never" if error is None else f"after {error:.0f} ms"
    why = f"the wire's cut is noticed {when}, joint 1 moves by {moved:.2f} degrees"
    return moved <= MOST_DEG, f"{why}; {MOST_DEG:g} may be"


QUESTIONS = (
    figure("stall_ms", 1, lambda run: run("stall.toml").after("panic", "high", FAULT), 0.5, "ms",
           "PANIC goes high in stall.toml"),
    figure("told_ms", 1, lambda run: run("estop.toml").after("signal", "", FAULT), 0.05, "ms",
           "SIGUSR1 in estop.toml"),
    figure("rest_ms", 1, rest, 3, "ms", "angle_rad_0 in estop.toml"),
    Question("coasting", 1, Coasting, coasting),
    figure("cable_deg", 2, cable, 2, "degrees", "the last table of `mmcs run cable.toml`"),
    Question("limit", 4, Limit, limit),
)  # fmt: skip
