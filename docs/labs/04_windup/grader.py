# SPDX-License-Identifier: Apache-2.0
"""Sheet 4: an integral that goes on while the current is at its limit."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs import Gains, Question, Strict, Verdict, near

STEP, LIMIT, INTEGRAL = 1000, 400, 60.0
GLIDE_PCT, LOAD_PCT, LOAD_COUNTS = 10.0, 25.0, 6.0


class Answer(Strict):
    overshoot_pct: float | None = None
    limited_ms: float | None = None
    wound_units: float | None = None
    glide_s: Annotated[float, Field(ge=0.02, le=0.7)] | None = None
    gains: Gains | None = None


def passed_pct(seen) -> float:
    return max(0.0, 100 * (float(seen.column("encoder").max()) - STEP) / STEP)


def overshoot(answer, run) -> Verdict:
    true = run("windup.toml").axes[0]["overshoot_pct"]
    return near(answer.overshoot_pct, true, 1, "%", "mmcs run windup.toml")


def limited(answer, run) -> Verdict:
    current = np.abs(run("windup.toml").column("current"))
    how = "samples of current_0 at 400 or -400"
    return near(answer.limited_ms, float(np.sum(current >= LIMIT)), 3, "ms", how)


def wound(answer, run) -> Verdict:
    seen = run("windup.toml")
    t, error = seen.t, seen.column("error")
    end = np.flatnonzero((error <= 0) & (t > 0.03))[0]
    true = INTEGRAL * float(np.sum(error[: end + 1])) * 1e-3
    return near(
        answer.wound_units, true, 60, "D/A units", "error_0 summed until it is not positive"
    )


def glide(answer, run) -> Verdict:
    def passed(seconds: float) -> float:
        sets = ("motion.0.kind=quintic", f"motion.0.duration={seconds:.2f}")
        return passed_pct(run("windup.toml", *sets))

    here, before = passed(answer.glide_s), passed(answer.glide_s - 0.01)
    if here > GLIDE_PCT:
        return False, f"passes the goal by {here:.1f} % in {answer.glide_s:.2f} s: too short"
    if before <= GLIDE_PCT:
        return False, f"0.01 s less passes it by {before:.1f} %: there is a shorter one"
    return True, f"passes the goal by {here:.1f} %, with 0.01 s less by {before:.1f} %"


def own(answer, run) -> Verdict:
    seen = run("load.toml", *answer.gains.sets())
    over, off = passed_pct(seen), STEP - float(seen.column("encoder", 0, 0.78).mean())
    good = over <= LOAD_PCT and abs(off) <= LOAD_COUNTS
    told = f"passes the goal by {over:.1f} %, stands {off:.1f} counts off under the load"
    return good, f"{told}; at most {LOAD_PCT:g} % and {LOAD_COUNTS:g} counts"


QUESTIONS = (
    Question("overshoot_pct", 1, overshoot),
    Question("limited_ms", 1, limited),
    Question("wound_units", 2, wound),
    Question("glide_s", 3, glide),
    Question("gains", 3, own),
)
