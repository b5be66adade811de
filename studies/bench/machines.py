# SPDX-License-Identifier: Apache-2.0
"""The machines that `make bench` measures, and one measurement of one of them.

A machine lives in a process of its own, brought to the beginning of a load and kept there as a
snapshot; a measurement restores the snapshot and lets a stretch of time pass. What counts is the
processor time of that stretch, so that other programs disturb little.
"""

from __future__ import annotations

import copy
import math
import multiprocessing
import resource
import time
from dataclasses import dataclass
from pathlib import Path

from mmcs import ROBOTS, ROOT, Files, Session, Sim, ensure_library, make_setup, mcdef, read_toml

CARDS = (1, 3, 8, 16)
LOADS = ("rest", "typical", "full")
EDGES = {"rest": 0, "typical": 8, "full": 42}  # per axis and ms: encoder counts
LEAST_CPU_S = 0.25  # of a measurement
CPU_US_PER_AXIS = 10.0  # a host that serves 32 axes within the millisecond


@dataclass(frozen=True)
class Machine:
    """cards with bench motors on all axes, or `puma`: the coupled arm on three cards."""

    cards: int
    skip: bool
    puma: bool = False

    @property
    def axes(self) -> int:
        return 2 * self.cards

    def setup(self, load: str):
        data, robots = (_puma if self.puma else _bench_motors)(self.cards, load)
        data |= {"description": "a machine of make bench", "cards": self.cards, "skip": self.skip}
        data["host"] = {"cpu_us_per_axis": CPU_US_PER_AXIS}
        return make_setup(ROOT / "sim" / "scenarios" / "bench.toml", data, Files(robots))


def _bench_motors(cards: int, load: str) -> tuple[dict, dict]:
    """Every axis turns at a constant speed: so many counts a millisecond."""
    path = ROBOTS / "lab32.toml"
    robot = copy.deepcopy(read_toml(path))
    robot["axis"][0]["copies"] = 2 * cards
    data = {"robot": "lab32", "duration": 5.0}
    if EDGES[load]:
        data["motion"] = [{
            "axis": "all", "kind": "ramp", "at": 0.0, "duration": 4.9,
            "to": EDGES[load] * 4900.0,
        }]  # fmt: skip
    return data, {_short(path): robot, path: robot}


# Each joint at the speed limit of its motor (Armstrong, Khatib, Burdick 1986 and the arm's manuals
# agree within the figures of sim/robots/puma560.toml), for 0.55 s, within its stops.
PUMA_START_DEG = [-30.0, 45.0, -180.0, -95.0, -88.0, 0.0]
PUMA_FULL_RAD_S = [1.92, 1.51, 2.40, 5.34, 5.09, 5.74]


def _puma(cards: int, load: str) -> tuple[dict, dict]:
    """The coupled arm: at rest, in a half-second move of all joints, or at full joint speed."""
    data = {"robot": "puma560", "dynamics": "coupled", "duration": 1.0, "motion": []}
    if load == "typical":
        data["motion"] = [{"axis": "all", "kind": "quintic", "at": 0.05, "duration": 0.5,
                           "to": [4000, 4000, 3000, 4000, 4000, 4000]}]  # fmt: skip
    elif load == "full":
        data["pose_deg"] = PUMA_START_DEG
        robot = read_toml(ROBOTS / "puma560.toml")
        for axis, speed in enumerate(PUMA_FULL_RAD_S):
            motor = robot["axis"][axis]
            counts = motor["counts_per_rev"] * motor["gear"] / (2 * math.pi) * speed * 0.55
            data["motion"].append({"axis": axis, "kind": "ramp", "at": 0.0, "duration": 0.55,
                                   "to": counts})  # fmt: skip
    return data, {}


def _short(path: Path) -> Path:
    from mmcs.files import short

    return short(path)


WINDOWS = {  # (machine with an arm, load): begin and longest stretch of a measurement, s of motion
    (False, "rest"): (0.1, 4.0), (False, "typical"): (0.1, 4.0), (False, "full"): (0.2, 4.0),
    (True, "rest"): (0.3, 0.6), (True, "typical"): (0.05, 0.5), (True, "full"): (0.15, 0.4),
}  # fmt: skip


def start(sim, setup) -> tuple[int, float]:
    """Opens the driver and starts the motion, as a session does: (client, time of the start)."""
    session = Session(sim, setup)
    client = sim.open(mcdef.O_RDWR)
    session.begin(client)
    return client, session.start


class Loaded:
    """A machine under a load, at the beginning of what is measured."""

    def __init__(self, machine: Machine, load: str, library: Path):
        setup = machine.setup(load)
        self.sim = Sim(library, setup.config(), setup.motors(), setup.links())
        begin, longest = WINDOWS[machine.puma, load]
        _, motion = start(self.sim, setup)
        self.begin, self.stretch = motion + begin, longest
        self.sim.run(self.begin)
        self.snapshot = self.sim.snapshot()
        self.axes = machine.axes
        self.stretch = min(longest, max(0.02, LEAST_CPU_S / self._cpu_per_s(0.02)))

    def _cpu_per_s(self, stretch: float) -> float:
        self.sim.restore(self.snapshot)
        begin = time.process_time()
        self.sim.run(self.begin + stretch)
        return (time.process_time() - begin) / stretch

    def measure(self) -> dict:
        """Sums of as many stretches as fill the least time: simulated s, CPU s, evaluations, ..."""
        out = {"s": 0.0, "cpu": 0.0, "clocks": 0, "evals": 0, "edges": 0.0}
        while out["cpu"] < LEAST_CPU_S:
            self.sim.restore(self.snapshot)
            clock, evals, counts = self.sim.clock, self.sim.stats()["evals"], self._counts()
            begin = time.process_time()
            self.sim.run(self.begin + self.stretch)
            out["cpu"] += time.process_time() - begin
            out["s"] += self.stretch
            out["clocks"] += self.sim.clock - clock
            out["evals"] += self.sim.stats()["evals"] - evals
            out["edges"] += sum(abs(a - b) for a, b in zip(self._counts(), counts, strict=True))
        return out

    def _counts(self) -> list[float]:
        return [self.sim.true(axis)["count"] for axis in range(self.axes)]


def rss_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _serve(pipe, machine: Machine, library: Path) -> None:
    loaded: dict[str, Loaded] = {}
    before = rss_mb()
    while (load := pipe.recv()) is not None:
        if load == "memory":
            pipe.send((rss_mb() - before, rss_mb()))
            continue
        if load not in loaded:
            loaded[load] = Loaded(machine, load, library)
        pipe.send(loaded[load].measure())


class Remote:
    """A machine in its process."""

    def __init__(self, machine: Machine):
        self.machine = machine
        library = ensure_library(machine.cards, "speed")
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, machine, library), daemon=True)
        self._process.start()
        theirs.close()

    def ask(self, what: str):
        """A measurement of a load, or "memory": MB grown by the machine, MB in all."""
        self._pipe.send(what)
        return self._pipe.recv()

    def end(self) -> None:
        self._pipe.send(None)
        self._process.join()
