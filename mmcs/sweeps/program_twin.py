# SPDX-License-Identifier: Apache-2.0
"""The same for a motion that programs make: [[program]].

No program goes back to a snapshot, so every faulty run begins at power-on, as the twin's did, and
goes on to the scenario's end, when the programs have ended, too.
"""

from dataclasses import replace

import numpy as np

from mmcs.errors import InputError
from mmcs.runs.machine import machine
from mmcs.runs.programs import ProgramSession
from mmcs.scenario.scenario import Event
from mmcs.scenario.setup import Setup
from mmcs.sweeps.classes import Seen
from mmcs.sweeps.faults import Fault
from mmcs.sweeps.twin import EVERY, LOOK_S, STEP, Twin


class _Watched(ProgramSession):
    """Looks at the physics as often as a twin does, to the end of the scenario."""

    look_s = LOOK_S
    ended_s = 0.0  # when the last program ended

    def _serve(self, server, children, progress) -> bool:
        good = super()._serve(server, children, progress)
        self.ended_s, self.hash = self.sim.time, self.sim.hash()
        for _ in children:
            server.step()  # what the programs had open is closed
        for look in range(len(self.truth), round(self.setup.scenario.duration / LOOK_S) + 1):
            good = good and self.sim.run(look * LOOK_S)
            self._watch(look * LOOK_S)
        return good


class ProgramTwin(Twin):
    def __init__(self, setup: Setup):
        """Raises InputError for programs that fail by themselves."""
        self.setup, self.axes, self.start = setup, range(setup.axes), 0.0
        self.scale = np.array([abs(setup.robot.counts_per_rad(n)) for n in self.axes])
        self.looks = round(setup.scenario.duration / LOOK_S)
        self.snapshots = range(self.looks // EVERY + 1)
        self._stops: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        result, session = self._go_through([])
        self.session, self.refused = session, 0  # requests are the program's own matter
        failed = [p for p in result.processes if p["status"]]
        if failed:
            allowed = f"ends with status {failed[0]['status']}, with no fault: mend it first"
            raise InputError.one(setup.path, "program.run", failed[0]["run"], allowed)
        self.times, self.angles = result.truth[:, 0], self._angles_of(result)
        self.told = {(n["kind"], n["text"]) for n in result.notes if n["t"] < session.ended_s}
        self.hash, self.stats = session.hash, result.stats

    def close(self) -> None:
        pass

    def _go_through(self, events: list[dict]):
        """A whole run with more events: its result and its session."""
        scenario = self.setup.scenario
        more = [*scenario.event, *map(Event.model_validate, events)]
        setup = replace(self.setup, scenario=scenario.model_copy(update={"event": more}))
        with machine(setup) as sim:
            session = _Watched(sim, setup, quiet=True)
            return session.run(), session

    def _angles_of(self, result) -> np.ndarray:
        return result.truth[:, 2::3] * self.scale

    def run(self, fault: Fault, whole: bool = False) -> tuple[Seen, dict]:
        """What is seen of it, and what else is told; whole: with its hash."""
        result, session = self._go_through([fault.event])
        angles, after = self._angles_of(result), result.truth[:, 0] > fault.at
        status = next((p["status"] for p in result.processes if p["status"]), 0)
        end = np.inf if status else session.ended_s
        notes = [n for n in result.notes if n["t"] >= fault.at and n["t"] < end]
        detected, by = self._detected(notes, fault.at)
        if detected is None and status:
            detected, by = session.ended_s - fault.at, f"the program's status {status}"
        more = {"by": by, "told": self._statistics(self.stats, result.stats)}
        if whole:
            more["hash"] = session.hash
        known = session.hash == self.hash, detected
        return self._seen(fault.at, result.truth[after, 0], angles[after], known, more)

    def _stop(self, place: int) -> tuple[np.ndarray, np.ndarray]:
        """Where the joints go when the button is pressed at a look: least and most."""
        if place not in self._stops:
            at = place * EVERY * LOOK_S
            result, _ = self._go_through([{"at": at, "input": "estop", "value": 1}])
            angles = self._angles_of(result)[place * EVERY :: STEP]
            self._stops[place] = (angles.min(axis=0), angles.max(axis=0))
        return self._stops[place]
