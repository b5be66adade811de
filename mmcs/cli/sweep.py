# SPDX-License-Identifier: Apache-2.0
"""`mmcs sweep`: many runs of a scenario over a grid or a random sample of its values."""

import functools
import sys
import time
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.place import results
from mmcs.screen import console as screen
from mmcs.screen import echo

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
def kept(folder: Path, plan, setup, resume: bool, dask: str | None, what: str, is_row):
    """The store of the rows there, and Dask's client or None."""
    from mmcs.folder import check_folder
    from mmcs.runs.machine import build_of
    from mmcs.sweeps.store import Store, check_resume
    from mmcs.sweeps.workers import dask_client

    if resume:
        check_resume(folder, what)
    check_folder(folder)
    with ExitStack() as ends:
        client = ends.enter_context(closing(dask_client(dask))) if dask else None
        store = Store(folder, plan.identity(build_of(setup)), resume, what, is_row)
        yield ends.enter_context(closing(store)), client


@click.command()
@click.argument("scenario", metavar="SCENARIO")
@click.option("--grid", multiple=True, metavar="KEY=V1,V2|A..B[:N]", help="Values, all combined.")
@click.option("--random", "drawn", multiple=True, metavar="KEY=A..B[:log]|V1,V2", help="Drawn.")
@click.option("--samples", type=int, metavar="N", help="Draws of --random; 100 if not said.")
@click.option("--seed", type=int, default=1, metavar="S", help="Seed of the draws; 1.")
@click.option("--duration", type=float, metavar="S", help="Seconds of motion.")
@click.option("--by", default="rms_error_counts", metavar="FIGURE", help="What ranks the runs.")
@click.option("--format", "form", default="csv", metavar="csv|parquet", help="Of the table.")
@many_runs("sweep")
def sweep(
    scenario, grid, drawn, samples, seed, duration, sets, by, workers, dask, out, form, resume
):
    """Run a scenario over many values: status 0 all met, 1 some missed or failed, 2 bad input.

    --grid combines all values of all grids; --random draws, the same draws at every grid point.
    """
    from mmcs.sweeps.plan import make_plan
    from mmcs.sweeps.store import FORMATS, check_figure, check_format, is_row
    from mmcs.sweeps.workers import cores

    if form not in FORMATS:
        raise InputError.one("--format", "", form, "must be csv or parquet")
    check_workers(workers, dask)
    check_format(form)
    plan = make_plan(scenario, grid, drawn, samples, seed, sets, duration)
    for text in plan.cautions():
        echo(f"caution: {text}")
    first = plan.first()
    check_figure(by, first.axes)
    folder = out or results("sweeps", plan.path) / first.name
    with kept(folder, plan, first, resume, dask, "sweep", is_row) as (store, client):
        whole = _run(plan, store, client, workers or cores())
    sys.exit(_finish(plan, store.rows, folder, by, form, whole))


def _run(plan, store, client, workers: int) -> bool:
    """Runs what is not yet in the store; False when stopped by hand."""
    from mmcs.runs.machine import build_of
    from mmcs.sweeps.workers import failed, run_dask, run_here

    todo = [n for n in range(len(plan)) if n not in store.rows]
    impossible = []  # combinations that are no good together

    def tasks():
        for n in todo:
            try:
                setup = plan.setup(plan.values(n))
            except InputError as error:
                impossible.append((n, failed(str(error))))
                continue
            yield n, setup

    if not todo:
        return True
    if client is None:
        flow = run_here(tasks(), min(workers, len(todo)))
    else:
        flow = run_dask(client, tasks(), build_of)
    began = time.perf_counter()
    with progress(len(plan), len(store.rows)) as advance:
        try:
            for n, row, _ in flow:
                store.add(n, row)
                while impossible:
                    store.add(*impossible.pop())
                advance(store.rows)
        except KeyboardInterrupt:
            flow.close()
            return False
        while impossible:
            store.add(*impossible.pop())
    wall = time.perf_counter() - began
    echo(f"{len(todo)} runs in {wall:.1f} s, {len(todo) / wall:.1f} a second")
    return True


@contextmanager
def progress(total: int, done: int, what: str = "runs"):
    """A bar if somebody watches, else a line now and then."""
    if not sys.stderr.isatty():
        told = time.monotonic()

        def tell(rows: dict) -> None:
            nonlocal told
            if time.monotonic() > told + TELL_EACH_S:
                told = time.monotonic()
                echo(f"mmcs: {len(rows)} of {total} {what}", err=True)

        yield tell
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    columns = (MofNCompleteColumn(), TextColumn(what), BarColumn(), Remaining(),
               TextColumn("{task.fields[bad]}"))  # fmt: skip
    bar = Progress(*columns, console=screen(stderr=True), transient=True)
    with bar:
        task = bar.add_task("sweep", total=total, completed=done, bad="")
        bad = 0

        def advance(rows: dict) -> None:
            nonlocal bad
            row = next(reversed(rows.values()))
            bad += row["status"] != "ok"
            bar.update(task, completed=len(rows), bad=f"{bad} missed or failed" if bad else "")

        yield advance


def _finish(plan, rows: dict, folder: Path, by: str, form: str, whole: bool) -> int:
    """Writes and prints what there is; the exit status."""

    from mmcs.files import short
    from mmcs.sweeps.store import print_summary, write_plot, write_table

    console = screen()
    rows = {n: rows[n] for n in sorted(rows) if n < len(plan)}
    if rows:
        write_table(folder, plan, rows, form)
        print_summary(plan, rows, by, console)
        write_plot(folder, plan, rows, by)
    missed = sum(row["status"] == "missed" for row in rows.values())
    lost = sum(row["status"] == "failed" for row in rows.values())
    if missed or lost:
        console.print(f"{missed} of {len(rows)} runs missed an expectation, {lost} failed")
    console.print(f"results in {short(folder)}: table.{form}, plot.svg")
    if not whole:
        console.print(f"stopped after {len(rows)} of {len(plan)} runs; go on with --resume")
        return 130
    return 1 if missed or lost else 0
