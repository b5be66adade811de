# SPDX-License-Identifier: Apache-2.0
"""Sheet 4: an integral that goes on while the current is at its limit."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs_labs.marks import Question, Verdict, edge, figure
from mmcs_labs.trial import Gains

STEP, LIMIT, INTEGRAL = 1000, 400, 60.0
GLIDE_PCT, LOAD_PCT, LOAD_COUNTS = 10.0, 25.0, 6.0
Glide = Annotated[float, Field(ge=0.02, le=0.7)]


def passed_pct(seen) -> float:
    return max(0.0, 100 * (float(seen.column("encoder").max()) - STEP) / STEP)


def overshoot(run) -> float:
    return run("windup.toml").axes[0]["overshoot_pct"]


def limited(run) -> float:
    return float(np.sum(np.abs(run("windup.toml").column("current")) >= LIMIT))


def wound(run) -> float:
    seen = run("windup.toml")
    error = seen.column("error")
    end = np.flatnonzero((error <= 0) & (seen.t > 0.03))[0]
    return INTEGRAL * float(np.sum(error[: end + 1])) * 1e-3


def glide(run, seconds: float) -> float:
    sets = ("motion.0.kind=quintic", f"motion.0.duration={seconds:.2f}")
    return passed_pct(run("windup.toml", *sets))


def own(answer, run) -> Verdict:
    seen = run("load.toml", *answer.gains.sets())
    over, off = passed_pct(seen), STEP - float(seen.column("encoder", 0, 0.78).mean())
    good = over <= LOAD_PCT and abs(off) <= LOAD_COUNTS
    told = f"passes the goal by {over:.1f} %, stands {off:.1f} counts off under the load"
    return good, f"{told}; at most {LOAD_PCT:g} % and {LOAD_COUNTS:g} counts"


QUESTIONS = (
    figure("overshoot_pct", 1, overshoot, 1, "%", "mmcs run windup.toml"),
    figure("limited_ms", 1, limited, 3, "ms", "samples of current_0 at 400 or -400"),
    figure("wound_units", 2, wound, 60, "D/A units", "error_0 summed until it is not positive"),
    edge("glide_s", 3, Glide, glide, GLIDE_PCT, -0.01, "passes the goal by {:.1f} % in {:.2f} s",
         "short"),
    Question("gains", 3, Gains, own),
)  # fmt: skip
