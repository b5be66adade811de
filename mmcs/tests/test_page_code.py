# SPDX-License-Identifier: Apache-2.0
"""What the pages compute by themselves, against Python: formulas, gains, nets, by seed."""

import bisect
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
NAMES = ("r", "y", "v", "e", "i", "t", "u")


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


def formula(rng: random.Random, depth: int, leaves, functions=()) -> str:
    """A text that the pages and, with ** for ^, Python understand alike."""
    if depth == 0 or rng.random() < 0.15:
        return rng.choice([*leaves, f"{rng.uniform(0.1, 9):.3g}", str(rng.randint(1, 9))])

    def part() -> str:
        return formula(rng, depth - 1, leaves, functions)

    kind = rng.choice(["+", "-", "*", "/", "()", "neg", "^", *functions])
    if kind in "+-*/":
        return f"{part()} {kind} {part()}"
    if kind == "()":
        return f"({part()})"
    if kind == "neg":
        return f"-{part()}"
    if kind == "^":
        return (
            f"({part()})^{rng.randint(1, 2)}" if rng.random() < 0.5 else f"{rng.choice(leaves)}^2"
        )
    return (
        f"{kind}({', '.join(part() for _ in range({'min': 2, 'max': 2, 'clamp': 3}.get(kind, 1)))})"
    )


def value(text: str, names: dict):
    return eval(text.replace("^", "**"), {"__builtins__": {}}, names)  # our own texts only


def test_a_transfer_function_as_typed_is_the_one_that_python_reads():
    rng = random.Random(1992)
    texts = [formula(rng, rng.randint(1, 3), ("z", "q", "T")) for _ in range(600)]
    texts += ["-z^-2", "2 - -q^2", "0/(z-1)", "z-z", "-(1-q)^2"]
    points = [0.7 + 0.9j, -1.3 + 0.4j, 2.1 - 0.8j]
    kinds = {"value": 0, "early": 0, "nothing": 0}
    for text, found in zip(texts, ask([["transfer", t, 1e-3] for t in texts]), strict=True):
        try:
            own = [value(text, {"z": z, "q": 1 / z, "T": 1e-3}) for z in (*points, 1e9, 1e12)]
        except (ZeroDivisionError, OverflowError):
            own = None
        if "error" in found:
            early = "not come yet" in found["error"]
            assert early or "divides by nothing" in found["error"], (text, found)
            if early and own:
                assert abs(own[4]) > 100 * abs(own[3]), text
            kinds["early" if early else "nothing"] += 1
            continue
        d = Discrete(tuple(found["value"]["num"]), tuple(found["value"]["den"]))
        for z, expected in zip(points, own or (), strict=False):
            size = max(abs(expected), np.abs(d.num).max() * 1e-3, 1e-3)
            assert d.at(np.array([z]))[0] == pytest.approx(expected, abs=1e-6 * size), text
        kinds["value"] += 1
    assert kinds["value"] > 250 and kinds["early"] > 50, kinds


def test_a_law_computes_what_python_computes():
    rng = random.Random(1993)
    functions = {
        "abs": abs, "sign": lambda x: (x > 0) - (x < 0), "sqrt": lambda x: math.sqrt(max(0, x)),
        "sin": math.sin, "cos": math.cos, "min": min, "max": max,
        "clamp": lambda x, low, high: min(max(x, low), high),
    }  # fmt: skip
    asked = [
        (formula(rng, rng.randint(1, 4), NAMES, tuple(functions)),
         {name: rng.choice((0.5, -3, 7, 0.125)) * rng.randint(1, 99) for name in NAMES})
        for _ in range(800)
    ]  # fmt: skip
    asked = [(text, values) for text, values in asked if len(text) <= 500]
    asked += [("-y^2", dict.fromkeys(NAMES, 3.0)), ("2*-y^2 - -y", dict.fromkeys(NAMES, 3.0))]
    compared = 0
    for (text, values), found in zip(asked, ask([["law", *a] for a in asked]), strict=True):
        assert "value" in found, (text, found)
        try:
            own = value(text, values | functions)
        except (ZeroDivisionError, OverflowError, ValueError):
            continue  # Python refuses; the page holds the output at its limit
        assert float(found["value"].replace("Infinity", "inf")) == pytest.approx(own, rel=1e-9), (
            text
        )
        compared += 1
    assert compared > 600


def test_changes_of_a_net_are_found():
    rng = random.Random(1996)
    asked, own = [], []
    for _ in range(60):
        clocks = sorted(rng.sample(range(1000), rng.randint(1, 40)))
        values = [rng.randrange(2**32) for _ in clocks]
        at = [rng.randrange(1000) for _ in range(30)]
        asked.append(["net", clocks, values, at])
        own.append([])
        for clock in at:
            place = max(0, bisect.bisect_right(clocks, clock) - 1)
            own[-1].append([
                values[place],
                next((c for c in clocks if c > clock), None),
                next((c for c in reversed(clocks[1:]) if c < clock), None),
            ])  # fmt: skip
    assert [found.get("value") for found in ask(asked)] == own
