# SPDX-License-Identifier: Apache-2.0
"""Sheet 5: when the D/A changes, and what the time of the host has to do with it."""

from typing import Annotated

import numpy as np
from pydantic import Field

from mmcs import Gains, Question, Strict, Verdict, arrives, near

SINGLE = "double_buffer=false"
Micro = Annotated[int, Field(ge=0, le=10_000)]
WITHIN_PCT, OWN_PCT, OWN_RISE_MS = 1.0, 3.0, 22.0


class Answer(Strict):
    double_pct: float | None = None
    single_pct: float | None = None
    same_us: Micro | None = None
    overrun_us: Annotated[int, Field(ge=20, le=10_000, multiple_of=10)] | None = None
    ring_hz: float | None = None
    gains: Gains | None = None


def over(seen) -> float:
    return seen.axes[0]["overshoot_pct"]


def single(run, us: int):
    return run("step.toml", SINGLE, f"host.cpu_us_per_axis={us}")


def double_pct(answer, run) -> Verdict:
    seen = run("step.toml")
    return near(answer.double_pct, over(seen), 0.5, "%", seen.command)


def single_pct(answer, run) -> Verdict:
    seen = run("step.toml", SINGLE)
    return near(answer.single_pct, over(seen), 0.5, "%", seen.command)


def same(answer, run) -> Verdict:
    seen = single(run, answer.same_us)
    here, there, overruns = over(seen), over(run("step.toml")), int(seen.stats["overruns"])
    told = f"overshoots by {here:.1f} %, the double-buffered one by {there:.1f} %"
    if overruns:
        return False, f"{told}, but with {overruns} overruns"
    return abs(here - there) <= WITHIN_PCT, told


def overrun(answer, run) -> Verdict:
    def overruns(us: int) -> int:
        seen = single(run, us)
        return int(seen.stats["overruns"] + seen.stats["missed"])

    us = answer.overrun_us
    if not overruns(us):
        return False, f"no overrun at {us} us"
    before = overruns(us - 20)  # one step of grace: the latency is drawn
    return not before, f"{overruns(us)} overruns at {us} us, {before} at {us - 20} us"


def ring(answer, run) -> Verdict:
    seen = run("ring.toml")
    current = seen.column("current", 0, 0.05)
    power = np.abs(np.fft.rfft(current - current.mean()))
    true = np.fft.rfftfreq(len(current), float(np.median(np.diff(seen.t))))[int(power.argmax())]
    return near(answer.ring_hz, float(true), 2, "Hz", "current_0 of ring.toml")


def own(answer, run) -> Verdict:
    return arrives(run("step.toml", *answer.gains.sets()).axes[0], OWN_PCT, OWN_RISE_MS)


QUESTIONS = (
    Question("double_pct", 1, double_pct),
    Question("single_pct", 1, single_pct),
    Question("same_us", 2, same),
    Question("overrun_us", 2, overrun),
    Question("ring_hz", 1, ring),
    Question("gains", 3, own),
)
