# SPDX-License-Identifier: Apache-2.0
"""mmcs sweep: rows that depend on nothing but the plan, whatever happens to workers."""

import csv
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from importlib import import_module
from types import SimpleNamespace

import pytest

from mmcs import ROOT
from mmcs.errors import RunError
from mmcs.scenario.load import load
from mmcs.sweeps import workers as sweep_run
from mmcs.sweeps.plan import make_plan
from mmcs.sweeps.store import Store
from mmcs.tests.conftest import GOOD, call, cluster, good, one_clear_line

SHORT = GOOD.replace("duration = 0.3", "duration = 0.08")
GAINS = ("--grid", "axis.0.b0=80,100", "--random", "seed=1..1000", "--samples", "4")


def rows_of(folder):
    with (folder / "table.csv").open(newline="") as file:
        return list(csv.DictReader(file))


# --- how it is run -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The sweep GAINS in one worker: (scenario, its table)."""
    folder = tmp_path_factory.mktemp("sweep")
    path = folder / "short.toml"
    path.write_text(SHORT)
    said = good(call("sweep", path, *GAINS, "--workers", 1, "--out", folder / "out"))
    return path, folder / "out", said


def test_two_workers_one_of_them_killed(undisturbed):
    """The killed worker's run is repeated; every row is there once, and the same."""
    path, folder, _ = undisturbed
    plan = make_plan(str(path), (GAINS[1],), (GAINS[3],), 4, 1)
    tasks = ((n, plan.setup(plan.values(n))) for n in range(len(plan)))
    rows, killed = {}, False
    flow = sweep_run.run_here(tasks, 2)
    for n, row in flow:
        assert n not in rows
        rows[n] = row
        if not killed:
            multiprocessing.active_children()[0].kill()
            killed = True
    assert {str(n): row["hash"] for n, row in rows.items()} == {
        row["run"]: row["hash"] for row in rows_of(folder)
    }


class Deadly:
    """A setup that ends whoever takes it out of the pipe."""

    def __reduce__(self):
        return os._exit, (9,)


def test_a_run_that_always_kills_its_worker_is_one_failed_row(undisturbed):
    setup = load(str(undisturbed[0]))
    tasks = iter([(0, setup), (1, Deadly()), (2, setup)])
    rows = dict(sweep_run.run_here(tasks, 2))
    assert rows[1] == sweep_run.failed("the worker died 3 times in this run")
    assert rows[0]["status"] == rows[2]["status"] == "ok" and rows[0]["hash"] == rows[2]["hash"]


# --- stopped and taken up again ----------------------------------------------------------------


def test_resume_runs_only_what_is_missing(mmcs, undisturbed, tmp_path, monkeypatch):
    path, folder, _ = undisturbed
    lines = (folder / "rows.jsonl").read_text().splitlines(keepends=True)
    torn = tmp_path / "out" / "rows.jsonl"
    torn.parent.mkdir()
    torn.write_text("".join(lines[:6]) + lines[6][:40])  # the plan, five rows, half a row
    ran = []
    here = sweep_run.run_here

    def counting(*args):
        for result in here(*args):
            ran.append(result[0])
            yield result

    monkeypatch.setattr(sweep_run, "run_here", counting)
    arguments = ("--out", tmp_path / "out", "--resume", "--workers", 1)
    good(mmcs("sweep", path, *GAINS, *arguments))
    assert len(ran) == 3
    assert rows_of(tmp_path / "out") == rows_of(folder)
    answer = mmcs("sweep", path, *GAINS, *arguments, "--seed", 2)
    one_clear_line(answer, "is another sweep (values, seed, scenario or build differ)")
    more = (*GAINS[:-1], "5")
    assert mmcs("sweep", path, *more, *arguments)[0] == 0  # one sample more: two runs more
    assert len(ran) == 5 and len(rows_of(tmp_path / "out")) == 10


def test_interrupted_keeps_what_is_done(undisturbed, tmp_path):
    path, out = undisturbed[0], tmp_path / "out"
    command = [sys.executable, "-m", "mmcs", "sweep", str(path), "--random", "seed=1..1000",
               "--samples", "100000", "--workers", "1", "--out", str(out)]  # fmt: skip
    process = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
        # a shell's background job ignores it, and so would a child of one
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509
    )  # fmt: skip
    try:
        rows = out / "rows.jsonl"
        while not rows.exists() or rows.read_text().count("\n") < 4:
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        text = process.communicate()[0]
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    assert process.returncode == 130, text
    kept = [json.loads(line) for line in rows.read_text().splitlines()][1:]
    assert f"stopped after {len(kept)} of 100000 runs; go on with --resume" in text
    assert len(rows_of(out)) == len(kept) >= 3
    assert "Traceback" not in text


# --- Dask --------------------------------------------------------------------------------------


@pytest.mark.slow  # a scheduler and two workers start, and one of them twice
def test_same_table_from_dask_with_a_worker_killed(mmcs, undisturbed, tmp_path, monkeypatch):
    path, folder, _ = undisturbed
    two, add, killed = cluster(2), Store.add, []

    def add_and_kill(store, n, row):
        add(store, n, row)
        if not killed:
            victim = next(iter(two.workers.values())).pid
            os.kill(victim, signal.SIGKILL)
            killed.append(victim)

    monkeypatch.setattr(Store, "add", add_and_kill)
    with two:
        address = two.scheduler_address
        good(mmcs("sweep", path, *GAINS, "--dask", address, "--out", tmp_path / "out"))
    assert killed
    assert rows_of(tmp_path / "out") == rows_of(folder)


@pytest.mark.parametrize("gone", [OSError("reset"), CancelledError(), "cancelled", "lost"])
def test_scheduler_or_worker_that_goes_while_an_answer_is_fetched(gone, monkeypatch):
    """A worker's runs are made again, as often as in a pool; the scheduler is not blamed."""

    class Future:
        status = gone if isinstance(gone, str) else "finished"

        def result(self):
            raise gone

    with pytest.raises(RunError, match="the Dask scheduler is gone; go on later with --resume"):
        sweep_run._answer(SimpleNamespace(status="closed"), Future())

    class Flow(list):
        def __init__(self, loop):
            self.add = self.append

        def __iter__(self):
            while self:
                yield self.pop()

    starts = []
    submit = lambda *given, **_: starts.append(given) or Future()  # noqa: E731
    client = SimpleNamespace(status="running", run_on_scheduler=lambda f: f(), loop=None,
                             submit=submit, nthreads=dict, cancel=print)  # fmt: skip
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(as_completed=Flow))
    rows = dict(sweep_run.run_dask(client, iter([(7, "task")]), lambda setup: "build"))
    assert rows == {7: sweep_run.failed("the worker died 3 times in this run")}
    assert len(starts) == 3


def test_progress_on_no_terminal_tells_the_time_left(monkeypatch, capsys):
    module = import_module("mmcs.cli.sweep")
    monkeypatch.setattr(module, "TELL_EACH_S", -1.0)
    clock = iter((50.0, 60.0, 60.0))  # begun, asked, told
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    store = SimpleNamespace(rows={0: {}}, bad=0)
    with module.progress(21, store, "runs") as advance:
        store.rows |= {n: {} for n in range(1, 11)}
        advance()
    assert capsys.readouterr().err == "mmcs: 11 of 21 runs, about 10 s left\n"
