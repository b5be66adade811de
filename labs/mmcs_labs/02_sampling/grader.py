# SPDX-License-Identifier: Apache-2.0
"""Sheet 2: what a longer servo interval does to the phase."""

import math
from typing import Annotated

from pydantic import Field

from mmcs import Controller, discretize, load_robot, margins, plant_of, to_integers
from mmcs_labs.marks import Question, Verdict, arrives, edge, figure
from mmcs_labs.trial import Gains

LAW = Controller(4.4, 0.0, 0.11)
MOST_PCT = 30.0
OWN_US, OWN_PCT, OWN_RISE_MS = 4000, 10.0, 30.0
Interval = Annotated[int, Field(ge=500, le=20_000, multiple_of=500)]


def integers(interval_us: int):
    return to_integers(discretize(LAW, "backward", interval_us * 1e-6))


def margin(interval_us: int):
    plant = plant_of(load_robot("lab500")[1].axis[0])
    return margins(integers(interval_us).discrete(), plant, interval_us * 1e-6)


def delay(run) -> float:
    one, three = margin(1000), margin(3000)
    return math.radians(one.phase_deg - three.phase_deg) / one.crossover / 2 * 1e3


def overshoot(run, interval_us: int) -> float:
    gains = Gains(**integers(interval_us).named())
    seen = run("step.toml", f"interval_us={interval_us}", *gains.sets())
    return seen.axes[0]["overshoot_pct"]


def own(answer, run) -> Verdict:
    seen = run("step.toml", f"interval_us={OWN_US}", *answer.gains.sets())
    good, told = arrives(seen.axes[0], OWN_PCT, OWN_RISE_MS)
    return good, f"{told}: {seen.command}"


QUESTIONS = (
    figure("margin_1000", 1, lambda run: margin(1000).phase_deg, 1, "degrees",
           "mmcs design, 1000 us"),
    figure("margin_3000", 1, lambda run: margin(3000).phase_deg, 1, "degrees",
           "mmcs design, 3000 us"),
    figure("delay_ms", 2, delay, 0.1, "ms for each ms",
           "the phase lost, in radians, by the crossover in rad/s, by the 2 ms between"),
    edge("last_us", 3, Interval, overshoot, MOST_PCT, 500, "overshoots by {:.1f} % at {} us",
         "long"),
    Question("gains", 3, Gains, own),
)  # fmt: skip
