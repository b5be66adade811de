# SPDX-License-Identifier: Apache-2.0
"""Inputs of the digests: mistakes of a user, figures of small functions (test_output.py)."""

import itertools
import zlib

import numpy as np

from mmcs.runs.metrics import steady_error, step_response
from mmcs.runs.report import limited
from mmcs.sweeps.plan import make_plan, parse_grid, parse_random
from mmcs.tests.conftest import GOOD
from mmcs.tests.test_mistakes import TABLE, top

LONG = "9" * 5000
CSV = (b"\xff\xfe\x00", b"1\nnan\n2\n", b"inf\n2\n", b"1\n5e9\n", b"1\n\n\nx\n", b"a\n1\n2\n", b"",
       b"1\n2\n")  # fmt: skip
EXTENDS = ('"lab50"', '"x/y.toml"', "3", '"./mine.toml"', '"./other.toml"')
# As SESSIONS of test_output.py; (name, text) is a file, of None a folder.
MISTAKES = {
    "mistaken": [
        "fly", "run", "run lab500 --fast", "run lab50", "run ./nowhere.toml", f"run {'a' * 300}",
        f"show {'a' * 300}.toml", "run lab500 --host vax", "run lab500 --trace x.vcd",
        "export mcap lab500 --out run.mmcs", "export fmu lab500 --out x.zip",
        "run lab500 --set cards", "run lab500 --set motion.7.to=1", "run lab500 --set cards.x=1",
        "check lab500 --set motion.².to=1", "run lab500 --set cards=99",
        f"check lab500 --set cards={'[' * 3000}",
        "run lab500 --set axis.0.ilim=5 --set axis.0.b0=0",
        "run lab500 --set robot.axis.all.km=-1", "run lab500 --duration -1",
        "run lab500 --duration long", "run lab500 --seed -1", "run lab500 --seed '1\n2'",
        "design --wn nan", "design --wn 1e300", "design -d 1e308", "design -d 1 --tau 1e308",
        "faults nosuch",
        f"campaign --seed {LONG}", f"run lab500 {LONG}", f"check lab500 --set {'a.' * 900}a=1",
        ("two.toml", top("cards = 0") + "colour = 1\n"), "check two.toml", "run two.toml",
        *itertools.chain(*((("table.toml", TABLE.replace("t.csv", "t")), ("t", text),
                            "check table.toml") for text in CSV)),
        ("table.toml", TABLE.replace("t.csv", 't"\ncolumn = "a')),
        ("t", b"\xef\xbb\xbfa,b\r\n1,2\r\n\r\n3,4\r\n"), "check table.toml",
        ("file", ""), "run lab500 --out file/out", ("a/report.json", None), "run lab500 --out a",
        ("b/log.csv", None), "run lab500 --out b", ("c/plot.svg", None), "run lab500 --out c",
        ("x.fst", None), "run lab500 --trace x.fst", ("x.fmu", None),
        "export fmu lab500 --out x.fmu",
        ("other.toml", 'extends = "./mine.toml"'), *itertools.chain(*(
            (("mine.toml", f"extends = {name}"), "check mine.toml") for name in EXTENDS)),
    ],
    "sweeps refused": [
        ("short.toml", GOOD), *(f"sweep short.toml --out out {more}" for more in (
            "", "--grid cards", "--grid axis.0.b0=1,,2", "--grid carts=1,2",
            "--grid axis.0.c0=1,2", "--random axis.0.gear=1..2", "--grid axis.0.b0=100,0",
            "--grid axis.0.b0=100,x", "--random axis.5.b0=1..9",
            "--grid robot.axis.0.inertai=1,2", "--grid robot.axis.0.gear=1,0",
            "--random axis.0.ilim=-5..9", "--random seed=9..1", "--random seed=a..b",
            "--random seed=0..9:log", "--random seed=0..9:3",
            "--grid host.latency_max_us=0.0..9.0", "--grid seed=1..2000000",
            "--grid seed=1..2000 --grid axis.0.a0=1..2000", "--grid seed=1,2 --random seed=1..2",
            "--grid seed=1,2 --samples 3", "--random seed=1..2 --samples 0",
            "--grid seed=1,2 --workers 0", "--grid seed=1,2 --workers 1 --dask x",
            "--grid seed=1,2 --dask tcp://127.0.0.1:9", "--grid seed=1,2 --dask nonsense://x",
            "--grid seed=1,2 --resume", f"--grid axis.0.b0={LONG}", f"--grid axis.0.b0=1..{LONG}",
            f"--grid axis.0.b0=1..9:{LONG}", "--grid axis.0.b0=1e999..2",
            f"--random axis.0.b0={LONG}..2", f"--grid axis.0.b0={'[' * 5000}",
            f"--set axis.0.b0={LONG} --grid axis.0.b0=1,2")),
    ],
}  # fmt: skip
GRIDS = ("1,2,3", "[1,2],[3,4]", "off, position", "true", "a/../b.csv,../c.csv", "-2..2",
         "0.5..1.5:5", "10..20:3", "1..1000:log4", "1e-3..0.1:log3")  # fmt: skip
RANDOMS = ("k=1..6", "other=1..6", "k=-1.0..3.0", "k=1.0..1000.0:log", "k=a,b")
T = np.arange(0, 0.5, 0.001)


def a_plan(_):
    """(values of grids, draws, the rows of a plan and of one with more samples, one row's setup)"""
    grids = [parse_grid(f"k={text}").values for text in GRIDS]
    draws = [[parse_random(text).draw(seed, n) for n in range(2000)]
             for text in RANDOMS for seed in (1, 2)]  # fmt: skip
    drawn = [(made[:9], zlib.crc32(repr(made).encode())) for made in draws]
    keys = ("axis.0.b0=1,2", "axis.0.a1=3,4,5"), ("seed=1..99",)
    few, more = (make_plan("lab500", *keys, samples, 7) for samples in (4, 9))
    rows = [[plan.values(n) for n in range(len(plan))] for plan in (few, more)]
    setup = few.setup(rows[0][5])
    whole = make_plan("lab500", ("seed=1",), (), None, 1, ("skip=false",)).first().scenario.skip
    return grids, drawn, rows, setup.params, setup.scenario.seed, setup.scenario.skip, whole


def responses(_):
    """(steps of the first order, ramps that begin or stand between samples, errors of the last
    20 ms, samples that the limit cut)"""
    made = []
    for begin, target in (0, 200), (0, -200), (100, 300), (-50, -60):
        y = begin + (target - begin) * (1 - np.exp(-np.maximum(T - 0.05, 0) / 0.02))
        made.append(step_response(T, y, 0.05, begin, target))
    for first, before in (0, 7), (1, 7), (50, 7), (1, -20), (50, -20):
        y = 7.0 + np.clip(13.0 * (np.arange(len(T)) - first), 0, 100)
        y[: max(first - 1, 0)] = 40
        y[first - 1 : first] = before
        made.append(step_response(T, y, T[first], 0, 100))
    for samples, place in itertools.product(range(300, 320), (-21, -20, -1)):
        y = np.full(samples, 200.0)
        y[place] -= 100
        made.append(float(steady_error(T[:samples] - 0.05, np.full(samples, 200.0), y)))
    for axis in {}, {"ilim": 0}, {"mode": "off"}, {"ilimax": 1}, {"ilim": 9999}:
        params = {"mode": "torque", "ilim": 50, "ilimax": 0} | axis
        made.append(limited(np.array([0, 50, -2047]), params).tolist())
    return made


FIGURES = {"plans": a_plan, "responses": responses}
