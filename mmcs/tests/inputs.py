# SPDX-License-Identifier: Apache-2.0
"""Inputs of the digests: mistakes of a user, figures of small functions (test_output.py)."""

import itertools
import re
import sys
import zlib
from pathlib import Path
from types import SimpleNamespace as Of

import numpy as np
import pytest

import mmcs
from mmcs import SCENARIOS, mcdef, place
from mmcs.engine.script import Script
from mmcs.runs import session
from mmcs.runs.expect import judge
from mmcs.runs.machine import machine
from mmcs.runs.metrics import steady_error, step_response
from mmcs.runs.report import limited, make_report
from mmcs.runs.runner import simulate
from mmcs.scenario import synthesis
from mmcs.scenario.load import load, load_robot
from mmcs.scenario.robot import with_values
from mmcs.scenario.scenario import EventExpect, RefusedExpect
from mmcs.sweeps.plan import make_plan, parse_grid, parse_random
from mmcs.tests.conftest import GOOD
from mmcs.tests.insides import told
from mmcs.tests.test_mistakes import FLEXIBLE, ROBOT, TABLE, top

LONG = "9" * 5000
CSV = (b"\xff\xfe\x00", b"1\nnan\n2\n", b"inf\n2\n", b"1\n5e9\n", b"1\n\n\nx\n", b"a\n1\n2\n", b"",
       b"1\n2\n")  # fmt: skip
EXTENDS = ('"lab50"', '"x/y.toml"', "3", '"./mine.toml"', '"./other.toml"')
RECORDS = ("", "{}", '{"mmcs_run": 1}', '{"mmcs_run": 99}', "[1, 2")
PROGRAMS = ('"\'"', '" "', '"\'"\n[[program]]\nrun = "./no 3"',
            '"true"\n[[motion]]\nkind = "step"\naxis = 0\nat = 0.1\nto = 5')  # fmt: skip
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
        *itertools.chain(*((("bad.mmcs", text), "replay bad.mmcs", "trace bad.mmcs --at 0.1")
                           for text in RECORDS)), "replay nowhere",
        *itertools.chain(*((("mine.toml", f'extends="lab500"\n[[program]]\nrun={one}'),
                            "check mine.toml") for one in PROGRAMS)),
        ("base.toml", top("cards = 17")), "check sim/scenarios/lab500.toml",
        ("mine.toml", 'description = "M"\nextends = "./base.toml"\nduration = -1\n'),
        "check mine.toml", "check mine.toml --set cards=18 --set duration=1",
        ("own.toml", ROBOT), ("mine.toml", GOOD.replace("lab500", "./own.toml")),
        "check mine.toml",
        "run puma560 --set 'expect=[{kind=\"axis\",axis=[0,1],final_counts=[[1,2]]}]'",
        ("own.toml", ROBOT.replace("gear", "servo.ilim = 20\nservo.ic_pos = 2000\ngear")),
        "check own.toml",
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
    for samples, where in itertools.product(range(300, 320), (-21, -20, -1)):
        y = np.full(samples, 200.0)
        y[where] -= 100
        made.append(float(steady_error(T[:samples] - 0.05, np.full(samples, 200.0), y)))
    for axis in {}, {"ilim": 0}, {"mode": "off"}, {"ilimax": 1}, {"ilim": 9999}:
        params = {"mode": "torque", "ilim": 50, "ilimax": 0} | axis
        made.append(limited(np.array([0, 50, -2047]), params).tolist())
    return made


RISE = 'expect=[{kind="axis",rise_ms=[%s],final_counts=[190,210]},{kind="stats",missed=0}]'
PEAK, TWO = ('expect=[{kind="axis",peak_error_counts=[190,210]}]',
             'expect=[{kind="axis",axis=[0,1],final_counts=%s}]')  # fmt: skip
MOVE = "duration=0.3", 'motion=[{axis=0,kind="step",at=0.05,to=200}]'
RUNS = (("lab500", RISE % "40,50"), ("lab500", RISE % "1,2"),
        ("lab500", RISE % "40,50", "axis.0.ilim=50"), ("lab500", PEAK, "motion.0.to=-200"),
        ("puma560", TWO % "[[190,210],[-9,9]]", *MOVE),
        ("puma560", TWO % "[[0,0],[190,210]]", *MOVE))  # fmt: skip


def verdicts(_):
    """(events that were seen, or not, or nobody knows; refusals of which one is expected; runs
    whose begin is refused; periods of processes)"""

    def judged(notes=(), lost=0, refused=(), **entry):
        event = {"kind": "event", "event": "panic"} | entry
        kind = RefusedExpect(**entry) if "request" in entry else EventExpect(**event)
        of = Of(scenario=Of(expect=[kind]))
        more = {"motion_start_s": 0.1, "assertion": False, "ended": "", "refused": refused}
        return judge(Of(setup=of, notes=notes, notes_lost=lost, **more), [])

    note = {"t": 0.2, "kind": "panic", "axis": -1, "text": "button"}
    either = {"event": ["error", "panic"]}
    made = [judged([note], seen=seen, **more) for seen in (True, False) for more in (
        {}, {"within_ms": 101.0}, {"within_ms": 99.0}, {"after": 0.2}, {"text": "cable"},
        {"axis": 0}, either, either | {"text": "cable"})]  # fmt: skip
    made += [judged([note], lost, event="error", seen=seen, **more) for lost in (0, 7)
             for seen in (True, False) for more in ({}, {"within_ms": 99.0})]  # fmt: skip
    for size in 98, 99:
        made.append(judged([note | {"text": size * "x"}], text="needle", seen=False))
    refused = {"kind": "refused", "request": "MENABLE", "error": "EIO"}
    made += [judged([], 0, n * [("MENABLE", 5)], **refused)
             for n in range(3)]  # fmt: skip
    for name, *sets in RUNS:
        one = simulate(load(name, tuple(sets)))
        made.append(make_report(one, "native")["expect"])
    ends = (-6, "open"), (-22, "MSETNUMJOINTS 1"), (-22, "MSETPARAM of axis 0"), (-5, "MENABLE")
    with pytest.MonkeyPatch.context() as patch:
        for end in ends:
            patch.setattr(Script, "begin", lambda *_, end=end: end)
            made.append(told(simulate, load("lab500")))
    script = Of(told=lambda: [(2, 0, 990.04, 1010.06), (0, 0, 0.0, 0.0)])
    made.append(session.summaries(script, Of(scenario=Of(process=2 * [Of(kind="pd")]))))
    degrees = 'motion=[{axis=0, kind="step", at=0.05, to=1, unit="deg"}]'
    return made, load("puma560", (degrees, "expect=[]")).segments


def recording(g=150.0, lag=3.0, pos=300.0, neg=350.0, seconds=4.0, dt=1e-3, sign=1):
    """A motor driven back and forth in torque mode, integrated finely; counts as an encoder has."""
    t, y, u, at, v, current, sub = [], [], [], 0.0, 0.0, 0.0, 20
    for n in range(int(seconds / dt)):
        t.append(n * dt)
        y.append(int(np.floor(sign * at)))
        current = (500, 800, 1200)[n // 300 % 3] * (1 if n // 150 % 2 else -1)
        u.append(current)
        for _ in range(sub):
            drag = pos if v > 0 else -neg if v < 0 else float(np.clip(current, -neg, pos))
            after = v + (g * (current - drag) - lag * v) * dt / sub
            v = 0.0 if v * after < 0 else after
            at += v * dt / sub
    return np.array(t), np.array(y), np.array(u)


NAN = float("nan")
ASKS = (
    lambda run: mmcs.load("lab500", ()), lambda run: mmcs.run("lab500", b"seed=1"),
    lambda run: mmcs.load("lab500", sets=()), lambda run: mmcs.compare(run, "lab500"),
    lambda run: mmcs.compare(run, mmcs.run("puma560", "motion=[]")),
    lambda run: run.column(-1, "encoder"), lambda run: run.column(NAN, "encoder"),
    lambda run: run.column(0, "speed"), lambda run: run.plot(None),
    lambda run: run.plot("/dev/full"), lambda run: run.plot("a\0b"),
    lambda run: mmcs.sweep("lab500", grid={"seed": 1}),
    lambda run: mmcs.sweep("lab500", random="seed"),
    lambda run: mmcs.sweep("lab500", random={"seed": "1..5"}, samples=NAN),
    lambda run: mmcs.sweep("lab500", random={"seed": "1..5"}, samples=10**30),
    lambda run: mmcs.sweep("lab500", grid={"seed": [1]}, workers=-1),
    lambda run: mmcs.Machine("lab500", mode="fast"),
    lambda run: mmcs.run(mmcs.load("lab500"), seed=3),
)  # fmt: skip


def library(_):
    """What the names of `mmcs` refuse, and a machine that is stopped or closed."""
    run = mmcs.run("lab500")
    made = [told(ask, run) for ask in ASKS]
    with mmcs.Machine("lab500", mode="torque") as one:
        for given in "x", None, NAN, [NAN], 10**30, 1 << 31, [[1], [2]], object, {}:
            made.append(told(one.write, given))
        for given in -1, 99, None, "x", 1.5, NAN, 10**30, ():
            asks = one.joint, one.restore, *([] if given == 99 else [one.wait])
            made += [told(ask, given) for ask in asks]
        one.step(300, 20)
        made.append(one.read())
        one.stop()
        made += [one.enabled, told(one.write, [1])]
        one.enable()
        made += [told(one.write, [1, 2, 3]), told(one.wait, 0)]
    one.close()
    return made, [told(ask) for ask in (
        one.read, one.wait, one.stop, one.save, one.frame, lambda: one.write([0]),
        lambda: one.time, lambda: one.log)]  # fmt: skip


def robots(path):
    """(motors of robot files, copies, motors of a scenario's own)"""
    axis, made = "[[axis]]", []
    four = re.findall(r"^(?:coulomb|stiction).*\n", ROBOT, re.M)
    every = f"[every_axis]\nfriction = 0.2\nkm = 7.0\n{axis}"
    for text in (FLEXIBLE, ROBOT, ROBOT.replace("".join(four), "friction = 0.1\n"),
                 ROBOT.replace(axis, f"{axis}\nfriction = 0.2"),
                 ROBOT.replace(axis, every)):  # fmt: skip
        (path / "own.toml").write_text(text)
        robot = load_robot(str(path / "own.toml"))[1]
        made += [robot.motors(coupled) for coupled in (False, True)]
    copies = {"axis": [{"copies": 2, "name": "J"}, {"name": "K"}]}
    made.append(with_values(copies, [{"axis": [1], "km": 2.0}]))
    return made, load("lab500", ("motor=[{friction=0.3, stiction_neg=0.4}]",)).motors()


def places(path):
    """(where results are, the commands that install packages)"""
    made = [
        str(place.results(*one))
        for one in (
            ("runs", SCENARIOS / "basic" / "lab500.toml"),
            ("runs", path / "my.toml"),
            ("sweeps",),
        )
    ]
    made += map(place.installs, ("tool", "hosts"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(place, "IN_CHECKOUT", False)
        patch.setattr(sys, "executable", "python")
        for pip in (True, False):
            patch.setattr(place, "find_spec", lambda name, pip=pip: pip and name == "pip")
            made += map(place.installs, ("tool", "hosts", "dask"))
        patch.setattr(sys, "prefix", str(path))
        (path / "pipx_metadata.json").touch()
        made.append(place.installs("dask"))
    return [re.sub(r"==\S+", "==", one) for one in made]


METHODS = "zoh", "bilinear", "backward", "prewarp", "matched"
CONTROLLERS = ((4.0,), (4.0, 30.0), (4.0, 0.0, 0.1, 0.004), (4.0, 30.0, 0.1, 0.004),
               (4.0, 0.0, 0.1), (4.0, 30.0, 0.1))  # fmt: skip


def integers(_):
    """Integer gains and what is said of them, by each method."""
    made = []
    for gains, method, *scale in (
        ((4, 30, 0.1), "bilinear"), ((4, 30, 0.1), "backward"), ((4, 3, 0.1), "backward", 64),
        ((2.0**31,), "backward"), ((40000.0,), "backward"),
    ):  # fmt: skip
        discrete = synthesis.discretize(synthesis.Controller(*gains), method, 1e-3)
        made.append(told(synthesis.to_integers, discrete, *scale))
    for gains, method in itertools.product(CONTROLLERS, METHODS):
        d = told(synthesis.discretize, synthesis.Controller(*gains), method, 1e-3, 200.0)
        made.append(d)
        made += [told(synthesis.to_integers, d, scale) for scale in (16, 1024, None)]
    for num, den in ((1.0,) * 4, (1.0,)), ((1.0,), (2.0,)), ((1.0,), (1.0, 0.95)):
        made.append(told(synthesis.to_integers, synthesis.Discrete(num, den)))
    return made


def by_hand(_):
    """(what the wrapper of the library says and refuses, words of the driver's structures)"""
    setup, values = load("lab500"), {"flags": ["softerr"], "a0": 50, "b0": -1}
    with machine(setup) as sim:
        made = [sim.build(), sim.time, sim.clock, told(sim.trace, Path("x.fst")),
                told(sim.add_segment, axis=7, kind="step", t0=0.0, to=1.0), told(sim.drop, 9),
                told(machine, setup, library=Path("none.so"))]  # fmt: skip
    param, ffi = mcdef.new_param(3), mcdef.make_ffi()
    mcdef.fill_param(param, {"mode": "velocity"} | values)
    again = mcdef.new_params([{"mode": "torque"} | values])[0]
    words = ffi.cast("int *", ffi.addressof(again))
    for word, mask, value in mcdef.sets({"mode": "velocity"}) + mcdef.sets({"a0": 51}):
        words[word] = words[word] & ~mask | value & mask
    made += [[getattr(one, name) for name in ("which", "mode", "a0", "b0")]
             for one in (param, again)]  # fmt: skip
    made.append(mcdef.mode_word("position", ["coulcomp", "poschk"]))
    return [*made, told(getattr, mcdef, "MSETNOTHING")]


FIGURES = {"plans": a_plan, "responses": responses, "verdicts": verdicts, "library": library,
           "robots": robots, "places": places, "integers": integers,
           "by hand": by_hand}  # fmt: skip
