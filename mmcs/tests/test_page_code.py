# SPDX-License-Identifier: Apache-2.0
"""What the pages compute by themselves, against Python: gains, by seed."""

import json
import math
import random
import sys
from pathlib import Path

import numpy as np
import pytest

from mmcs import ROOT
from mmcs.scenario.synthesis import Controller, Discrete, discretize, to_integers
from tools.compiled import ran

pytestmark = pytest.mark.req("TOOL-1", "SYN-1")


def ask(questions: list[list]) -> list[dict]:
    """What the pages' own code says to each."""
    node = Path(sys.executable).with_name("node")
    script = ROOT / "web" / "tests" / "answers.mjs"
    return json.loads(ran(node, script, input=json.dumps(questions), check=True).stdout)


def some(rng: random.Random, low: float, high: float, zero: float = 0.3) -> float:
    """Of any size between two, or nothing."""
    return 0.0 if rng.random() < zero else math.exp(rng.uniform(math.log(low), math.log(high)))


def test_gains_come_back_from_integers():
    """What a panel shows of integers has, in Python, the very response of those integers."""
    rng = random.Random(1991)
    asked, t = [], 1e-3
    for _ in range(300):
        c = Controller(some(rng, 0.1, 1e3, 0), some(rng, 1, 1e5), some(rng, 1e-3, 10), 0.0)
        if not c.i and c.d and rng.random() < 0.5:
            c = Controller(c.p, 0.0, c.d, some(rng, 1e-3, 0.1, 0))
        made = to_integers(discretize(c, "backward", t))
        asked.append({f"{k}{n}": v for k in "ab" for n, v in enumerate(getattr(made, k))})
    z = np.exp(1j * np.pi * np.geomspace(1e-3, 0.9, 20))
    for param, found in zip(asked, ask([["gainsOf", p, t] for p in asked]), strict=True):
        gains = found["value"]
        ints = Discrete(tuple(param[f"a{n}"] / param["b0"] for n in range(3)),
                        tuple(param[f"b{n}"] / param["b0"] for n in range(3)))  # fmt: skip
        again = discretize(Controller(**gains), "backward", t)
        assert np.allclose(again.at(z), ints.at(z), rtol=1e-6)
