# SPDX-License-Identifier: Apache-2.0
"""`mmcs sweep`: many runs of a scenario over a grid or a random sample of its values."""

import functools
import sys
import time
from contextlib import ExitStack, closing, contextmanager
from itertools import chain
from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.place import results
from mmcs.screen import echo
from mmcs.screen import progress as bar

TELL_EACH_S = 10.0  # without a terminal, a line so often


def many_runs(what: str):
    """The options of a command that makes very many runs."""
    option, folder = click.option, click.Path(path_type=Path)
    options = (
        option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="As of `mmcs run`."),
        option("--workers", type=int, metavar="N", help="Processes; as many as there are cores."),
        option("--dask", metavar="ADDRESS", help="Run on the workers of this Dask scheduler."),
        option("--out", type=folder, metavar="DIR", help="Where results go."),
        option("--resume", is_flag=True, help=f"Go on with a {what} that was stopped."),
    )
    return lambda command: functools.reduce(lambda made, add: add(made), options[::-1], command)


def check_workers(workers: int | None, dask: str | None) -> None:
    if workers is not None and not 1 <= workers <= 256:
        raise InputError.one("--workers", "", workers, "must be 1 to 256")
    if workers is not None and dask:
        raise InputError.one("--workers", "", workers, "is of this machine: not with --dask")


@contextmanager
def kept(folder: Path, plan, setup, resume: bool, dask: str | None, what: str):
    """The store of the rows there, and Dask's client or None."""
    from mmcs.folder import check_folder
    from mmcs.runs.machine import build_of
    from mmcs.sweeps.store import Store, check_resume
    from mmcs.sweeps.workers import dask_client

    if resume:
        check_resume(folder, what)
    with ExitStack() as ends:
        client = ends.enter_context(closing(dask_client(dask))) if dask else None
        check_folder(folder)
        store = Store(folder, plan.identity(build_of(setup)), resume, what)
        yield ends.enter_context(closing(store)), client


@click.command()
@click.argument("scenario", metavar="SCENARIO")
@click.option("--grid", multiple=True, metavar="KEY=V1,V2|A..B[:N]", help="Values, all combined.")
@click.option("--random", "drawn", multiple=True, metavar="KEY=A..B[:log]|V1,V2", help="Drawn.")
@click.option("--samples", type=int, metavar="N", help="Draws of --random; 100 if not said.")
@click.option("--seed", type=int, default=1, metavar="S", help="Seed of the draws; 1.")
@many_runs("sweep")
def sweep(scenario, grid, drawn, samples, seed, sets, workers, dask, out, resume):
    """Run a scenario over many values: status 0 all met, 1 some missed or failed, 2 bad input.

    --grid combines all values of all grids; --random draws, the same draws at every grid point.
    """
    from mmcs.sweeps.plan import make_plan
    from mmcs.sweeps.workers import cores, failed, run_row

    check_workers(workers, dask)
    plan = make_plan(scenario, grid, drawn, samples, seed, sets)
    first = plan.first()
    folder = out or results("sweeps", plan.path) / first.name
    with kept(folder, plan, first, resume, dask, "sweep") as (store, client):
        tasks = plan.tasks(store.rows, lambda n, why: store.add(n, failed(why)))
        whole = carry_out(store, len(plan), tasks, client, workers or cores(), run_row) is not None
    sys.exit(_finish(plan, store.rows, folder, whole))


def carry_out(store, total: int, tasks, client, workers: int, work, what: str = "runs",
              setup_of=lambda task: task):  # fmt: skip
    """Puts the rows of tasks, (numbers, task), into the store. The numbers of tasks that ended
    without rows, or None when stopped by hand."""
    from mmcs.runs.machine import build_of
    from mmcs.sweeps.workers import run_dask, run_here

    if (first := next(tasks, None)) is None:
        return []
    tasks = chain([first], tasks)
    if client is None:
        flow = run_here(tasks, min(workers, total), work)
    else:
        flow = run_dask(client, tasks, build_of, work, setup_of)
    began, before, lost = time.perf_counter(), len(store.rows), []
    with closing(flow), progress(total, store, what) as advance:
        try:
            for numbers, answer in flow:
                if "rows" not in answer and len(numbers) > 1:
                    lost += numbers
                    continue
                for n, row in zip(numbers, answer.get("rows", [answer]), strict=True):
                    store.add(n, row)
                advance()
        except KeyboardInterrupt:
            return None
    wall, done = time.perf_counter() - began, len(store.rows) - before
    if done:
        echo(f"{done} {what} in {wall:.1f} s, {done / wall:.1f} a second")
    return lost


@contextmanager
def progress(total: int, store, what: str):
    """A bar if somebody watches, else a line now and then."""
    if not sys.stderr.isatty():
        began = told = time.monotonic()
        before = len(store.rows)

        def tell() -> None:
            nonlocal told
            if time.monotonic() > told + TELL_EACH_S:
                told = time.monotonic()
                done = len(store.rows)
                left = (told - began) * (total - done) / max(1, done - before)
                echo(f"mmcs: {done} of {total} {what}, about {left:.0f} s left", err=True)

        yield tell
        return
    text = f"{{task.completed}}/{{task.total}} {what}"
    with bar(total, text, completed=len(store.rows)) as tell:
        yield lambda: tell(len(store.rows), f"{store.bad} missed or failed" if store.bad else "")


def _finish(plan, rows: dict, folder: Path, whole: bool) -> int:
    """Writes and prints what there is; the exit status."""
    from mmcs.sweeps.store import TABLE, print_summary, write_table

    rows = {n: rows[n] for n in sorted(rows) if n < len(plan)}
    if rows:
        write_table(folder, plan, rows)
        print_summary(plan, rows)
    missed = sum(row["status"] == "missed" for row in rows.values())
    lost = sum(row["status"] == "failed" for row in rows.values())
    if missed or lost:
        echo(f"{missed} of {len(rows)} runs missed an expectation, {lost} failed")
    done = "" if whole else f"{len(rows)} of {len(plan)} runs"
    return ended(folder, TABLE, done, bool(missed or lost))


def ended(folder: Path, files: str, stopped: str, bad: bool) -> int:
    """Prints where the results are, and after what it was stopped; the exit status."""
    from mmcs.files import short

    echo(f"results in {short(folder)}: {files}")
    if stopped:
        echo(f"stopped after {stopped}; go on with --resume")
        return 130
    return int(bad)
