# SPDX-License-Identifier: Apache-2.0
"""What the pages compute by themselves, against Python: random gains, formulas, records by seed."""

import base64
import bisect
import json
import math
import random
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

from mmcs import ROOT
from mmcs.runs.record import column_digests, row_digests
from mmcs.scenario.synthesis import Controller, DesignError, Discrete, discretize, to_integers
from mmcs.tool.advisor import Advisor

pytestmark = pytest.mark.req("TOOL-1", "SYN-1")
KICK = 1024
NEAR = 1e-8  # of two ways to sum; near z = 1 they lose eight digits
NAMES = ("r", "y", "v", "e", "i", "t", "u")


def ask(questions: list[list]) -> list[dict]:
    """What the pages' own code says to each."""
    node = Path(sys.executable).with_name("node")
    script = ROOT / "web" / "tests" / "answers.mjs"
    text = subprocess.run([node, script], input=json.dumps(questions), text=True,
                          capture_output=True, check=True).stdout  # fmt: skip
    return json.loads(text)


def some(rng: random.Random, low: float, high: float, zero: float = 0.3) -> float:
    """Of any size between two, or nothing."""
    return 0.0 if rng.random() < zero else math.exp(rng.uniform(math.log(low), math.log(high)))


def same_design(page: dict, own: dict) -> None:
    assert page["coefficients"] == own["coefficients"]
    assert page["warnings"] == own["warnings"]
    assert page["gain_error"] == pytest.approx(own["gain_error"], abs=NEAR)


def test_gains_to_integers():
    """P, PD, PID with and without a filter, at any interval: integers, warnings and errors."""
    rng = random.Random(1989)
    asked = [
        {"p": some(rng, 1e-3, 1e4), "i": some(rng, 1e-2, 1e5), "d": some(rng, 1e-4, 100),
         "tau": some(rng, 1e-4, 0.1, 0.5), "interval_s": rng.choice((5e-4, 1e-3, 2e-3, 0.01))}
        for _ in range(800)
    ]  # fmt: skip
    asked += [{**gains, "p": -gains["p"]} for gains in asked[:50]]
    asked += [{"p": size, "interval_s": 1e-3} for size in (1e9, 3e9, 1e12, 0.5, 1.5, 2.5, 1e-9)]
    advisor, warned, errors = Advisor(Path()), set(), 0
    for gains, found in zip(asked, ask([["design", gains] for gains in asked]), strict=True):
        own = advisor.answer({"op": "design", **gains})
        if "error" in own:
            assert found == {"error": own["error"]}, gains
            errors += 1
            continue
        same_design(found["value"], own)
        warned |= {word.split()[0] for word in own["warnings"]}
    assert errors and warned == {"S*I*T", "a", "rounding", "one"}  # each was met
    nothing = advisor.answer({"op": "design", "interval_s": 1e-3})
    assert nothing["gain_error"] == 0  # a number that JSON has


def test_a_compensator_of_ones_own_to_integers():
    rng = random.Random(1990)
    made = []
    for _ in range(500):
        num = [rng.uniform(-1, 1) * some(rng, 0.01, 1e4) for _ in range(rng.randint(1, 3))]
        poles = [
            rng.choice((1.0, rng.uniform(-0.999, 0.999), 0.0)) for _ in range(rng.randint(0, 2))
        ]
        den = np.poly(poles).tolist() if poles else [1.0]
        made.append((num, den))
    rings = 0
    for (num, den), found in zip(
        made, ask([["designOf", {"num": n, "den": d}] for n, d in made]), strict=True
    ):
        if not any(num):
            assert found["value"]["coefficients"]["b0"] == 1
            continue
        try:
            own = to_integers(Discrete(tuple(num), tuple(den)), 1e-3)
        except DesignError as error:
            assert found == {"error": str(error)}
            continue
        page = found["value"]
        assert [page["coefficients"][f"a{n}"] for n in range(3)] == list(own.a)
        assert [page["coefficients"][f"b{n}"] for n in range(3)] == list(own.b)
        assert page["gain_error"] == pytest.approx(own.gain_error, abs=NEAR)
        kick = abs(own.a[0] / own.b[0]) > KICK
        assert page["warnings"][: len(page["warnings"]) - kick] == list(own.warnings)
        rings += any("rings" in w for w in own.warnings)
    assert rings > 3


def test_gains_come_back_from_integers():
    """What a panel shows of integers has, in Python, the very response of those integers."""
    rng = random.Random(1991)
    asked, t = [], 1e-3
    for _ in range(300):
        c = Controller(some(rng, 0.1, 1e3, 0), some(rng, 1, 1e5), some(rng, 1e-3, 10), 0.0)
        if not c.i and c.d and rng.random() < 0.5:
            c = Controller(c.p, 0.0, c.d, some(rng, 1e-3, 0.1, 0))
        made = to_integers(discretize(c, "backward", t), t)
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


def test_records_have_the_digests_that_a_replay_looks_for():
    rng = np.random.default_rng(1994)
    asked, own = [], []
    for _ in range(30):
        rows, cols = int(rng.integers(1, 60)), 7 * int(rng.integers(1, 4)) + 1
        log = rng.normal(size=(rows, cols)) * 10.0 ** rng.integers(-3, 6)
        every, marks = int(rng.integers(1, 9)), sorted({int(rng.integers(0, rows + 1)), rows})
        packed = base64.b64encode(log.tobytes()).decode()
        asked += [["digests", rows, cols, packed, every, marks], ["crc32", packed]]
        digests = [list(row_digests(log, every)), list(column_digests(log, marks))]
        own += [digests, zlib.crc32(log.tobytes())]
    assert [found.get("value") for found in ask(asked)] == own


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
