# SPDX-License-Identifier: Apache-2.0
"""A run: its last requests, failures, report fields, judgement, real time."""

import json

import pytest

from mmcs import mcdef
from mmcs.engine.sim import Sim
from mmcs.runs import runner, session
from mmcs.runs.runner import simulate
from mmcs.scenario.load import load
from mmcs.tests.conftest import good


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


def test_failed_assertion_of_the_machine_fails_the_run(mmcs, scenario, answers, tmp_path):
    """Before the first sample."""
    answers["play"] = lambda *_: (1, "")
    answers["notes"] = lambda: [{"t": 0.1, "kind": "assert", "axis": -1, "text": "boom"}]
    status, text, _ = mmcs("run", scenario(), "--out", tmp_path)
    assert status == 1
    assert "FAILED  no assertion of the machine fails: boom" in text
    assert json.loads((tmp_path / "report.json").read_text())["axes"][0]["rise_ms"] is None


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
