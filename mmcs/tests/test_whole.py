# SPDX-License-Identifier: Apache-2.0
"""Results are of one run and whole, whatever ends it; a record is of what was loaded."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from mmcs import ROBOTS, ROOT
from mmcs.engine.rows import Rows, blocks
from mmcs.engine.sim import Sim
from mmcs.errors import InputError
from mmcs.folder import RESULTS, writing
from mmcs.runs.record import read_record
from mmcs.tests.conftest import GOOD, one_clear_line


def results(folder, generation, names=RESULTS):
    with writing(folder) as stage:
        for name in names:
            (stage / name).write_text(f"{generation} {name}")


def generations(folder):
    """What a reader finds: the generations of all files, and how many there are."""
    texts = [(folder / name).read_text() for name in RESULTS if (folder / name).exists()]
    return {text.split()[0] for text in texts}, len(texts)


def killed_at(step, folder, generation, names):
    """Writes in a process that ends at its so manyth step, as by SIGKILL; how it ended."""
    child = os.fork()
    if child == 0:
        count = 0

        def hook(event, _):
            nonlocal count
            count += event in ("open", "os.rename", "os.remove", "os.mkdir", "os.rmdir")
            if count > step:
                os._exit(9)

        sys.addaudithook(hook)
        results(folder, generation, names)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.parametrize("names", [RESULTS, RESULTS[:3]], ids=["all", "fewer than before"])
def test_killed_at_every_step(tmp_path, names):
    """The earlier results, or no report, or those of the new run alone."""
    step, ended, old = 0, 9, 0
    while ended:
        results(tmp_path, "old")
        ended = killed_at(step, tmp_path, "new", names)
        found = generations(tmp_path)
        if (tmp_path / "report.json").exists():
            assert found in [({"old"}, len(RESULTS)), ({"new"}, len(names))]
        old += found == ({"old"}, len(RESULTS))
        step += 1
    assert step > 15 and old > 8 and found == ({"new"}, len(names))
    assert {p.name for p in tmp_path.iterdir()} == {*names, ".lock"}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_run_that_is_stopped_leaves_what_was_there(tmp_path, number):
    results(tmp_path, "old")
    command = ["env", "--default-signal=INT,HUP", sys.executable, "-m", "mmcs", "run", "lab500",
               "--duration", "3600", "--out", str(tmp_path)]  # fmt: skip
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        while not (tmp_path / ".new").exists():
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(number)
        told = process.communicate()[1].strip()
    assert (process.returncode, told) == (128 + number, "mmcs: stopped")
    assert generations(tmp_path) == ({"old"}, len(RESULTS)) and not (tmp_path / ".new").exists()


def test_results_are_on_the_disk_before_their_names(tmp_path, monkeypatch):
    steps, replace = [], os.replace
    name = lambda fd: Path(os.readlink(f"/proc/self/fd/{fd}")).name  # noqa: E731
    monkeypatch.setattr(os, "fsync", lambda fd: steps.append(name(fd)))
    monkeypatch.setattr(os, "replace", lambda a, b: steps.append(Path(b).name) or replace(a, b))
    results(tmp_path, "new", ("report.json", "log.csv"))
    assert sorted(steps[:2]) == ["log.csv", "report.json"]
    assert steps[2:] == ["log.csv", "report.json"]


def test_one_run_at_a_time(tmp_path):
    results(tmp_path, "old")
    with writing(tmp_path):
        with pytest.raises(InputError, match="another run is writing here"):
            results(tmp_path, "new")
        assert generations(tmp_path) == ({"old"}, len(RESULTS))  # who reads does not wait
    results(tmp_path, "new", ())
    assert generations(tmp_path) == (set(), 0)


@pytest.fixture
def run(mmcs, scenario, tmp_path):
    """Runs a scenario into tmp_path/out."""
    return lambda text: mmcs("run", scenario(text), "--out", tmp_path / "out")


def test_log_of_another_run_is_refused(mmcs, run, scenario, tmp_path):
    assert run(GOOD)[0] == 0
    log = tmp_path / "out" / "log.csv"
    text = log.read_text()
    log.write_text(text.replace(",200,", ",201,", 1))
    answer = mmcs("compare", tmp_path / "out", tmp_path / "out")
    one_clear_line(answer, "damaged, or of another run than its report.json")
    log.write_text(text)
    assert mmcs("compare", tmp_path / "out", tmp_path / "out")[0] == 0


@pytest.mark.parametrize("seen", [True, False])
def test_what_cannot_be_decided_is_not_met(run, answers, seen):
    """Events beyond those that are kept may have been panics or not."""
    expect = f'[[expect]]\nkind = "event"\nevent = "panic"\nseen = {str(seen).lower()}\n'
    answers["notes"] = lambda: [{"t": 0.1, "kind": "fault", "axis": 0, "text": "x"}]
    answers["notes_lost"] = lambda: 7
    status, out, _ = run(GOOD + expect)
    assert status == 1
    assert "cannot be decided, only the first 1 of 8 events are kept, up to 0.100 s" in out
    assert "7 further events are not kept" in out
    answers["notes_lost"] = lambda: 0
    status, out, _ = run(GOOD + expect)
    assert (status == 0) is (not seen) and "not kept" not in out


def test_record_is_of_what_was_loaded(run, tmp_path, monkeypatch):
    """Robot and table are edited, or gone, while the run goes on."""
    robot, table = tmp_path / "mine.toml", tmp_path / "t.csv"
    before = (ROBOTS / "lab500.toml").read_text()
    robot.write_text(before)
    table.write_text("0\n10\n")
    text = GOOD.replace('"lab500"', '"./mine.toml"') + (
        '[[motion]]\naxis = 0\nkind = "table"\nat = 0.2\nduration = 0.1\nfile = "t.csv"\n'
    )

    genuine = Sim.new_script

    def edit(self, *given):
        robot.write_text("rubbish")
        table.unlink()
        return genuine(self, *given)

    monkeypatch.setattr(Sim, "new_script", edit)
    assert run(text)[0] == 0
    record = read_record(str(tmp_path / "out"))
    assert record.files == {"robot.toml": before, "table1.csv": "0\n10\n"}
    assert record.setup().axes == 1


# --- out of memory -----------------------------------------------------------------------------


@pytest.mark.parametrize(("engine", "why"), [(False, "out of memory"), (True, "no room")])
def test_results_until_memory_was_full(run, tmp_path, monkeypatch, engine, why):
    """In Python or in the engine."""
    genuine = Sim.play

    def play(sim, script, until):
        if until < 0.15:
            return genuine(sim, script, until)
        if not engine:
            raise MemoryError
        return 1, ""

    monkeypatch.setattr(Sim, "play", play)
    if engine:
        note = {"t": 0.15, "kind": "log", "axis": -1, "text": "no room"}
        monkeypatch.setattr(Sim, "notes", lambda _: [note])
    status, out, err = run(GOOD)
    assert status == 1 and "Traceback" not in err
    assert f"the run goes to its end: {why} at 0.1" in out
    rows = (tmp_path / "out" / "log.csv").read_text().splitlines()
    assert len(rows) > 100 and (tmp_path / "out" / "run.mmcs").exists()


# --- rows --------------------------------------------------------------------------------------


@pytest.mark.parametrize("in_memory", [0, 1 << 20], ids=["file", "memory"])
def test_rows_are_an_array(in_memory):
    rows, whole = Rows(3, in_memory), np.arange(30_000.0).reshape(-1, 3)
    for start in range(0, 10_000, 7):
        rows.append(whole[start : start + 7])
        assert len(rows) == min(start + 7, len(whole))
        if start % 2_800 == 0:  # between two of them, too
            assert np.array_equal(rows.array(), whole[: len(rows)])
    assert np.array_equal(rows.array(), whole)
    assert rows.array().flags.writeable is bool(in_memory), "in memory, or a file's"
    assert np.array_equal(np.concatenate(list(blocks(rows.array()))), whole)
