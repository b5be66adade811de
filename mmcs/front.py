# SPDX-License-Identifier: Apache-2.0
"""The front door of the package: what studies, notebooks and other programs import as `mmcs`.

    run = mmcs.run("lab500", "axis.0.b0=72")        # a scenario, with values as of `mmcs run --set`
    with mmcs.Machine("lab500") as machine:         # in this process, in lock-step
        machine.step([200])

Positions are encoder counts, currents D/A units (2048 = 10 V at the card), times seconds. Bad input
raises InputError, a machine that cannot go on RunError; both have one sentence for each mistake.
docs/use/python.md
"""

from __future__ import annotations

import errno
import io
import os
from array import array
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from mmcs import logcols, mcdef
from mmcs.errors import InputError, RunError
from mmcs.place import installs
from mmcs.scenario.load import load as _load
from mmcs.scenario.setup import Setup

MOST = (1 << 31) - 1  # samples of a wait(), snapshots
STATE = np.dtype([(name, np.int32) for name in mcdef.fields("mc_state")])


def load(scenario: str | Path | Setup, *sets: str, **values) -> Setup:
    """A checked scenario: name, path, or one that is loaded already.

    sets: as of `mmcs run --set`; values: keys of the top level, like seed=3, duration=0.5.
    """
    if isinstance(scenario, Setup):
        if not sets and not values:
            return scenario
        raise InputError.one(scenario.name, "", None, "is loaded: give values where it is loaded")
    return _load(str(scenario), tuple(sets), **values)


class Run:
    """What came out of a run; in a notebook it shows its plot."""

    def __init__(self, result, host: str):
        self.result, self._host = result, host

    @cached_property
    def report(self) -> dict:
        """What `mmcs run` writes into report.json."""
        from mmcs.runs.report import make_report

        return make_report(self.result, self._host)

    @property
    def hash(self) -> str:
        return self.result.hash

    @property
    def ok(self) -> bool:
        """Every expectation of the scenario was met."""
        return all(item["ok"] for item in self.report["expect"])

    @property
    def log(self) -> np.ndarray:
        """(samples, 1 + 7 axes): the columns of log.csv."""
        return self.result.log

    @property
    def axes(self) -> int:
        return self.result.setup.axes

    def column(self, axis: int, name: str) -> np.ndarray:
        """setpoint, encoder, velocity, error, current, errcode or angle_rad of an axis."""
        if name not in logcols.FIELDS:
            allowed = f"must be one of {', '.join(logcols.FIELDS)}"
            raise InputError.one("column", "", name, allowed)
        axis = _whole("axis", axis, 0, self.axes - 1)
        return logcols.column(self.log, axis, name)

    def frame(self):
        """The log as a pandas frame, by time in s."""
        return _frame(self.log, self.axes)

    def plot(self, path: Path | str) -> None:
        """Draws position, joint angle, error and current of each axis, as SVG."""
        from mmcs.folder import check_file, whole_file
        from mmcs.view.plot import write_plot

        if not isinstance(path, str | os.PathLike):
            raise InputError.one("path", "", path, "must be the name of a file")
        with whole_file(check_file(Path(path))) as part:
            write_plot(self.result, part)

    def _repr_svg_(self) -> str:
        from mmcs.view.plot import write_plot

        picture = io.StringIO()
        write_plot(self.result, picture)
        return picture.getvalue()

    def __repr__(self) -> str:
        return f"<run of {self.result.setup.name}: {len(self.log)} samples, hash {self.hash}>"


def run(scenario: str | Path | Setup, *sets: str, host: str = "native", **values) -> Run:
    """Carries a scenario out, without files."""
    from mmcs.runs.runner import simulate

    return Run(simulate(load(scenario, *sets, **values), host=host), host)


def compare(a: Run, b: Run) -> list[dict]:
    """Per axis: the largest difference of encoder, error and current at the samples of both."""
    from mmcs.view.compare import differences

    for name, given in (("a", a), ("b", b)):
        if not isinstance(given, Run):
            raise InputError.one(name, "", given, "must be a run, as run() returns it")
    return differences(a, b)


def sweep(scenario: str, *sets: str, grid: dict | None = None, random: dict | None = None,
          samples: int | None = None, seed: int = 1, workers: int | None = None):  # fmt: skip
    """A pandas frame with a row for each run of `mmcs sweep`: the values, then the figures.

    grid, random: values by key, {"axis.0.b0": [56, 64]} or as typed, {"seed": "1..100"}.
    """
    from mmcs.sweeps.plan import MAX_RUNS, make_plan
    from mmcs.sweeps.workers import cores, failed, run_here

    def typed(name: str, vary: dict | None) -> tuple[str, ...]:
        try:
            texts = {
                k: v if isinstance(v, str) else ",".join(map(str, v))
                for k, v in (vary or {}).items()
            }
        except (AttributeError, TypeError):
            allowed = 'must be values by key, {"seed": [1, 2]} or {"seed": "1..100"}'
            raise InputError.one(name, "", vary, allowed) from None
        return tuple(f"{key}={text}" for key, text in texts.items())

    samples = None if samples is None else _whole("samples", samples, 1, MAX_RUNS)
    crew = cores() if workers is None else _whole("workers", workers, 1)
    plan = make_plan(
        str(scenario), typed("grid", grid), typed("random", random), samples, seed, sets
    )
    rows: dict[int, dict] = {}
    tasks = plan.tasks({}, lambda n, why: rows.update({n: failed(why)}))
    for (n,), row in run_here(tasks, min(crew, len(plan))):
        rows[n] = row
    return _pandas().DataFrame([plan.values(n) | rows[n] for n in range(len(plan))])


def campaign(*motions: str | Path, faults: int = 1000, seed: int = 1, sorts: tuple[str, ...] = (),
             sets: tuple[str, ...] = (), workers: int | None = None):  # fmt: skip
    """A pandas frame with a row for each fault of `mmcs campaign`, by its number.

    motions: scenarios; those of `mmcs campaign` if none. Raises InputError as that refuses.
    """
    from mmcs.sweeps.campaign import make_plan, run_chunk
    from mmcs.sweeps.plan import MAX_RUNS
    from mmcs.sweeps.twin import Twin
    from mmcs.sweeps.workers import cores, run_here

    count = _whole("faults", faults, 1, MAX_RUNS)
    crew = cores() if workers is None else _whole("workers", workers, 1)
    plan = make_plan(tuple(map(str, motions)), tuple(sorts), _whole("seed", seed, 0), tuple(sets))
    for setup in plan.setups.values():
        Twin(setup).close()  # a motion that stops by itself is told here
    chunks = list(plan.chunks(range(count)))
    rows = {}
    for numbers, answer in run_here(iter(chunks), min(crew, len(chunks)), run_chunk):
        rows |= zip(numbers, answer.get("rows", [answer] * len(numbers)), strict=True)
    return _pandas().DataFrame([rows[n] for n in range(count)])


class Machine:
    """A scenario's machine in this process, switched on, its driver open: time passes in step() and
    wait() only, so that a program and the machine share one clock.

    mode: of all axes, in place of the scenario's. Motions of the scenario are left out; its events
    count from the moment at which the machine is ready.
    """

    def __init__(self, scenario: str | Path | Setup, *sets: str, mode: str | None = None, **values):
        from mmcs.runs.machine import machine
        from mmcs.runs.session import Session

        if mode is not None and mode not in mcdef.MODES:
            raise InputError.one("mode", "", mode, f"must be one of {', '.join(mcdef.MODES)}")
        setup = load(scenario, *sets, **values)
        if mode is not None:
            bare = {"mode": mode, "flags": []}
            setup = replace(setup, params=[params | bare for params in setup.params])
        self.setup, self.axes = setup, setup.axes
        self.interval_s = setup.scenario.interval_us * 1e-6
        bare = setup.scenario.model_copy(update={"call": [], "process": []})
        bare = replace(setup, scenario=bare, segments=[])
        self._sim = machine(bare)
        try:
            session = Session(self.sim, bare)
            self._client, self._start = session.begin(), session.start
        except BaseException:
            self.close()
            raise

    @property
    def sim(self):
        """The machine at the C ABI."""
        if self._sim is None:
            raise RunError("the machine is closed: make another")
        return self._sim

    @property
    def time(self) -> float:
        """Seconds since the machine was ready."""
        return self.sim.time - self._start

    @property
    def enabled(self) -> bool:
        """The servo writes the D/As: no stop, no PANIC."""
        return bool(self.sim.stats()["enabled"])

    def write(self, setpoints) -> None:
        """Setpoints of the axes from 0: counts, counts per sample or D/A units, by their modes."""
        try:
            values = [int(value) for value in np.atleast_1d(setpoints)]
            array("i", values)
        except (OverflowError, TypeError, ValueError):
            allowed = "must be whole numbers of 32 bits, one for each axis from 0"
            raise InputError.one("setpoints", "", setpoints, allowed) from None
        self._ask("write", self.sim.write, self._client, values)

    def read(self) -> np.ndarray:
        """struct mc_state of every axis, all of one sample: fields encnow, vel, error, inow, ..."""
        states = self.sim.read(self._client, self.axes)
        return np.array([tuple(state[name] for name in STATE.names) for state in states], STATE)

    def wait(self, samples: int = 1) -> None:
        """Lets so many servo intervals pass."""
        if not self.sim.run(self.sim.time + _whole("samples", samples, 1, MOST) * self.interval_s):
            raise RunError("an assertion of the machine has failed")

    def step(self, setpoints, samples: int = 1) -> np.ndarray:
        """write(), wait() and read()."""
        self.write(setpoints)
        self.wait(samples)
        return self.read()

    def enable(self) -> None:
        """MENABLE, after a stop."""
        self._ask("MENABLE", self.sim.ioctl, self._client, mcdef.MENABLE)

    def stop(self) -> None:
        """MSTOP: no current, brakes."""
        self._ask("MSTOP", self.sim.ioctl, self._client, mcdef.MSTOP)

    def joint(self, axis: int) -> dict[str, float]:
        """The physics, which no register tells: angle and velocity of the joint, current."""
        return self.sim.true(_whole("axis", axis, 0, self.axes - 1))

    def save(self) -> int:
        """A snapshot of this instant, for restore()."""
        return self.sim.snapshot()

    def restore(self, number: int) -> None:
        """Back to a snapshot, to the bit; those taken later are forgotten."""
        self.sim.restore(_whole("number", number, 0, MOST))

    @property
    def log(self) -> np.ndarray:
        """A row for each servo sample so far, as of Run.log."""
        return self.sim.log()

    def frame(self):
        """The log so far as a pandas frame, by time in s."""
        return _frame(self.log, self.axes)

    def close(self) -> None:
        if self._sim is not None:
            self._sim.destroy()
            self._sim = None

    def __enter__(self) -> Machine:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def _ask(self, what: str, request, *arguments) -> None:
        """A request of the driver; RunError with the driver's own reason, where it gives one."""
        known = len(self.sim.notes())
        result = request(*arguments)
        if result < 0:
            told = [note["text"] for note in self.sim.notes()[known:] if note["kind"] == "log"]
            why = told[-1] if told else os.strerror(-result)
            raise RunError(f"{what}: {errno.errorcode.get(-result, -result)}: {why}")


def _whole(name: str, value: object, least: int, most: int | None = None) -> int:
    """A whole number in these bounds. Raises InputError."""
    good = isinstance(value, int | np.integer) and value >= least
    if good and (most is None or value <= most):
        return int(value)
    bounds = f"of at least {least}" if most in (None, MOST) else f"from {least} to {most}"
    raise InputError.one(name, "", value, f"must be a whole number {bounds}")


def _frame(log: np.ndarray, axes: int):
    names = logcols.header(axes)
    return _pandas().DataFrame(log, columns=names).set_index(names[0])


def _pandas():
    try:
        import pandas
    except ImportError:
        raise RunError(f"pandas is not installed: {installs('study')}") from None
    return pandas
