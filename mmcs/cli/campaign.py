# SPDX-License-Identifier: Apache-2.0
"""`mmcs campaign`: very many faults in some motions, each beside its fault-free twin."""

import shlex
import sys
from pathlib import Path

import click

from mmcs.cli.sweep import carry_out, check_workers, ended, kept, many_runs
from mmcs.errors import InputError
from mmcs.place import SCENARIOS, results
from mmcs.screen import echo


@click.command()
@click.argument("motions", nargs=-1, metavar="[SCENARIO]...")
@click.option("--faults", "count", type=int, default=1000, metavar="N", help="How many; 1000.")
@click.option("--stops", is_flag=True, help="Degrees moved after each way to stop ROBOT, SCENARIO.")
@click.option("--seed", type=int, default=1, metavar="S", help="Seed of the faults; 1.")
@click.option("--sort", "sorts", metavar="A,B", help="register, line, pin, message, kill; all.")
@many_runs("campaign")
def campaign(motions, count, stops, seed, sorts, sets, workers, dask, out, resume) -> None:
    """Inject random faults, one in each run, and classify them. Status 0 done, 2 bad input.

    Fault N is the same in every campaign of the same seed, motions and sorts.
    """
    from mmcs.sweeps.campaign import make_plan
    from mmcs.sweeps.plan import MAX_RUNS
    from mmcs.sweeps.twin import Twin
    from mmcs.sweeps.workers import cores

    if not 1 <= count <= MAX_RUNS:
        raise InputError.one("--faults", "", count, f"must be 1 to {MAX_RUNS}")
    check_workers(workers, dask)
    if stops:
        if dask or resume or sorts:
            allowed = "goes with scenarios, a robot, --set, --workers and --out alone"
            raise InputError.one("--stops", "", None, allowed)
        sys.exit(_stops(motions, sets, workers or cores(), out))
    chosen = tuple(word.strip() for word in sorts.split(",")) if sorts else ()
    plan = make_plan(motions, chosen, seed, sets)
    for setup in plan.setups.values():
        Twin(setup).close()
    first = plan.setups[plan.names[0]]
    own = (setup.path for setup in plan.setups.values() if SCENARIOS not in setup.path.parents)
    named = "-".join(Path(motion).stem for motion in motions) or "all"
    folder = out or results("campaigns", next(own, None)) / named[:100]
    with kept(folder, plan, first, resume, dask, "campaign") as (store, client):
        whole = _run(plan, store, client, workers or cores(), count)
    command = ["mmcs", "campaign", *motions, "--faults", str(count), "--seed", str(seed)]
    command += ["--sort", sorts] if sorts else []
    command += [word for text in sets for word in ("--set", text)]
    sys.exit(_finish(plan, store.rows, folder, shlex.join(command), whole))


def _stops(words, sets, workers: int, out: Path | None) -> int:
    from mmcs.folder import check_folder, whole_file
    from mmcs.sweeps.campaign_report import REPORT
    from mmcs.sweeps.stops import MOMENTS, markdown, motions, run_motion, worst
    from mmcs.sweeps.workers import run_here

    setups, left = motions(words, sets)
    folder = out or results("campaigns") / f"stops-{'-'.join(Path(word).stem for word in words)}"
    check_folder(folder)
    tasks = iter([(setup.name, (setup, MOMENTS)) for setup in setups])
    found = dict(run_here(tasks, min(workers, len(setups)), run_motion))
    left |= {name: one["why"] for name, one in found.items() if "moved" not in one}
    found = {setup.name: found[setup.name] for setup in setups if setup.name not in left}
    for name, why in left.items():
        echo(f"left out: {name}: {why}")
    if not found:
        raise InputError.one("--stops", "", " ".join(words), "no motion is left")
    table = markdown(*worst(found, setups))
    with whole_file(folder / REPORT) as part:
        part.write_text(table)
    echo(table)
    return ended(folder, REPORT, "", False)


def _run(plan, store, client, workers: int, count: int) -> bool:
    """Runs what is not yet in the store; False when stopped by hand."""
    from mmcs.sweeps.campaign import run_chunk

    todo = [n for n in range(count) if n not in store.rows]
    chunks = list(plan.chunks(todo))
    while chunks:
        crew = min(workers, len(chunks))
        lost = carry_out(
            store, count, iter(chunks), client, crew, run_chunk, "faults", lambda task: task[0]
        )
        if lost is None:
            return False
        # the faults of a chunk that did not end: one of them may be the cause
        chunks = [((n,), plan.task(plan.fault(n).motion, (n,))) for n in lost]
    return True


def _finish(plan, rows: dict[int, dict], folder: Path, command: str, whole: bool) -> int:
    """Writes and prints what there is; the exit status."""
    from mmcs.sweeps.campaign_report import REPORT, print_summary, write_report

    rows = {n: rows[n] for n in sorted(rows)}
    if rows:
        write_report(folder, plan, rows, command)
        print_summary(plan, rows)
    lost = sum(row["status"] == "failed" for row in rows.values())
    if lost:
        echo(f"{lost} of {len(rows)} faults could not be run")
    return ended(folder, REPORT, "" if whole else f"{len(rows)} faults", bool(lost))
