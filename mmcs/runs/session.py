# SPDX-License-Identifier: Apache-2.0
"""One run, doing what a user's program does with /dev/mc0 (§2.3.6, Fig. 2.3)."""

import errno
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from mmcs import mcdef
from mmcs.engine.rows import Rows
from mmcs.errors import RunError
from mmcs.logcols import FIELDS
from mmcs.runs.machine import compile_for
from mmcs.scenario.setup import Setup

CHUNK_S = 0.02  # simulated time between looks at the clock on the wall
WATCH_S = 0.001  # between looks at the physics, in scenarios with events
LATE_US = 250_000  # so much in late passes, and a request that timed out had no processor
DIED = "the firmware died"  # how the processor's end is noted


@dataclass
class Result:
    """What came out of a run; everything that is written or printed is made from this."""

    setup: Setup
    log: np.ndarray
    notes: list[dict]
    stats: dict
    hash: str
    wall_s: float
    simulated_s: float
    motion_start_s: float
    clk_hz: int
    cycles: int
    witnesses: list[dict] = field(default_factory=list)  # physics at the end of motion, per axis
    states: list[dict] = field(default_factory=list)  # mc_state at the same instant
    assertion: bool = False  # an assertion of the model failed
    ended: str = ""  # what else kept the run from its end
    # The physics over time, a row per look: t_s, PANIC, then per axis angle, velocity, current.
    truth: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    notes_lost: int = 0  # that came after the last of `notes`
    pots: dict[int, tuple[int, int]] = field(default_factory=dict)  # A/D code, count, at MCALIB
    refused: list[tuple[str, int]] = field(default_factory=list)  # requests the driver refused
    processes: list[dict] = field(default_factory=list)
    checkpoints: list[tuple[int, int, int, int]] = field(default_factory=list)  # see Sim
    build: str = ""  # which build of the simulator it was
    image: str = ""  # and which firmware a processor ran
    bus: bytes | None = None  # mmcs_bus_cycles of the VME bus, if they were asked for


NO_MEMORY = "out of memory"


class Refused(Exception):
    """The driver said no to a request of the start, as the scenario expects."""


class Session:
    """Drives a Sim (or a fake of it) through a setup."""

    def __init__(self, sim, setup: Setup, realtime: bool = False, bus: bool = False):
        self.sim, self.setup, self.realtime = sim, setup, realtime
        self.start = 0.0
        self.pots: dict[int, tuple[int, int]] = {}
        self.at_start: list[tuple[str, int]] = []  # what the driver refused
        self.script = script_of(sim, setup)
        self.log = Rows(1 + len(FIELDS) * setup.axes)
        self.truth = Rows(2 + 3 * setup.axes)
        self.bus = bytearray() if bus else None

    def run(self, progress: Callable[[float], None] = lambda _: None) -> Result:
        sim, setup = self.sim, self.setup
        began = time.perf_counter()
        if self.bus is not None:
            sim.bus_cycles()
        ok, ended = True, ""
        try:
            self.begin()
            ok = self._move(setup.scenario.duration, progress)
        except Refused:
            pass
        except MemoryError:  # what there is until now is kept
            ok, ended = False, NO_MEMORY
        if not ok and not ended:
            ended = self._why_ended()
        client, witnesses = self.script.client, self.witnesses()
        states = self._last_state(client)
        hash_ = sim.hash()
        self.log.append(sim.take_log())
        if ok:
            self._answered("MSTOP", sim.ioctl(client, mcdef.MSTOP))
        stats = sim.stats()
        sim.close(client)
        self._take_cycles()
        return self.result(began, ok, ended, stats, hash_, witnesses, states)

    def result(self, began: float, ok: bool, ended: str, stats: dict, hash_: str, witnesses: list,
               states: list) -> Result:  # fmt: skip
        sim = self.sim
        for request, axis, _, code, count in self.script.answers():
            if request == "MCALIB" and axis >= 0:
                self.pots.setdefault(axis, (code, count))
        return Result(
            setup=self.setup,
            log=self.log.array(),
            notes=sim.notes(),
            notes_lost=sim.notes_lost(),
            stats=stats,
            hash=hash_,
            wall_s=time.perf_counter() - began,
            simulated_s=sim.time,
            motion_start_s=self.start,
            clk_hz=sim.build()["clk_hz"],
            cycles=int(stats["cycles"]),
            witnesses=witnesses,
            states=states,
            assertion=not ok and not ended,
            ended=ended,
            truth=self.truth.array(),
            pots=self.pots,
            refused=self.refused,
            processes=summaries(self.script, self.setup),
            checkpoints=sim.checkpoints(),
            build=sim.build_id(),
            bus=None if self.bus is None else bytes(self.bus),
        )

    def witnesses(self) -> list[dict]:
        """Of each axis, the physics and what its register holds."""
        sim = self.sim
        return [sim.true(n) | {"register": sim.encoder_register(n)} for n in range(self.setup.axes)]

    @property
    def refused(self) -> list[tuple[str, int]]:
        """Requests that the driver refused, and how."""
        return self.at_start + refusals(self.script)

    def begin(self) -> int:
        """Configures the driver and starts the motion; the driver's number of the program. A
        refusal that the scenario expects ends the run in good order."""
        result, what = self.script.begin(self.sim)
        self.start = self.script.start
        if result > 0:
            self.at_start.append((what.split()[0], result))
            raise Refused
        for said in self.sim.notes() if result < 0 else []:
            if said["kind"] == "assert" or said["text"].startswith("event refused"):
                raise RunError(f"{what}: {said['text']}")
        self._answered(what, result)
        return self.script.client

    def play(self, until: float) -> bool:
        """Runs to a time of the motion and carries the script out; False: an assertion failed."""
        result, what = self.sim.play(self.script, until)
        return self._answered(what, result) == 0

    def _last_state(self, client: int) -> list:
        try:
            return self.sim.read(client, self.setup.axes)
        except OSError as error:  # a processor whose firmware went wrong answers nothing
            why = self._why_silent() or f"{error}; the driver answers no more"
            raise RunError(f"read of the last state: {why}") from None

    def _why_ended(self) -> str:
        """What the engine tells of its end; "" if it was an assertion."""
        notes = [n for n in self.sim.notes() if n["kind"] in ("assert", "log")]
        if any(n["kind"] == "assert" for n in notes):
            return ""
        return notes[-1]["text"] if notes else NO_MEMORY

    def _why_silent(self) -> str:
        """Why a real processor answers no request, and the remedy; "" when that is not known."""
        phases = self.sim.phases()
        if not phases:
            return ""  # native code always answers
        died = [n["text"] for n in self.sim.notes() if n["text"].startswith(DIED)]
        if died:
            return f"{died[0]}; only --host native goes on and gives results"
        stats, interval_us = self.sim.stats(), self.setup.scenario.interval_us
        late = stats["overruns"] + stats["missed"]
        # a pass goes on after its last look at the clock: its results for the host
        if late * interval_us < LATE_US and phases["pass"][1] < interval_us:
            return ""
        return (
            "the servo leaves the processor no time for requests"
            f" ({stats['interrupts']} passes, {stats['overruns']} overruns,"
            f" {stats['missed']} missed at {interval_us} us);"
            " take fewer axes, a longer interval_us or --host native"
        )

    def _answered(self, what: str, result: int) -> int:
        """As _checked, but tells why a processor is silent."""
        why = self._why_silent() if result == -errno.EIO else ""
        if why:
            raise RunError(f"{what}: {why}")
        return _checked(what, result)

    def _move(self, duration: float, progress: Callable[[float], None]) -> bool:
        """Runs the motion from look to look; False when an assertion of the model failed."""
        began = time.perf_counter()
        step = WATCH_S if self.setup.scenario.event else CHUNK_S
        looks, look = max(1, round(duration / step)), 0
        self._watch(0.0)
        while look < looks:
            next_look = duration * (look + 1) / looks
            if not self.play(next_look):
                return False
            look += 1
            self._watch(next_look)
            if self.realtime:
                time.sleep(max(0.0, began + next_look - time.perf_counter()))
            progress(next_look)
        return True

    def _watch(self, t: float) -> None:
        row = [t, self.sim.stats().get("panic_level", 0)]
        for axis in range(self.setup.axes):
            truth = self.sim.true(axis)
            row += [truth["angle"], truth["velocity"], truth["current"]]
        self.truth.append(np.array(row))
        self.log.append(self.sim.take_log())
        self._take_cycles()

    def _take_cycles(self) -> None:
        if self.bus is not None:
            self.bus += self.sim.bus_cycles()


def script_of(sim, setup: Setup):
    """What carries the setup out on a machine of its build."""
    return sim.new_script(compile_for(setup, sim.lib))


def summaries(script, setup: Setup) -> list[dict]:
    """What the report says of each process."""
    found = []
    for process, told in zip(setup.scenario.process, script.told(), strict=True):
        acts, turns, shortest, longest = told
        if process.kind == "bounce":
            found.append({"kind": "bounce", "turns": turns})
            continue
        found.append({
            "kind": "pd",
            "wakes": acts,
            "shortest_period_us": round(shortest, 1) if acts > 1 else None,
            "longest_period_us": round(longest, 1) if acts > 1 else None,
        })  # fmt: skip
    return found


def refusals(script) -> list[tuple[str, int]]:
    return [(request, -result) for request, _, result, *_ in script.answers() if result < 0]


def session_of(sim, setup: Setup, realtime: bool = False, bus: bool = False,
               quiet: bool = False) -> Session:  # fmt: skip
    """What carries the setup out: programs, or what stands for one."""
    if not setup.scenario.program:
        return Session(sim, setup, realtime, bus)
    if realtime:
        raise RunError("a [[program]] runs in lock-step, not in real time")
    from mmcs.runs.programs import ProgramSession

    return ProgramSession(sim, setup, bus=bus, quiet=quiet)


def _checked(what: str, result: int) -> int:
    if result < 0:
        code = errno.errorcode.get(-result, str(result))
        raise RunError(f"{what}: {code} ({os.strerror(-result)})")
    return result
