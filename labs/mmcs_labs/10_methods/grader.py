# SPDX-License-Identifier: Apache-2.0
"""Sheet 10: one continuous law, sampled in five ways."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mmcs import Strict, load_robot, plant_of
from mmcs import synthesis as ds
from mmcs_labs.marks import Question, Verdict
from mmcs_labs.trial import Gains

T, PREWARP = 3e-3, 80.0
LAW = ds.Controller(4.4, 0.0, 0.08, 0.002)
BARE, BARE_US = ds.Controller(4.4, 0.0, 0.11), 1000
FIVE = ("backward", "bilinear", "prewarp", "matched", "zoh")
Method = Literal["backward", "bilinear", "prewarp", "matched", "ztransform", "zoh"]
Refused = Annotated[list[Method], Field(max_length=6)]
SAME_COUNTS, SAME_DEG, ALTERNATES = 2, 0.5, 0.9


class Margins(Strict):
    backward: float
    bilinear: float
    prewarp: float
    matched: float
    zoh: float


def made(law: ds.Controller, method: str, t: float) -> tuple[ds.Coefficients, Gains]:
    k = ds.to_integers(ds.discretize(law, method, t, PREWARP))
    return k, Gains(**k.named())


def margins_of(method: str) -> ds.Margins:
    plant = plant_of(load_robot("lab500")[1].axis[0])
    return ds.margins(made(LAW, method, T)[0].discrete(), plant, T)


def refused(answer, run) -> Verdict:
    def refuses(method: str) -> bool:
        try:
            ds.discretize(BARE, method, T, PREWARP)
        except ds.DesignError:
            return True
        return False

    for method in answer.refused:
        if not refuses(method):
            return False, f"{method} makes a D(z) of it"
    if len(set(answer.refused)) != sum(map(refuses, (*FIVE, "ztransform"))):
        return False, "there is another one"
    return True, "they do: a PD has no step or impulse response that could be kept"


def by_hand(method: str):
    def judge(answer, run) -> Verdict:
        mine = run("step.toml", *getattr(answer, method).sets())
        true = run("step.toml", *made(LAW, method, T)[1].sets())
        off = float(np.abs(mine.column("encoder") - true.column("encoder")).max())
        told = f"the step is up to {off:g} counts from that of exact coefficients"
        return off <= SAME_COUNTS, f"{told}; {SAME_COUNTS} may be"

    return judge


def margins(answer, run) -> Verdict:
    for method in FIVE:
        given, true = getattr(answer.margins, method), margins_of(method).phase_deg
        if abs(given - true) > SAME_DEG:
            return False, f"{method}: {given:g} is too {'high' if given > true else 'low'}"
    return True, "all five agree"


def unstable(answer, run) -> Verdict:
    if answer.unstable not in FIVE:
        return False, f"{answer.unstable} is none of the five"
    found = margins_of(answer.unstable)
    return not found.stable, f"its loop has {found.phase_deg:.1f} degrees of phase margin"


def rings(answer, run) -> Verdict:
    try:
        gains = made(BARE, answer.rings, BARE_US * 1e-6)[1]
    except ds.DesignError as error:
        return False, str(error)
    seen = run("step.toml", f"interval_us={BARE_US}", *gains.sets())
    way = np.sign(seen.column("current", 0, 0.05))
    share = float(np.mean(way[1:] * way[:-1] < 0))
    return share >= ALTERNATES, f"its current changes sign at {100 * share:.0f} % of the samples"


QUESTIONS = (
    Question("refused", 1, Refused, refused),
    Question("bilinear", 2, Gains, by_hand("bilinear")),
    Question("matched", 2, Gains, by_hand("matched")),
    Question("margins", 2, Margins, margins),
    Question("unstable", 1, Method, unstable),
    Question("rings", 2, Method, rings),
)
