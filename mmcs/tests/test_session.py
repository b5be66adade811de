# SPDX-License-Identifier: Apache-2.0
"""A run: its last requests, failures, report fields, judgement, real time."""

import errno
import json
from types import SimpleNamespace

import pytest

from mmcs import mcdef
from mmcs.engine.script import Script
from mmcs.engine.sim import Sim
from mmcs.errors import RunError
from mmcs.runs import runner, session
from mmcs.runs.expect import judge
from mmcs.runs.runner import simulate
from mmcs.scenario.load import load
from mmcs.scenario.scenario import RefusedExpect
from mmcs.tests.conftest import GOOD, good, one_clear_line


def run(path, **options):
    return simulate(load(str(path), (), **options))


def test_a_run_ends_with_mstop_and_close(scenario, monkeypatch):
    asked = []
    for name in ("ioctl", "close"):
        genuine = getattr(Sim, name)
        seen = lambda *a, genuine=genuine: asked.append(a[1:]) or genuine(*a)  # noqa: E731
        monkeypatch.setattr(Sim, name, seen)
    run(scenario())
    assert asked == [(0, mcdef.MSTOP), (0,)]


@pytest.mark.parametrize(("request_name", "number", "line"), [
    ("open", 6, "open: ENXIO (No such device or address)"),
    ("MSETNUMJOINTS 1", 22, "MSETNUMJOINTS 1: EINVAL (Invalid argument)"),
    ("MSETPARAM of axis 0", 22, "MSETPARAM of axis 0: EINVAL (Invalid argument)"),
    ("MENABLE", 5, "MENABLE: EIO (Input/output error)"),
])  # fmt: skip
def test_refused_request_ends_the_run(scenario, monkeypatch, request_name, number, line):
    monkeypatch.setattr(Script, "begin", lambda *_: (-number, request_name))
    with pytest.raises(RunError) as failure:
        run(scenario())
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


EXPECT = """
[[expect]]
kind = "axis"
rise_ms = {rise}
final_counts = [190, 210]

[[expect]]
kind = "stats"
missed = 0
"""


def test_expectations_decide_the_status(mmcs, scenario, tmp_path):
    out = tmp_path / "o"
    text = good(mmcs("run", scenario(GOOD + EXPECT.format(rise="[40, 50]")), "--out", out))
    assert "ok      axis 0 rise in 40..50 ms: " in text
    assert "ok      missed = 0: 0" in text
    status, text, _ = mmcs("run", scenario(GOOD + EXPECT.format(rise="[1, 2]")), "--out", out)
    assert status == 1
    assert "FAILED  axis 0 rise in 1..2 ms: " in text
    report = json.loads((out / "report.json").read_text())
    assert [item["ok"] for item in report["expect"]] == [False, True, True]
    path = scenario(GOOD + EXPECT.format(rise="[40, 50]"))
    status, text, _ = mmcs("run", path, "--out", out, "--set", "axis.0.ilim=50")
    assert status == 1 and "FAILED  axis 0 rise in 40..50 ms: never" in text
    peak = EXPECT.replace("final_counts = [1", "peak_error_counts = [1")
    down = GOOD + peak.format(rise="[40, 50]")
    good(mmcs("run", scenario(down), "--out", out, "--set", "motion.0.to=-200"))


def test_a_band_for_each_axis(mmcs, scenario, tmp_path):
    text = GOOD.replace("lab500", "puma560").replace("cards = 1", "cards = 3")

    def judged(bands):
        expect = f'[[expect]]\nkind = "axis"\naxis = [0, 1]\nfinal_counts = {bands}\n'
        return mmcs("run", scenario(text + expect), "--out", tmp_path)

    assert judged([[190, 210], [-9, 9]])[0] == 0
    status, out, _ = judged([[0, 0], [190, 210]])
    assert status == 1 and "FAILED  axis 0 final position = 0 counts: " in out
    one_clear_line(judged([[190, 210]]), "must have 2 bands, one per axis named")


def test_expected_events(scenario, answers):
    begun = run(scenario()).motion_start_s
    note = {"t": begun + 0.1, "kind": "panic", "axis": -1, "text": "button"}
    answers["notes"] = lambda: [note]
    event = '\n[[expect]]\nkind = "event"\nevent = "panic"\n{}\n'

    def met(more, says=""):
        verdict = judge(run(scenario(GOOD + event.format(more))), [])[0]
        return verdict["ok"] and says in verdict["what"]

    assert met("") and met("within_ms = 101.0", "event panic seen within 101 ms: at 100.0 ms")
    for more in ("within_ms = 99.0", "after = 0.2", 'text = "cable"', "seen = false", "axis = 0"):
        assert not met(more), more
    event = event.replace('"panic"', '["error", "panic"]')  # any of them
    assert met("") and not met("seen = false") and not met('text = "cable"')


def test_failed_assertion_of_the_machine_fails_the_run(mmcs, scenario, answers, tmp_path):
    """Before the first sample."""
    answers["play"] = lambda *_: (1, "")
    answers["notes"] = lambda: [{"t": 0.1, "kind": "assert", "axis": -1, "text": "boom"}]
    status, text, _ = mmcs("run", scenario(), "--out", tmp_path)
    assert status == 1
    assert "FAILED  no assertion of the machine fails: boom" in text
    assert json.loads((tmp_path / "report.json").read_text())["axes"][0]["rise_ms"] is None


def test_units(scenario):
    """A degree of the joint is 1/360 of a turn of the joint: counts times gear."""
    text = GOOD.replace("lab500", "puma560").replace("cards = 1", "cards = 3")
    setup = load(str(scenario(text.replace("to = 200", 'to = 1\nunit = "deg"'))), ())
    assert setup.segments[0]["to"] == pytest.approx(-62.6111 * 1000 / 360)


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


@pytest.mark.parametrize(("cost_s", "slept"), [(0.0, 0.3), (1.0, 0.0)])
def test_real_time_run_waits_for_the_wall_unless_it_is_behind(
    mmcs, scenario, tmp_path, monkeypatch, cost_s, slept
):
    wall = Wall(cost_s)
    monkeypatch.setattr(session, "time", wall)
    good(mmcs("run", scenario(), "--realtime", "--out", tmp_path / "out"), silent=True)
    assert sum(wall.slept) == pytest.approx(slept)


def test_a_run_of_another_host_has_a_folder_of_its_own(mmcs, scenario, monkeypatch):
    path, genuine = scenario(), runner.simulate
    monkeypatch.setattr(runner, "simulate", lambda setup, host, **_: genuine(setup))
    for host in ("native", "m68020"):
        mmcs("run", path, "--host", host)
    found = {folder.name for folder in (path.parent / "runs").iterdir()}
    assert found == {path.stem, f"{path.stem}-m68020"}


def test_periods_of_a_process_that_woke_twice_and_of_one_that_never_did():
    pd = SimpleNamespace(kind="pd")
    setup = SimpleNamespace(scenario=SimpleNamespace(process=[pd, pd]))
    script = SimpleNamespace(told=lambda: [(2, 0, 990.04, 1010.06), (0, 0, 0.0, 0.0)])
    told = [list(row.values()) for row in session.summaries(script, setup)]
    assert told == [["pd", 2, 990.0, 1010.1], ["pd", 0, None, None]]
