# SPDX-License-Identifier: Apache-2.0
"""A motion without faults, and faulty runs that begin from its snapshots.

The twin runs once. A fault begins at the last snapshot before its moment, and its run ends as soon
as its state is the twin's of the same clock: from there on nothing can differ.
"""

from dataclasses import replace

import numpy as np

from mmcs import mcdef
from mmcs.errors import InputError
from mmcs.inputs import find
from mmcs.runs.machine import machine
from mmcs.runs.session import Session, refusals, script_of
from mmcs.scenario.scenario import Call
from mmcs.scenario.setup import Setup
from mmcs.sweeps.classes import Seen
from mmcs.sweeps.faults import Fault

LOOK_S = 1e-3  # between looks at the twin's physics and state
EVERY = 5  # looks from one snapshot to the next
STEP = 2  # looks from one to the next of a faulty run
OFTEN = 20  # looks for which the state is compared at each, then every EVERY * STEP
PROMISE_S = 0.050  # the heartbeats': a stop that comes later is late


class Twin:
    """One motion on one simulated machine, which then makes all its faulty runs."""

    def __init__(self, setup: Setup):
        """Raises InputError for a motion that stops by itself."""
        self.setup, self.axes = setup, range(setup.axes)
        self.scale = np.array([abs(setup.robot.counts_per_rad(n)) for n in self.axes])
        self.calls = sorted(setup.scenario.call, key=lambda call: call.at)
        self.sim = machine(setup)
        self.session = Session(self.sim, setup)
        self.session.begin()
        self.start = self.session.start
        self.inputs = {name: n for n, name in enumerate(self.sim.input_names())}
        self.looks = round(setup.scenario.duration / LOOK_S)
        self._stops: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        try:
            self._go()
        except InputError:
            self.close()
            raise

    def close(self) -> None:
        self.sim.destroy()

    def _go(self) -> None:
        sim, script = self.sim, self.session.script
        times, angles, futures, taken = [], [], [], []
        for look in range(self.looks + 1):
            sim.play(script, LOOK_S * look)
            self._must_run(look)
            times.append(sim.time)
            angles.append(self._angles())
            sim.take_log()
            futures.append(sim.future())
            if look % EVERY == 0:
                number = sim.snapshot()
                taken.append(sim.snapshot_bytes(number))
                sim.drop(number)
        self.times, self.angles, self.futures = np.array(times), np.array(angles), futures
        self.snapshots, self.history = taken, sim.history_bytes()
        self.refused = len(self.session.refused)
        self.told = {(n["kind"], n["text"]) for n in sim.notes() if n["t"] >= self.start}

    def _must_run(self, look: int) -> None:
        """InputError when the motion has stopped by itself, with no fault: then a campaign would
        tell of a machine that stands."""
        asked = any(call.request == "MSTOP" for call in self.calls)
        if asked or self.sim.stats()["enabled"]:
            return
        said = [n["text"] for n in self.sim.notes() if n["kind"] == "log"]
        why = f" ({said[-1].removeprefix('mc: ')})" if said else ""
        allowed = (
            f"its servo stops by itself {LOOK_S * look:.3f} s after it began, with no "
            f"fault{why}: change what stops it, or leave this motion out"
        )
        raise InputError.one(self.setup.path, "", None, allowed)

    def _angles(self) -> np.ndarray:
        return np.array([self.sim.true(axis)["angle"] for axis in self.axes]) * self.scale

    def _restore(self, at: float) -> int:
        """The last snapshot not after a time of the motion; its look."""
        late = self.start + at
        place = min(int(at / LOOK_S) // EVERY, len(self.snapshots) - 1)
        while place > 0 and self.times[place * EVERY] > late:
            place -= 1
        self.sim.restore_bytes(self.snapshots[place], self.history)
        return place * EVERY

    # --- a faulty run ---

    def run(self, fault: Fault, whole: bool = False) -> tuple[Seen, dict]:
        """What is seen of it, and what else is told; whole: to the end, for its hash."""
        sim = self.sim
        look, script = self._begin(fault)
        before = sim.stats()
        began = len(sim.notes())
        times, angles, same, since = [], [], False, 0
        while look < self.looks and (whole or not same):
            look = min(look + STEP, self.looks)
            if sim.play(script, LOOK_S * look)[0]:
                break
            if LOOK_S * look <= fault.at:
                continue
            times.append(sim.time)
            angles.append(self._angles())
            since += 1
            if since <= OFTEN or look % (EVERY * STEP) == 0:
                same = same or sim.future() == self.futures[look]
        detected, by = self._detected(sim.notes()[began:], fault.at, refusals(script))
        names, after = ("missed", "overruns", "spurious", "bus_errors"), sim.stats()
        told = " ".join(name for name in names if after[name] != before[name])
        ended = sim.hash()  # now: what comes may be other runs on the same machine
        times, angles = np.array(times), np.array(angles).reshape(-1, len(self.axes))
        off = self._away(times, angles).max(axis=0, initial=0.0)
        beyond = np.zeros(len(self.axes))
        if detected is not None and off.any():
            beyond = self._beyond(fault.at, angles).max(axis=0, initial=0.0)
        worst = beyond if beyond.any() else off
        far = np.degrees(beyond if detected is not None else off) / self.scale
        more = {"by": by, "told": told, **({"hash": ended} if whole else {}),
                "joint": 1 + int(worst.argmax()) if worst.any() else 0,
                "deg": round(float(far.max()), 3)}  # fmt: skip
        return Seen(same, detected, float(off.max()), float(beyond.max())), more

    def _begin(self, fault: Fault):
        """The look at which the faulty run begins, and its script."""
        calls, look = list(self.calls), self._restore(fault.at)
        if fault.event:
            self._add(fault.event)
        else:
            calls.append(Call.model_validate(fault.call))
        scenario = self.setup.scenario.model_copy(update={"call": calls})
        script = script_of(self.sim, replace(self.setup, scenario=scenario))
        script.resume(self.session.script.client, self.start, LOOK_S * look, False)
        return look, script

    def stopped(self, fault: Fault, longest_s: float) -> tuple[np.ndarray, bool]:
        """The joints' angles from a stop on until all rest, counts, a row for each look; and
        whether they do within so many seconds."""
        look, script = self._begin(fault)
        last, still = look + round((longest_s + LOOK_S * EVERY) / LOOK_S), 0
        self.sim.play(script, fault.at)
        seen = [self._angles()]
        while look < last and LOOK_S * still < PROMISE_S:
            look += STEP
            if LOOK_S * look <= fault.at:
                continue
            self.sim.play(script, LOOK_S * look)
            seen.append(self._angles())
            still = still + STEP if np.array_equal(seen[-1], seen[-2]) else 0
        return np.array(seen), LOOK_S * still >= PROMISE_S

    def _add(self, event: dict) -> None:
        number, index = self.inputs[event["input"]], event.get("index", 0)
        self.sim.add_event(self.start + event["at"], number, index, event["value"])
        if "until" in event:
            healthy = find(event["input"]).healthy
            self.sim.add_event(self.start + event["until"], number, index, healthy)

    def _detected(self, notes: list[dict], at: float, refused: list) -> tuple[float | None, str]:
        """Seconds after the fault until the machine told by itself, and what it told."""
        known = mcdef.MERR_PLO | mcdef.MERR_PHI | mcdef.MERR_ILIM | mcdef.MERR_PANIC
        for note in notes:
            if (note["kind"], note["text"]) in self.told:
                continue
            after = note["t"] - self.start - at
            if note["kind"] == "panic" and "high" in note["text"]:
                return after, "PANIC"
            if note["kind"] == "error" and int(note["text"].split()[1], 16) & known:
                return after, "error code"
        if len(refused) > self.refused:
            return self.sim.time - self.start - at, f"{refused[-1][0]} refused"
        return None, ""

    def _away(self, times: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """How far each joint was from the twin's, counts, at the very times."""
        own = [np.interp(times, self.times, self.angles[:, n]) for n in self.axes]
        return np.abs(angles - np.transpose(own))

    def _beyond(self, at: float, angles: np.ndarray) -> np.ndarray:
        """How far each joint was beyond where it would have been: on its way, or in a stop pressed
        at the fault (at the snapshots around it) or when the heartbeats' promise ends."""
        first = min(int(at / LOOK_S), self.looks)
        low, high = self.angles[first:].min(axis=0), self.angles[first:].max(axis=0)
        ticks, step = round(at * 1e7), round(LOOK_S * EVERY * 1e7)
        late = ticks + round(PROMISE_S * 1e7)
        for place in (ticks // step, -(-ticks // step), -(-late // step)):
            outside = (angles < low) | (angles > high)
            if outside.any() and place < len(self.snapshots):
                stop_low, stop_high = self._stop(place)
                low, high = np.minimum(low, stop_low), np.maximum(high, stop_high)
        return np.maximum(0.0, np.maximum(low - angles, angles - high))

    def _stop(self, place: int) -> tuple[np.ndarray, np.ndarray]:
        """Where the joints go when the button is pressed at a snapshot: least and most."""
        if place not in self._stops:
            self.sim.restore_bytes(self.snapshots[place], self.history)
            self.sim.add_event(self.sim.time, self.inputs["estop"], 0, 1)
            seen, still = [self._angles()], 0
            for look in range(place * EVERY, self.looks + 1, STEP):
                self.sim.run(self.start + LOOK_S * look)
                seen.append(self._angles())
                still = still + STEP if np.array_equal(seen[-1], seen[-2]) else 0
                if LOOK_S * still >= PROMISE_S:
                    break  # the brakes hold all joints, to the last bit
            self._stops[place] = (np.min(seen, axis=0), np.max(seen, axis=0))
        return self._stops[place]
