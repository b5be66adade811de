# SPDX-License-Identifier: Apache-2.0
"""Which faults a campaign makes of which motions, and the rows that they become."""

import functools
import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass

from mmcs import __version__
from mmcs.errors import InputError
from mmcs.runs.machine import library_of
from mmcs.scenario.load import load
from mmcs.scenario.setup import Setup
from mmcs.sweeps.classes import judge
from mmcs.sweeps.faults import SORTS, Fault, Motion, draw
from mmcs.sweeps.twin import Twin
from mmcs.sweeps.workers import or_failed

WATCH_S = 0.25  # after the scenario's end, so that the last fault, too, shows what it does
CHUNK = 40  # faults that a worker is given at once
TWINS = 6  # that a worker keeps
MOTIONS = ("arm_move", "arm_calibrate", "puma560_hold", "puma560_velocity")


@dataclass
class Plan:
    """Fault n depends on the seed, its number, the motions and the sorts alone."""

    names: tuple[str, ...]
    setups: dict[str, Setup]
    motions: tuple[Motion, ...]
    sorts: tuple[str, ...]
    seed: int
    typed: tuple[str, ...]  # of --set

    def fault(self, n: int) -> Fault:
        return draw(self.seed, n, self.sorts, self.motions)

    def command(self, n: int) -> str:
        """What makes fault n alone."""
        fault = self.fault(n)
        scenario = self.setups[fault.motion].scenario
        sets = (*self.typed, f"duration={scenario.duration!r}")
        return fault.command(self.calls(fault.motion), sets)

    def calls(self, motion: str) -> list[dict]:
        return [_entry(call) for call in self.setups[motion].scenario.call]

    def chunks(self, todo: list[int]) -> Iterator[tuple[tuple[int, ...], tuple]]:
        """(their numbers, what a worker is given): each chunk of one motion, motions in turn, so
        that a campaign that is stopped has done as many of each."""
        found = []
        for place, name in enumerate(self.names):
            own = [n for n in todo if n % len(self.names) == place]
            cut = [tuple(own[at : at + CHUNK]) for at in range(0, len(own), CHUNK)]
            found += [(numbers, name) for numbers in cut]
        for numbers, name in sorted(found):
            yield numbers, self.task(name, numbers)

    def task(self, name: str, numbers: tuple[int, ...]) -> tuple:
        return self.setups[name], [self.fault(n) for n in numbers]

    def identity(self, build: str) -> str:
        """What a campaign must share with an earlier one to go on with it: all but how many."""
        parts = [__version__, build, self.seed, self.sorts, [asdict(m) for m in self.motions],
                 [(s.data, s.files) for s in self.setups.values()]]  # fmt: skip
        return hashlib.sha256(json.dumps(parts, default=str).encode()).hexdigest()[:16]


def _entry(call) -> dict:
    """A [[call]] as the file has it."""
    return call.model_dump(exclude_none=True, exclude_defaults=True)


def make_plan(
    names: tuple[str, ...], sorts: tuple[str, ...], seed: int, sets: tuple[str, ...] = ()
) -> Plan:
    """Raises InputError for what no campaign can be made of."""
    names, sorts = names or MOTIONS, sorts or SORTS
    for name in names:
        if names.count(name) > 1:
            raise InputError.one("mmcs campaign", "", name, "is named twice")
    for sort in sorts:
        if sort not in SORTS:
            allowed = "must be one of " + ", ".join(SORTS)
            raise InputError.one("--sort", "", sort, allowed)
    setups, motions = {}, []
    for name in names:
        until = load(name, sets).scenario.duration
        setup = load(name, (*sets, f"duration={until + WATCH_S!r}"))
        for key in ("event", "process", "program"):
            if getattr(setup.scenario, key):
                allowed = "a campaign wants a motion without events, processes and programs"
                raise InputError.one(setup.path, key, None, allowed)
        setups[name] = setup
        motions.append(_motion(name, setup, until))
    return Plan(tuple(names), setups, tuple(motions), tuple(sorts), seed, sets)


def _motion(name: str, setup: Setup, until: float) -> Motion:
    from mmcs.engine.sim import library_registers

    scenario = setup.scenario
    registers = tuple(library_registers(library_of(setup)).items())
    return Motion(
        name, until, registers, setup.axes, scenario.cards, scenario.interval_us,
        tuple(setup.params),
    )  # fmt: skip


# --- what a worker does ------------------------------------------------------------------------


@functools.lru_cache(maxsize=TWINS)
def _twin(key: str):
    return Twin(_given[key])


_given: dict[str, Setup] = {}


def twin_of(setup: Setup):
    """The setup's twin, which this process keeps."""
    parts = [str(setup.path), setup.data, setup.files]
    key = hashlib.sha256(json.dumps(parts, default=str).encode()).hexdigest()
    _given[key] = setup
    try:
        return _twin(key)
    finally:
        del _given[key]


@or_failed
def run_chunk(task: tuple[Setup, list[Fault]]) -> dict:
    """{"rows"} of some faults in one motion."""
    setup, faults = task
    twin = twin_of(setup)
    return {"rows": [run_fault(twin, fault) for fault in faults]}


def run_fault(twin, fault: Fault, whole: bool = False) -> dict:
    """The row of one fault; whole: with the hash that `mmcs run` must find."""
    seen, more = twin.run(fault, whole)
    after = None if seen.detected_s is None else round(1e3 * seen.detected_s, 4)
    return {
        "status": "ok",
        "class": judge(seen),
        "motion": fault.motion,
        "sort": fault.sort,
        "what": fault.what,
        "at": fault.at,
        "lasts": fault.lasts,
        "off": round(seen.off, 2),
        "beyond": round(seen.beyond, 2),
        "after_ms": after,
        **more,
    }
