# SPDX-License-Identifier: Apache-2.0
"""Carries out the rows of a sweep: one run in a worker, the workers here, the workers of Dask.

A run leaves no files, only its figures. A worker that dies takes nothing along but the run it was
at, which another one repeats.
"""

import contextlib
import functools
import math
import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from types import ModuleType

import numpy as np

from mmcs import logcols
from mmcs.errors import InputError, RunError
from mmcs.place import installs
from mmcs.runs.machine import build_of, library_of, machine

CONNECT_S = 10  # to the scheduler
ATTEMPTS = 3  # deaths of workers in one row before the row counts as failed
WORST = (
    "rise_ms", "overshoot_pct", "settle_ms", "steady_error_counts", "rms_error_counts",
    "peak_error_counts", "peak_current",
)  # fmt: skip
RESPONSE = ("rise_ms", "settle_ms")
STATS = ("interrupts", "missed", "overruns", "panics", "clips", "bus_errors")


# --- one run -----------------------------------------------------------------------------------


def failed(why: str) -> dict:
    return {"status": "failed", "unmet": None, "why": why}


def or_failed(work):
    """work, but what goes wrong is a row, too."""

    @functools.wraps(work)
    def guarded(task) -> dict:
        try:
            return work(task)
        except (RunError, InputError) as error:
            return failed(str(error))
        except Exception as error:
            return failed(f"{type(error).__name__}: {error}")

    return guarded


@or_failed
def run_row(setup) -> dict:
    """Runs a setup and gives its figures."""
    from mmcs.runs.expect import judge
    from mmcs.runs.report import measure
    from mmcs.runs.session import session_of

    with machine(setup, library=library_of(setup)) as sim:
        result = session_of(sim, setup, quiet=True).run()
    axes = measure(result)
    verdicts = judge(result, axes)
    unmet = [v["what"] for v in verdicts if not v["ok"]]
    ended = [f"{p['run']}: status {p['status']}" for p in result.processes if p.get("status")]
    stepping = _stepping(setup)
    for n, axis in enumerate(axes):
        error = logcols.column(result.log, n, "error")
        axis["peak_error_counts"] = float(np.abs(error).max()) if len(error) else None
        for name in RESPONSE:  # of an axis that makes a step: None is never
            if axis[name] is None and n in stepping:
                axis[name] = math.inf
    row = {
        "status": "missed" if unmet else "ok",
        "unmet": len(unmet),
        "why": next(iter(unmet + ended), ""),
        "hash": result.hash,
    }
    row |= {name: _worst([a[name] for a in axes]) for name in WORST}
    row |= {name: int(result.stats[name]) for name in STATS}
    row["events"] = sum(note["kind"] != "log" for note in result.notes)
    for axis in axes:
        row |= {f"{name}_{axis['axis']}": axis[name] for name in WORST}
    return row


def _stepping(setup) -> set[int]:
    modes = [p["mode"] for p in setup.params]
    steps = {s["axis"] for s in setup.segments if s["kind"] == "step"}
    return {axis for axis in steps if modes[axis] in ("position", "velocity")}


def _worst(values: list[float | None]) -> float | None:
    """The largest magnitude of those it applies to."""
    return max((abs(v) for v in values if v is not None), default=None)


# --- workers on this machine -------------------------------------------------------------------


def cores() -> int:
    return len(os.sched_getaffinity(0))


def _leave_ctrl_c() -> None:
    """Ctrl-C is for the process that commands."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class _Worker(multiprocessing.context.SpawnProcess):
    """Does not run the user's own file again, which may be a script, a notebook or stdin."""

    @staticmethod
    def _Popen(process):  # noqa: N802
        own = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            return multiprocessing.context.SpawnProcess._Popen(process)
        finally:
            sys.modules["__main__"] = own


class _Spawn(multiprocessing.context.SpawnContext):
    Process = _Worker


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, _Spawn(), initializer=_leave_ctrl_c)


def run_here(
    tasks: Iterator[tuple[object, object]], workers: int, work=run_row
) -> Iterator[tuple[object, dict]]:
    """(number, row) of each (number, task), as they come; work: a function of a module that makes
    rows of tasks. Raises RunError when no worker starts.

    A pool ends with the first worker that dies. The tasks under way are then repeated, one at a
    time: the one that kills its worker alone ATTEMPTS times is a failed row."""
    pool, broken, running, again = _pool(workers), False, {}, deque()
    try:
        _start(pool)
        while True:
            width = 1 if again else workers
            while len(running) < width and not broken:
                entry = again.popleft() if again else (*next(tasks, (None, None)), 0)
                if entry[0] is None:
                    break
                try:
                    running[pool.submit(work, entry[1])] = entry
                except BrokenProcessPool:
                    again.append(entry)
                    broken = True
            if not running and not again:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done if running else ():
                n, given, deaths = running.pop(future)
                if not isinstance(future.exception(), BrokenProcessPool):
                    yield n, _row_of(future)
                    continue
                broken = True
                if deaths + 1 < ATTEMPTS:
                    again.append((n, given, deaths + 1))
                else:
                    yield n, failed(f"the worker died {ATTEMPTS} times in this run")
            if broken and not running:
                _end(pool)
                pool, broken = _pool(workers), False
    finally:
        _end(pool)


def _start(pool: ProcessPoolExecutor) -> None:
    try:
        pool.submit(os.getpid).result()
    except BrokenProcessPool:
        raise RunError("no worker of the sweep starts: it died at once") from None


def _end(pool: ProcessPoolExecutor) -> None:
    for process in list((pool._processes or {}).values()):
        process.kill()  # shutdown() alone waits for the end of its run
    pool.shutdown(cancel_futures=True)


def _row_of(future) -> dict:
    problem = future.exception()
    return failed(f"{type(problem).__name__}: {problem}") if problem else future.result()


# --- workers of Dask ---------------------------------------------------------------------------


def dask_client(address: str):
    """The client of a running scheduler. Raises InputError in one line."""
    try:
        from distributed import Client
    except ImportError:
        allowed = f"needs the package distributed: {installs('dask')}"
        raise InputError.one("--dask", "", address, allowed) from None
    _quiet()
    try:
        client = Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError.one("--dask", "", address, f"no scheduler answers ({why})") from None
    return client


def _quiet() -> None:
    """What goes wrong is told in one line by who calls: not by its own loggers, some of which have
    levels of their own."""
    import logging

    for name in ("distributed", "tornado", *logging.root.manager.loggerDict):
        if name.split(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


_one_at_a_time = threading.Lock()


def run_on(setup, build: str, work, task) -> dict:
    """What a Dask worker does: one run at a time in a process, on the very same simulator."""
    with _one_at_a_time:
        try:
            here = build_of(setup)
        except RunError as error:
            return failed(str(error))
        if here != build:
            return failed(f"the worker's simulator is another build: {here}, not {build}")
        return work(task)


def _answer(client, future) -> dict | None:
    """Of a run that ended; None: its worker is gone, with the answer. Raises RunError when the
    scheduler is."""
    from concurrent.futures import CancelledError

    with contextlib.suppress(OSError, CancelledError):  # it went while this was fetched
        if future.status == "finished":
            return future.result()
        if future.status == "error":
            return _row_of(future)
    with contextlib.suppress(Exception):
        if client.status == "running" and client.run_on_scheduler(int) == 0:
            return None
    raise RunError("the Dask scheduler is gone; go on later with --resume")


def run_dask(
    client, tasks: Iterator[tuple[object, object]], builds, work=run_row, setup_of=lambda task: task
) -> Iterator[tuple[object, dict]]:
    """As run_here(), on the scheduler's workers; Dask itself repeats what a dead one was at.
    setup_of: the setup in a task, which says what simulator it wants."""
    from distributed import as_completed

    numbers, flow = {}, as_completed(loop=client.loop)

    def start(n: object, task: object, deaths: int = 0) -> None:
        setup = setup_of(task)
        future = client.submit(run_on, setup, builds(setup), work, task, pure=False)
        numbers[future] = n, task, deaths
        flow.add(future)

    try:
        for _ in range(max(16, 4 * sum(client.nthreads().values()))):
            if (task := next(tasks, None)) is None:
                break
            start(*task)
        for future in flow:
            n, task, deaths = numbers.pop(future)
            answer = _answer(client, future)
            if answer is None and deaths + 1 < ATTEMPTS:
                start(n, task, deaths + 1)
                continue
            yield n, answer or failed(f"the worker died {ATTEMPTS} times in this run")
            if (task := next(tasks, None)) is not None:
                start(*task)
    finally:
        with contextlib.suppress(Exception):  # the scheduler may be gone
            client.cancel(list(numbers))
