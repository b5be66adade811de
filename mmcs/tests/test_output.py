# SPDX-License-Identifier: Apache-2.0
"""All that commands print and write, and what functions return, as ever (tools/golden.py)."""

import contextlib
import dataclasses
import itertools
import math
import pprint
import shlex
import zlib
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mmcs import ROBOTS, ROOT, mcdef
from mmcs.bridge import fmu
from mmcs.cli.app import main
from mmcs.runs.metrics import step_response
from mmcs.scenario.arm import mass_matrix, stiff_joints
from mmcs.scenario.describe import robot_cautions
from mmcs.scenario.files import named
from mmcs.scenario.identify import IdentifyError, Motor, frequency, identify
from mmcs.scenario.load import load, load_robot
from mmcs.scenario.robot import Robot
from mmcs.scenario.scenario import Scenario
from mmcs.sweeps import campaign, campaign_report, classes, faults, workers
from mmcs.tests.conftest import call
from mmcs.tests.inputs import FIGURES, MISTAKES, recording
from mmcs.tests.insides import INSIDES
from mmcs.tests.refusals import REFUSALS
from mmcs.tests.talks import TALKS
from mmcs.tests.test_tool import PD, TOOK, advise
from mmcs.tool import judge, launch, tune
from mmcs.view import chart, film, moments, watched, waves
from mmcs.view.names import registers
from studies import lockstep, one_axis, shrink
from tools import book, carried, coverage, formal, trace, wavegen
from tools.golden import plain, same
from tools.mutation import code, mutant_runs, mutants, mutate

# Carried out in a folder of their own; each file that a command leaves there is told after it.
SESSIONS = {
    "list": ["list", "faults"],
    "help": ["--help", *(f"{name} --help" for name in main.commands if name != "lab")],
    "show": [f"show {name}" for name in named()],
    "check": [f"check {name}" for name in (*named(), *map(str, sorted(ROBOTS.glob("*.toml"))))],
    "step": [
        "run lab500 --out a --bus", "run lab500_nocomp --out b", "compare a b", "replay a",
        "trace a --at 0.05 --window 2 --out a/t.fst", "export mcap a", "export film a",
        *(f"trace a --at {more}" for more in ("boom", "9", "0.1 --window 0", "0.1 --window 1e-9",
          "0.1 --window nan", "0.1 --out x.vcd", "0.05 --out no/x.fst")),
    ],
    "arm": ["run puma560_reach --out arm", "export mcap arm", "compare arm nowhere",
            "run lab500 --out b", "compare b arm", "compare b b --out x.png",
            "compare b b --out no/x.svg"],
    "calibrate": ["run puma560_calibrate --out arm"],
    "bounce": ["compile puma560_bounce -o own.bin", "run own.bin --out arm --duration 0.4"],
    "events": ["run fault_estop --out a", "check lab500 --set servo=[{clkdivisor=2}]"],
    "refused": ["run fault_bus_errors --out a", "run user_loop --out b", "compare a b"],
    "design": [
        "design -p 4 -d 0.1", "design -p 4 -i 9 -d 0.1 --method bilinear --tau 0.001",
        "design --wn 60 --tau 0.001",
        "design -p 3 -d 0.05 --method prewarp --prewarp 60 --interval 2000 --axis 2",
        "design --wn 60 --zeta 0.7 --kick 50 --toml", "design --wn 80 --robot lab500 --toml",
        "design -p 2 -d 0.1 --method matched --tau 0.002 --scale 256 --axis 4",
        "design --wn 900", "design --wn 30 --axis 5 --interval 4000 --toml", "design -p 1e-9",
        "design -p 0.2 -d 0.01 --robot lab500", "design -p 3.3 -i 41 -d 0.07",
        "design -p 6.1 -i 77 -d 0.2 --interval 2000", "design -p 1.7 -i 12.5",
    ],
    "sweep": [
        "sweep lab500 --grid axis.0.b0=56,72 --random axis.0.ilim=200..1000 --samples 2 --out s"
        " --set duration=0.2 --workers 1",
        "sweep lab500 --grid duration=0.06,0.12 --grid motion.0.at=0.05,0.1 --out bad --workers 1",
        "sweep lab500 --grid motion.0.to=0,300 --out missed --workers 1 --set duration=0.08"
        " --set 'expect=[{kind=\"axis\",final_counts=[-5,5]}]'",
    ],
    "campaign": ["campaign arm_move --faults 24 --seed 3 --out c --workers 1"],
    "programs": ["exec --robot puma560", "exec --robot lab500 --interval 2000", "exec --cflags",
                 "exec --cflags --modern", "exec -- true", "exec", "serve lab500 --dev a/b",
                 "exec --scenario lab500 sh -c 'exit 3'", "exec --scenario lab500 -- ./nothing",
                 "exec --scenario lab500 --lockstep -- sh -c 'kill -9 $$'", "exec --out o -- true",
                 "exec --scenario lab500 -- /etc", "exec --realtime --speed 2 -- true",
                 "exec --scenario lab500 --out o --speed 2 -- true", "exec --speed 2 -- true",
                 "exec --scenario lab500 --set motion=[] -- true",
                 "exec --scenario lab500 --set axis.0.b0=3 -- true", "serve lab500 --speed 0",
                 f"serve lab500 --dev {'x' * 120}",
                 "exec --lockstep --speed 2 -- true", "exec --scenario lab500 --out o -- true"],
    "mistakes": [
        "design -p 4 -d 0.1 --method zoh", "design -p 4 -i 9 -d 0.1 --method ztransform",
        "design -p 4 --method zoo", "design --robot puma560", "design -p 4 --axis 17",
        "design -p 1 --axis 6", "design -p 4 --scale 0", "design -p 4 --interval 0",
        "design --wn 60 -p 3", "design --zeta 0.7 -p 3", "design --wn 60 --tau 0.001 --kick 50",
        "design -p 3 -d 0.1 --kick 0", "design -d 1e300 --kick 1", "design --wn 0.1 --zeta 0.1",
        "design -p 3.4 -d 0.01 --kick 0.04 --scale 4", "campaign --faults 0",
        "campaign --sort pins", "campaign arm_move arm_move", "campaign fault_estop",
        "campaign user_loop", "campaign --workers 0", "campaign --workers 1 --dask tcp://x",
        "campaign arm_calibrate --set axis.all.ilimax=20", "campaign --resume --out .",
        "campaign --stops", "campaign --stops fault_estop",
        "campaign --stops lab500 --sort pin",
        f"check {ROBOTS / 'lab500.toml'} --set a=1",
    ],
    "cautions": [f"check {name} --set {more}" for name, *sets in (
        ("lab500", "axis.0.mode=off", "axis.0.ilim=2100", "axis.0.a0=40000", "interval_us=100",
         "axis.0.a0=4600", "'event=[{at=9, input=\"estop\", value=1}]'", "pose_deg=[1,2]",
         "robot.axis.0.stiffness=5", "'call=[{request=\"MSETPARAM\", at=0.1}]'",
         "axis.0.a0=-40 --set axis.0.a1=0", "'call=[{request=\"MENABLE\", at=0.1, set={a0=1}}]'"),
        ("puma560_hold", "interval_us=20000 --set heartbeat_us=10000",
         "pose_deg=[999,0,0,0,0,0]", "pose_deg=[9,9]", "axis.all.a0=9999"),
        ("puma560_reach", "axis.2.mode=off", "motion.0.axis=1"), ("arm_move", "cards=2"),
        ("user_loop", "process.0.to=[1,2,3,4,5,6,7]", "process.0.from=[1,2,3]",
         "'motion=[{axis=0, kind=\"step\", at=0.05, to=200}]'"),
    ) for more in sets],
    "compile": ["compile lab500 -o a.bin --cflags --libs", "compile lab500 -o a.bin --libs",
                "compile lab500 -o a.bin --cflags", "compile lab500 -o a.bin --host vax",
                "run lab500 --out a --set duration=0.07 --set 'expect=[{kind=\"axis\","
                "final_counts=[0,1]},{kind=\"axis\",peak_error_counts=[0,1]},"
                "{kind=\"calibration\",axis=0,found=false}]'"],
    "wrong": [f"check lab500 --set {one}" for one in (
        "robot.axis.0.gear=0", "robot.axis.0.amp_gain=0", "dynamics=coupled", "axis.x=1",
        "robot.axis.0.stop_lo=5 --set robot.axis.0.stop_hi=-5", "axis.1x.b0=5", "robot.axis=[3]",
        "axis=3 --set axis.0.b0=1", "'card=[{file=\"x.sv\"}]'", "axis.0.modus=4",
        "robot.axis.7.gear=1", "motion.0.kind=wave",
        *(f"'event=[{{at=0.1,input=\"{name}\",value=1}}]'" for name in ("qqq", "estap")),
        "'motion=[{kind=\"table\",axis=0,file=\"x.csv\"}]'")],
    "mctool": ["tool --no-browser no_such_scenario", "tool --attach nobody", "tool -t -5",
             "tool --theme 2089", "tool --attach a/b", "tool lab500 --sheets nowhere"],
    **MISTAKES,
}  # fmt: skip
NOT_TOLD = (".bin", ".fst", ".jsonl", ".toml", ".txt")


def put(path, content):
    """A file, of None a folder."""
    path.parent.mkdir(exist_ok=True)
    if content is None:
        return path.mkdir()
    path.write_bytes(content.encode() if isinstance(content, str) else content)


@pytest.mark.req("DRV-3")
@pytest.mark.filterwarnings("error::RuntimeWarning")  # people would read of it, too
@pytest.mark.parametrize("session", SESSIONS)
def test_what_commands_print_and_write(session, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr(workers, "CONNECT_S", 1)
    answers = []
    for words in SESSIONS[session]:
        if isinstance(words, tuple):
            put(tmp_path / words[0], words[1])
            continue
        status, out, err = call(*shlex.split(words))
        answers.append(plain(f"$ mmcs {words[:200]}\n{out}{err}status {status}\n", tmp_path))
    if session in MISTAKES:  # which leave nothing
        answers.append(", ".join(sorted(path.name for path in tmp_path.iterdir())))
    same(session, "".join(answers))
    for path in sorted(p for p in tmp_path.rglob("*.*") if p.is_file()):
        if path.suffix not in NOT_TOLD:
            text = path.read_bytes().decode(errors="backslashreplace")
            same(f"{session}/{path.relative_to(tmp_path)}", plain(text, tmp_path))


T, MOTOR = np.arange(0, 0.5, 0.001), Motor(1450.0, 0.3, 100.0, 105.0, 0.99)
WISH = judge.Wish(60.0, 1.0, 0.001)
ROWS = {"t": [0.0, 0.001], "y": [0.0, 190.0], "u": [300.0, 300.0], "size": 200}
CHANGES = [
    {}, {"rise_ms": None}, {"rise_ms": 120.0}, {"overshoot_pct": 8.0}, {"settle_ms": 1184.0},
    {"settle_ms": None}, {"settle_ms": None, "steady_error_counts": -8.0},
]  # fmt: skip
PARAMS = [{}, {"ilim": 300}, {"a0": 9 * 4526, "a1": -9 * 4416}, {"a0": 8000, "b1": -20}]
MUTANT = mutants.Mutant("axis", "i8255", 7, "-module i8255 -mode inv", "i8255.sv:9", "k")
POINTS = Counter(
    {("rtl/mmcs.sv", n, k, "w"): n % 3 for n in range(9, 40) for k in ("line", "toggle")}
)
REQUIREMENT = {"section": "1", "text": "it moves", "files": ["rtl/mmcs.sv", "rtl/gone.sv"]}
CHAPTER = "# A\n[b](../../rtl/mmcs.sv) [c](tool.md#d) ![e](../images/loop.svg) <https://f>\n"
UPSETS = {"a": 4, "b": 1}
WANTED = {"A-1": REQUIREMENT, "B-2": REQUIREMENT}
TESTS = {"cocotb_tests/checkers::a": ["A-1", "Z-9"], "cocotb_tests/card/y.py::test_b": ["B-2"]}


def step(tau=0.02, start=0.05, begin=0.0, to=200.0, size=200.0):
    y = begin + (to - begin) * (1 - np.exp(-np.maximum(T - start, 0) / tau))
    return step_response(T, np.round(y + 9 * np.sin(40 * T)), start, begin, size)


def a_chart():
    cell = chart.Cell(60, 50, 200, 100, title="a < b", labels=("error", "counts"), below="s")
    cell.line([0, 1, 2, 4], [3, 3, 5, -2], "#123456", 1.0, label="of <it>")
    cell.line([0, 1, 2, 4], [1, 0, 0, 2], "#123457", 2.0, steps=True)
    cell.rule("#654321", 0.5, y=9.0, dash="1 2")
    cell.rule("#abcdef", 0.5, x=1.0)
    return [chart.ticks(a, b, 5) for a, b in ((0, 1.25), (-1020, 1020), (8e-4, 42e-4))], (
        chart.picture([cell], 300, 200, "R&D").splitlines())  # fmt: skip


def other(**more):
    """The PUMA, whose joints but the first and the fourth are others."""
    robot = load_robot("puma560")[1]
    some = [one.model_copy(update=more) if n % 3 else one for n, one in enumerate(robot.axis)]
    return robot.model_copy(update={"axis": some})


def options(words):
    """What `mmcs tool` starts."""
    started, run = [], SimpleNamespace(address="http://there", wait=lambda: None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(launch, "start", lambda *a: started.append(a) or contextlib.nullcontext(run))
        return started, call("tool", *words.split())


def a_campaign():
    plan, places = campaign.make_plan(("arm_move", "puma560_hold"), (), 5), range(80)
    names = ("vme_a_stuck0 0", "vme_control_stuck0 3", "pc_d_stuck1 7", "MSETPARAM a0")
    seen = itertools.product((False, True), (None, 0.1), (9.9, 10.0, 10.1), (10.0, 10.1))
    return [
        [plan.fault(n) for n in places], [plan.command(n) for n in places],
        zlib.crc32(repr([plan.fault(n) for n in range(40_000)]).encode()),
        [faults.line_name(name) for name in names], [n for n, _ in plan.chunks([*range(200)])],
        [classes.judge(classes.Seen(*one)) for one in seen],
        [campaign_report.per_million(k, n) for k, n in ((0, 0), (0, 10), (3, 700), (10, 10))],
    ]  # fmt: skip


def a_wave():
    entry = {"title": "T", "signals": [["a", "x"], ["b", "y", "addr"], ["c", "z", "volt"]]}
    found = [{0: 1, 500: 0}, {0: 0x204, 250: 0x8000}, {250: 0x9000}]
    seen = moments.Pass(0, 80, 91, 200_000_000)
    view = [
        waves._gtkwave(Path("x.fst"), Path("x"), waves.GROUPS, one, events).splitlines()
        for one, events in ((seen, (None, 2 * 10**9)), (None, (7, None)), (None, (None, None)))
    ]
    return wavegen.wavejson(entry, found, 250), watched.groups(["X", "Y"]), view, registers()


T4, Y, U = recording()
STRANGE = np.cumsum(np.cumsum(np.random.default_rng(1).integers(-40, 41, len(T4))))
UNTOLD = [(T4[:50], Y[:50], U[:50]), (T4, Y * 0, U), (T4, np.cumsum(np.arange(len(T4))) // 50, U),
          (T4, STRANGE, U)]  # fmt: skip


def unidentified(rows):
    with pytest.raises(IdentifyError) as no:
        identify(*rows)
    return str(no.value)


def a_frequency():
    t = np.arange(8000) * 1e-3
    w = 100 * np.sin(2 * np.pi * np.cumsum(1 + 3 * t) * 1e-3)
    made = frequency(t, w, np.cumsum(w) * 0.02, 2, 25)
    return len(made.hz), [np.round(x, 3).tolist()[:40] for x in dataclasses.astuple(made)]


def a_report(path):
    statuses = [coverage.report(POINTS, some) for some in (True, False)]
    return statuses, (path / "report.txt").read_text().splitlines()


VALUES = {
    "step response": lambda _: [
        step(), step(to=175.0), step(begin=-10.0), step(to=-175.0, size=-200.0), step(tau=0.001),
        step(start=9.0), step(start=0.4995), step(to=230.0), step(size=0.0), step(start=0.0),
    ],
    "judged": lambda _: [judge.judge(TOOK | ROWS | c, WISH, MOTOR, PD | p)
                         for c in CHANGES for p in PARAMS],
    "wish": lambda _: [judge.Wish(w, z, 0.002).figures() for w in (20, 90) for z in (0.4, 1, 2)],
    "predicted": lambda _: [
        judge.predict(MOTOR, PD | change, 0.001, size, 0.3, 140.0) for size in (200, -90)
        for change in ({}, {"mode": 17, "ic_pos": 90, "ic_neg": 80}, {"ilim": 150})
    ],
    "gains": lambda _: [tune.gains(MOTOR, wn, 0.8, t, slow) for wn in (20.0, 90.0)
                        for t in (0.001, 0.004) for slow in (0.0, 5.0)],
    "identified": lambda _: [
        *(identify(*recording(lag=lag, sign=sign)) for lag in (0.5, 9.0) for sign in (1, -1)),
        *(identify(*recording(*one)) for one in (
            (150, 3, 300, 350), (760, 2, 70, 106), (1450, 0.3, 105, 105))),
        *map(unidentified, UNTOLD),
    ],
    "frequency": lambda _: a_frequency(),
    "kinematics": lambda _: [
        load("puma560").about(), *(load("puma560").robot.motors(coupled) for coupled in (0, 1)),
        film.arm_points(load("puma560").robot.links(), np.arange(6) / 7).tolist(),
        mass_matrix(load_robot("puma560")[1].link, np.arange(6) / 7).tolist(),
        *(stiff_joints(other(stiffness=k, damping=d)) for k in (0, 1e3, 1e8) for d in (1, 1e7)),
        *(robot_cautions(other(**{key: by})) for key, by in (
            ("v_supply", 1e6), ("stiction_neg", 99.0), ("coulomb_neg", 0.0), ("gear", 1e-3),
            ("pot_v_per_rad", 50.0), ("pot_v_per_rad", 1e-3))),
    ],
    "options": lambda _: [options("lab500"), options(
        "lab500 -t 2 -u -z --deadman 300 --theme 1989 --port 5 --no-browser")],
    "nonsense": lambda _: advise(
        {"id": 1, "op": "design", "p": 0, "interval_s": 0.001}, {"id": 2, "op": "sing"}, "1.5",
        {"id": 3, "op": "design", "p": "much"}, "nonsense", "[]", "[" * 50_000,
        {"id": 4, "op": "design", "p": 1e300, "d": 1e300, "interval_s": 1e-300},
        '{"id": [[]], "op": "design"}', '{"op": "alive"}', {"id": math.nan, "op": "design"}),
    "chart": lambda _: a_chart(),
    "campaign drawn": lambda _: a_campaign(),
    "waves": lambda _: a_wave(),
    "schemas": lambda _: [model.model_json_schema() for model in (Scenario, Robot)],
    "mcdef": lambda _: [mcdef.constants(), mcdef.requests()],
    "fmu": lambda _: [fmu.model_description(load(name), "token", m).splitlines()
                      for name, m in (("lab500", True), ("puma560", False))],
    "carried": lambda _: [carried.write(task).read_text().splitlines() for task in
                          ("prove_i8254", "bits_i8254", "prove_mark1", "bits_mark1", "deaf_i8254",
                           "deaf_mark1")],
    "formal": lambda _: [(formal.tasks(f), [formal.depth(f, t) for t in formal.tasks(f)],
                          formal.slow(f), formal.properties(f)) for f in formal.groups()[:4]],
    "trace": lambda _: [trace.page(WANTED, TESTS).splitlines(), sorted(
        one for one in trace.problems(WANTED, TESTS) if one[:3] in WANTED or "Z-9" in one)],
    "coverage": a_report,
    "mutants": lambda _: [mutate.table([dataclasses.replace(MUTANT, fate=fate) for fate in (
        "killed", "killed", "survived", "equivalent")]).splitlines(), mutate.plain(MUTANT),
        mutants.TOPS, code.files(), [dataclasses.astuple(group) for top in mutants.TOPS
                                     for group in mutant_runs.groups(top)]],
    "book": lambda _: [book.chapter(CHAPTER, ROOT / "docs/use/driver.md", set()).splitlines(),
                       book.nav().splitlines()],
    "one axis": lambda _: one_axis.move(load_robot("lab500")[1].axis[0], PD, lambda _: 200, 1e-3,
                                        0.1),
    "stimulus": lambda _: [list(lockstep.lively(7, 3, 6, lockstep.stranger(7, 3, 6, 2000, UPSETS))),
                           list(itertools.islice(lockstep.runs(7), 12)),
                           shrink.shrunk([*range(20)], lambda some: {3, 11} <= set(some))],
    **FIGURES,
    **TALKS,
    **INSIDES,
    **REFUSALS,
}  # fmt: skip


def rounded(value):
    """Seven digits of each number."""
    if isinstance(value, float):
        return float(f"{value:.7g}")
    if dataclasses.is_dataclass(value):
        return rounded(vars(value))
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return [rounded(one) for one in value] if isinstance(value, list | tuple) else value


@pytest.mark.parametrize("name", VALUES)
def test_what_functions_return(name, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(coverage, "BUILD", tmp_path)
    made = pprint.pformat(rounded(VALUES[name](tmp_path)), width=99, sort_dicts=False)
    out, err = capsys.readouterr()
    same(name, plain(f"{made}\n{out}{err}", tmp_path))
