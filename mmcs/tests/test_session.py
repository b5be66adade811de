# SPDX-License-Identifier: Apache-2.0
"""A run on a fake machine: order of the requests, events, failures, report fields, judgement."""

import errno
import json
from types import SimpleNamespace

import numpy as np
import pytest

from mmcs import logcols, mcdef
from mmcs.errors import RunError
from mmcs.runs import runner, session
from mmcs.runs.expect import judge
from mmcs.runs.report import make_report, write_log, write_report
from mmcs.runs.session import Session
from mmcs.scenario.load import load
from mmcs.scenario.scenario import RefusedExpect
from mmcs.tests.conftest import GOOD, good, one_clear_line
from mmcs.tests.fake import FakeSim


def run(path, sim=None, **options):
    setup = load(str(path), (), **options)
    sim = sim or FakeSim(setup.axes)
    return sim, Session(sim, setup).run()


def test_requests_in_the_order_of_a_user_program(scenario):
    sim, _ = run(scenario())
    driver = {"axes": 1, "verbose": 0, "interval_us": 1000, "double_buffer": 1}
    assert sim.calls == [("begin", driver, 1), ("MSTOP", None), ("close", 0)]
    assert [(s["kind"], s["t0"], s["to"]) for s in sim.segments] == [
        (mcdef.SEGMENT_KINDS.index("step"), 0.05, 200)
    ]


def test_events_are_given_with_what_heals_them(scenario):
    text = '\n[[event]]\nat = 0.1\ninput = "cable_cut"\nvalue = 1\nuntil = 0.2\n'
    text = GOOD + text.replace("cable_cut", "estop")
    sim, _ = run(scenario(text))
    expected = {"at": 0.1, "until": 0.2, "input": 0, "index": 0, "value": 1.0}
    assert sim.events == [expected | {"at_power_on": 0}]


@pytest.mark.parametrize(
    ("request_name", "number", "line"),
    [
        ("open", 6, "open: ENXIO (No such device or address)"),
        ("MSETNUMJOINTS 1", 22, "MSETNUMJOINTS 1: EINVAL (Invalid argument)"),
        ("MSETPARAM of axis 0", 22, "MSETPARAM of axis 0: EINVAL (Invalid argument)"),
        ("MENABLE", 5, "MENABLE: EIO (Input/output error)"),
    ],
)
def test_refused_request_ends_the_run(scenario, request_name, number, line):
    sim = FakeSim(1, fail={request_name: number})
    with pytest.raises(RunError) as failure:
        run(scenario(), sim)
    assert str(failure.value) == line


@pytest.mark.parametrize(("refused", "granted"), [(0, 0), (1, 0), (2, 1)])
def test_an_expected_refusal_is_of_one_request(refused, granted):
    """A second one of the same request is a failure that nobody expected."""
    entry = RefusedExpect(kind="refused", request="MENABLE", error="EIO")
    result = SimpleNamespace(
        setup=SimpleNamespace(scenario=SimpleNamespace(expect=[entry])),
        refused=refused * [("MENABLE", errno.EIO)], assertion=False, ended="",
    )  # fmt: skip
    assert [v["ok"] for v in judge(result, [])] == [refused > 0] + granted * [False]


@pytest.fixture
def fake_machine(monkeypatch):
    """`mmcs run` on a fake; options of FakeSim go into the dictionary."""
    options = {}

    def simulate(setup, trace=None, realtime=False, host="native", **_):
        return Session(FakeSim(setup.axes, **options), setup, realtime).run()

    monkeypatch.setattr(runner, "simulate", simulate)
    return options


FIELDS = {
    "scenario", "simulated_s", "wall_s", "rtf", "clk_hz", "cycles", "hash", "host", "cards",
    "axes", "stats", "events", "expect",
}  # fmt: skip


@pytest.mark.parametrize("started", ["abc", "nan", "inf", "-5", "1e999"])
def test_a_start_of_make_that_cannot_be_is_not_looked_at(
    mmcs, scenario, fake_machine, tmp_path, monkeypatch, started
):
    monkeypatch.setenv("MMCS_STARTED", started)
    text = mmcs("run", scenario(), "-v", "--out", tmp_path / "results")[1]
    assert 0 <= float(text.split("time to first motion ")[1].split()[0]) < runner.A_DAY_S


def test_report_log_and_plot(mmcs, scenario, fake_machine, tmp_path):
    out = tmp_path / "results"
    text = good(mmcs("run", scenario(), "--out", out, "--seed", 7), silent=True)
    report = json.loads((out / "report.json").read_text())
    assert report.keys() >= FIELDS
    assert (report["scenario"], report["host"], report["cards"]) == ("test", "native", 1)
    assert (report["clk_hz"], report["seed"]) == (8_000_000, 7)
    assert report["cycles"] == round(report["simulated_s"] * 8e6)
    axis = report["axes"][0]
    assert axis.keys() >= {"axis", "rise_ms", "overshoot_pct", "settle_ms", "steady_error_counts"}
    assert axis["rise_ms"] == pytest.approx(43.9, abs=1)
    assert report["stats"].keys() >= {"interrupts", "missed", "overruns", "panics"}
    lines = (out / "log.csv").read_text().splitlines()
    names = "setpoint_0,encoder_0,velocity_0,error_0,current_0,errcode_0,angle_rad_0"
    assert lines[0] == "t_s," + names
    assert len(lines) == 301
    assert lines[-1].startswith("0.300000,200,200,0,0,0,0,0.")
    picture = (out / "plot.svg").read_text()
    assert picture.startswith("<?xml") and "setpoint" in picture and "current" in picture
    for word in ("real-time factor", "hash 0x", "axis", f"{out}/plot.svg", "next: mmcs trace"):
        assert word in text
    assert "model's cache" not in text and "time to first motion" not in text


def test_log_of_two_axes_has_its_columns_in_order(scenario, tmp_path):
    text = GOOD.replace("lab500", "puma560").replace("cards = 1", "cards = 3")
    _, result = run(scenario(text))
    write_log(result, tmp_path)
    table = np.genfromtxt(tmp_path / "log.csv", delimiter=",", names=True)
    assert list(table.dtype.names) == logcols.header(6)
    assert table["encoder_0"][-1] == 200
    assert table["encoder_5"][-1] == 0


EXPECT = """
[[expect]]
kind = "axis"
rise_ms = {rise}
final_counts = [195, 205]

[[expect]]
kind = "stats"
missed = 0
"""


def test_expectations_decide_the_status(mmcs, scenario, fake_machine, tmp_path):
    out = tmp_path / "o"
    text = good(mmcs("run", scenario(GOOD + EXPECT.format(rise="[40, 50]")), "--out", out))
    assert "ok      axis 0 rise in 40..50 ms: 43.8" in text
    assert "ok      missed = 0: 0" in text
    status, text, _ = mmcs("run", scenario(GOOD + EXPECT.format(rise="[1, 2]")), "--out", out)
    assert status == 1
    assert "FAILED  axis 0 rise in 1..2 ms: 43.8" in text
    report = json.loads((out / "report.json").read_text())
    assert [item["ok"] for item in report["expect"]] == [False, True, True]


def test_a_band_for_each_axis(mmcs, scenario, fake_machine, tmp_path):
    text = GOOD.replace("lab500", "puma560").replace("cards = 1", "cards = 3")

    def judged(bands):
        expect = f'[[expect]]\nkind = "axis"\naxis = [0, 1]\nfinal_counts = {bands}\n'
        return mmcs("run", scenario(text + expect), "--out", tmp_path)

    assert judged([[195, 205], [0, 0]])[0] == 0
    status, out, _ = judged([[0, 0], [195, 205]])
    assert status == 1 and "FAILED  axis 0 final position = 0 counts: 200" in out
    one_clear_line(judged([[195, 205]]), "must have 2 bands, one per axis named")


def test_axis_that_never_rises_fails_its_expectation(mmcs, scenario, fake_machine, tmp_path):
    fake_machine["short"] = 50.0
    path = scenario(GOOD + EXPECT.format(rise="[40, 50]"))
    status, text, _ = mmcs("run", path, "--out", tmp_path)
    assert status == 1
    assert "FAILED  axis 0 rise in 40..50 ms: never" in text


def test_expected_events(mmcs, scenario, fake_machine, tmp_path):
    fake_machine["notes"] = [{"t": 0.1, "kind": "panic", "axis": -1, "text": "button"}]
    event = '\n[[expect]]\nkind = "event"\nevent = "panic"\n{}\n'

    def judged(more):
        return mmcs("run", scenario(GOOD + event.format(more)), "--out", tmp_path)[0]

    assert judged("") == 0
    assert judged("within_ms = 101.0") == 0
    assert judged("within_ms = 99.0") == 1
    assert judged("after = 0.2") == 1
    assert judged('text = "cable"') == 1
    assert judged("seen = false") == 1
    assert judged("axis = 0") == 1
    event = event.replace('"panic"', '["error", "panic"]')  # any of them
    assert judged("") == 0 and judged("seen = false") == 1 and judged('text = "cable"') == 1


def test_expected_hash(scenario, tmp_path):
    _, result = run(scenario())
    for digest, met in ((result.hash, True), ("0x" + "0" * 16, False)):
        text = GOOD + f'\n[[expect]]\nkind = "hash"\nhash = "{digest}"\n'
        _, again = run(scenario(text))
        assert make_report(again, "native")["expect"][0]["ok"] is met


def test_failed_assertion_of_the_machine_fails_the_run(mmcs, scenario, fake_machine, tmp_path):
    fake_machine["assert_at"] = 0.1
    status, text, _ = mmcs("run", scenario(), "--out", tmp_path)
    assert status == 1
    assert "FAILED  no assertion of the machine fails: boom" in text


def test_run_that_ends_before_its_first_sample(scenario, tmp_path):
    sim, result = run(scenario(), FakeSim(1, assert_at=0.0), duration=0.06)
    report = make_report(result, "native")
    write_report(report, tmp_path)
    assert report["axes"][0]["rise_ms"] is None


def test_set_and_duration(scenario):
    setup = load(str(scenario()), ("servo=[{a0=5}]", "motion.0.to=-7"), duration=0.2)
    assert setup.params[0]["a0"] == 5
    assert setup.segments[0]["to"] == -7
    assert setup.scenario.duration == 0.2


def test_units(scenario):
    """A degree of the joint is 1/360 of a turn of the joint: counts times gear."""
    text = GOOD.replace("lab500", "puma560").replace("cards = 1", "cards = 3")
    setup = load(str(scenario(text.replace("to = 200", 'to = 1\nunit = "deg"'))), ())
    assert setup.segments[0]["to"] == pytest.approx(-62.6111 * 1000 / 360)


def test_list_show_check(mmcs):
    names = [line.split()[0] for line in good(mmcs("list")).splitlines()]
    assert {"lab500", "puma560"} <= set(names)
    for name in names[::10]:
        good(mmcs("check", name), silent=True)
        assert name in good(mmcs("show", name), silent=True)


class Wall:
    """A clock on the wall that moves by sleep, and by what each step of the run costs."""

    def __init__(self, cost_s=0.0):
        self.now, self.cost_s, self.slept = 1000.0, cost_s, []

    def perf_counter(self):
        self.now += self.cost_s
        return self.now

    time = perf_counter

    def sleep(self, s):
        assert s >= 0
        self.slept.append(s)
        self.now += s


def test_real_time_run_waits_for_the_wall(scenario, monkeypatch):
    wall, marks = Wall(), []
    monkeypatch.setattr(session, "time", wall)
    setup = load(str(scenario()))
    Session(FakeSim(setup.axes), setup, True).run(lambda t: marks.append((t, wall.now)))
    assert sum(wall.slept) == pytest.approx(0.3)
    for t, at in marks:
        assert at - 1000.0 == pytest.approx(t), "never ahead, never behind"


def test_real_time_run_that_is_too_slow_never_waits(scenario, monkeypatch):
    wall = Wall(cost_s=1.0)
    monkeypatch.setattr(session, "time", wall)
    setup = load(str(scenario()))
    Session(FakeSim(setup.axes), setup, True).run()
    assert sum(wall.slept) == 0


def test_real_time_option_reaches_the_session(mmcs, scenario, fake_machine, tmp_path, monkeypatch):
    wall = Wall()
    monkeypatch.setattr(session, "time", wall)
    good(mmcs("run", scenario(), "--realtime", "--out", tmp_path / "out"), silent=True)
    assert sum(wall.slept) == pytest.approx(0.3)


def test_a_dash_in_the_table_is_explained_under_it(mmcs, scenario, fake_machine, tmp_path):
    text = mmcs("run", scenario(), "--out", tmp_path / "step")[1]
    assert "-: not a step" not in text
    ramp = GOOD.replace('kind = "step"', 'kind = "ramp"').replace(
        "to = 200", "to = 200\nduration = 0.1"
    )
    text = mmcs("run", scenario(ramp), "--out", tmp_path / "ramp")[1]
    assert (
        "-: not a step, or never there (rise: 90 % of the step; settled: within 2 % of it)" in text
    )


def test_a_run_of_another_host_has_a_folder_of_its_own(mmcs, scenario, fake_machine, monkeypatch):
    path = scenario()
    for host in ("native", "m68020"):
        mmcs("run", path, "--host", host)
    found = {folder.name for folder in (path.parent / "runs").iterdir()}
    assert found == {path.stem, f"{path.stem}-m68020"}
