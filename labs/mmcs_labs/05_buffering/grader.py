# SPDX-License-Identifier: Apache-2.0
"""Sheet 5: when the D/A changes, and what the time of the host has to do with it."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs_labs.marks import Question, Verdict, arrives, figure
from mmcs_labs.trial import Gains

SINGLE = "double_buffer=false"
Micro = Annotated[int, Field(ge=0, le=10_000)]
Overrun = Annotated[int, Field(ge=20, le=10_000, multiple_of=10)]
WITHIN_PCT, OWN_PCT, OWN_RISE_MS = 1.0, 3.0, 22.0


def over(run, *sets: str) -> float:
    return run("step.toml", *sets).axes[0]["overshoot_pct"]


def cpu(us: int) -> tuple[str, str]:
    return SINGLE, f"host.cpu_us_per_axis={us}"


def same(answer, run) -> Verdict:
    sets = cpu(answer.same_us)
    here, there, overruns = over(run, *sets), over(run), run("step.toml", *sets).stats["overruns"]
    told = f"overshoots by {here:.1f} %, the double-buffered one by {there:.1f} %"
    if overruns:
        return False, f"{told}, but with {overruns} overruns"
    return abs(here - there) <= WITHIN_PCT, told


def overrun(answer, run) -> Verdict:
    def overruns(us: int) -> int:
        stats = run("step.toml", *cpu(us)).stats
        return int(stats["overruns"] + stats["missed"])

    us = answer.overrun_us
    if not overruns(us):
        return False, f"no overrun at {us} us"
    before = overruns(us - 20)  # one step of grace: the latency is drawn
    return not before, f"{overruns(us)} overruns at {us} us, {before} at {us - 20} us"


def ring(run) -> float:
    seen = run("ring.toml")
    current = seen.column("current", 0, 0.05)
    power = np.abs(np.fft.rfft(current - current.mean()))
    step = float(np.median(np.diff(seen.t)))
    return float(np.fft.rfftfreq(len(current), step)[int(power.argmax())])


def own(answer, run) -> Verdict:
    return arrives(run("step.toml", *answer.gains.sets()).axes[0], OWN_PCT, OWN_RISE_MS)


QUESTIONS = (
    figure("double_pct", 1, over, 0.5, "%", "mmcs run step.toml"),
    figure("single_pct", 1, lambda run: over(run, SINGLE), 0.5, "%",
           f"mmcs run step.toml --set {SINGLE}"),
    Question("same_us", 2, Micro, same),
    Question("overrun_us", 2, Overrun, overrun),
    figure("ring_hz", 1, ring, 2, "Hz", "current_0 of ring.toml"),
    Question("gains", 3, Gains, own),
)  # fmt: skip
