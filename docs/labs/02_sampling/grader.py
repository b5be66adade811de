# SPDX-License-Identifier: Apache-2.0
"""Sheet 2: what a longer servo interval does to the phase."""

import math
from typing import Annotated

from pydantic import Field

from mmcs import (
    Controller,
    Gains,
    Question,
    Strict,
    Verdict,
    arrives,
    discretize,
    load_robot,
    margins,
    near,
    plant_of,
    to_integers,
)

LAW = Controller(4.4, 0.0, 0.11)
MOST_PCT = 30.0
OWN_US, OWN_PCT, OWN_RISE_MS = 4000, 10.0, 30.0


class Answer(Strict):
    margin_1000: float | None = None
    margin_3000: float | None = None
    delay_ms: float | None = None
    last_us: Annotated[int, Field(ge=500, le=20_000, multiple_of=500)] | None = None
    gains: Gains | None = None


def integers(interval_us: int):
    t = interval_us * 1e-6
    return to_integers(discretize(LAW, "backward", t))


def margin(interval_us: int):
    plant = plant_of(load_robot("lab500")[1].axis[0])
    return margins(integers(interval_us).discrete(), plant, interval_us * 1e-6)


def margin_1000(answer, run) -> Verdict:
    return near(answer.margin_1000, margin(1000).phase_deg, 1, "degrees", "mmcs design, 1000 us")


def margin_3000(answer, run) -> Verdict:
    return near(answer.margin_3000, margin(3000).phase_deg, 1, "degrees", "mmcs design, 3000 us")


def delay(answer, run) -> Verdict:
    one, three = margin(1000), margin(3000)
    true = math.radians(one.phase_deg - three.phase_deg) / one.crossover / 2 * 1e3
    how = "the phase lost, in radians, by the crossover in rad/s, by the 2 ms between"
    return near(answer.delay_ms, true, 0.1, "ms for each ms", how)


def overshoot(run, interval_us: int) -> tuple[float, str]:
    k = integers(interval_us)
    gains = Gains(**{f"{x}{n}": v for x, row in (("a", k.a), ("b", k.b))
                     for n, v in enumerate(row)})  # fmt: skip
    seen = run("step.toml", f"interval_us={interval_us}", *gains.sets())
    return seen.axes[0]["overshoot_pct"], f"overshoots by {{:.1f}} % at {interval_us} us"


def last(answer, run) -> Verdict:
    here, text = overshoot(run, answer.last_us)
    if here > MOST_PCT:
        return False, f"{text.format(here)}: too long"
    beyond, further = overshoot(run, answer.last_us + 500)
    if beyond <= MOST_PCT:
        return False, f"{further.format(beyond)}: there is a longer one"
    return True, f"{text.format(here)}, {further.format(beyond)}"


def own(answer, run) -> Verdict:
    seen = run("step.toml", f"interval_us={OWN_US}", *answer.gains.sets())
    good, told = arrives(seen.axes[0], OWN_PCT, OWN_RISE_MS)
    return good, f"{told}: {seen.command}"


QUESTIONS = (
    Question("margin_1000", 1, margin_1000),
    Question("margin_3000", 1, margin_3000),
    Question("delay_ms", 2, delay),
    Question("last_us", 3, last),
    Question("gains", 3, own),
)
