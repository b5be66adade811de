# SPDX-License-Identifier: Apache-2.0
"""Snapshots of a run: a ring of them in every run's folder, and runs that begin from one.

A file of snapshots is a zip archive: the run's record, its past (log and notes), what was seen of
the physics, and one member per snapshot. The engine checks that its own bytes come from the same
build and the same machine.
"""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from mmcs.errors import InputError, RunError
from mmcs.place import run_folders
from mmcs.record.record import Record, parse
from mmcs.scenario.files import short
from mmcs.session.session import Session

NAME = "run.mmsnap"
RING = 16  # snapshots in the ring; they spread over the run
EVERY_S = 0.02  # but are not closer than this


class Taking:
    """A Sim that takes snapshots at these times since the start of motion, and a ring of them."""

    def __init__(self, sim, times: tuple[float, ...], duration: float):
        self._sim, self._times, self._asked = sim, sorted(times), {}
        self._start = 0.0
        self._every = max(EVERY_S, duration / RING)

    def __getattr__(self, name):
        return getattr(self._sim, name)

    def start_motion(self, client: int) -> int:
        self._start = self._sim.time
        self._sim.ring(self._every, RING)
        return self._sim.start_motion(client)

    def run(self, until_s: float) -> bool:
        try:
            while self._times and self._start + self._times[0] <= until_s:
                asked = self._times.pop(0)
                self._asked[self._sim.snapshot(self._start + asked)] = asked
        except RunError:
            return False  # an assertion has failed
        return self._sim.run(until_s)

    def taken(self) -> list[dict]:
        """Every snapshot that is kept, with its bytes."""
        return [
            {
                "t": s["t"] - self._start,
                "clock": s["clock"],
                "ring": s["id"] not in self._asked,
                "asked": self._asked.get(s["id"]),
                "bytes": self._sim.snapshot_bytes(s["id"]),
            }
            for s in self._sim.snapshots()
        ]


# --- files -------------------------------------------------------------------------------------


def write_snapshots(path: Path, record: dict, result) -> None:
    """Does nothing for a run without snapshots."""
    taken, history = result.snapshots
    if not taken:
        return
    truth = io.BytesIO()
    np.save(truth, result.truth)
    index = [{k: v for k, v in s.items() if k != "bytes"} for s in taken]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        file.writestr("record.json", json.dumps(record))
        file.writestr("index.json", json.dumps({"snapshots": index, "pots": result.pots}))
        file.writestr("truth.npy", truth.getvalue())
        file.writestr("history.bin", history)
        for n, snapshot in enumerate(taken):
            file.writestr(f"{n}.bin", snapshot["bytes"])


class Snapshot:
    """One snapshot out of a file: "FILE", "RUN" or either with "@T", T since the motion began."""

    def __init__(self, name: str):
        self.name, at = _split(name)
        self.path = _find(self.name)
        try:
            with zipfile.ZipFile(self.path) as file:
                members = {name: file.read(name) for name in file.namelist()}
            index = json.loads(members["index.json"])
            self.record: Record = parse(self.path, json.loads(members["record.json"]))
            self.truth = np.load(io.BytesIO(members["truth.npy"]))
            self.pots = {int(axis): tuple(v) for axis, v in index["pots"].items()}
            self.history = members["history.bin"]
            known = index["snapshots"]
            n = _choose(self.path, known, at)
            self.state = members[f"{n}.bin"]
        except (zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError):
            raise InputError.one(
                self.path, "", None, "not a file of snapshots of MMCS, or damaged"
            ) from None
        self._folder = tempfile.TemporaryDirectory()  # as long as the setup is used
        self.t, self.clock, self.ring = known[n]["t"], known[n]["clock"], known[n]["ring"]

    def setup(self, duration: float | None = None):
        if duration is not None:
            if not duration > self.t:
                allowed = f"must be beyond the snapshot, at {self.t:.6f} s"
                raise InputError.one("--duration", "", duration, allowed)
            self.record.text["data"]["duration"] = duration
        setup = self.record.setup(Path(self._folder.name))
        if setup.scenario.process:
            raise InputError.one(
                self.path,
                "process",
                None,
                "a user's process is not part of a snapshot; use mmcs trace or mmcs replay",
            )
        return setup


def _split(name: str) -> tuple[str, float | None]:
    head, sign, tail = name.rpartition("@")
    if not sign:
        return name, None
    try:
        return head, float(tail)
    except ValueError:
        allowed = "what follows @ must be a time in seconds, like lab500@0.25"
        raise InputError.one("--from", "", name, allowed) from None


def _find(name: str) -> Path:
    for path in (Path(name), *(folder / NAME for folder in (Path(name), *run_folders(name)))):
        if path.is_file():
            return short(path)
    hint = f"no such snapshots; give a {NAME}, a run's folder, or a scenario that has run"
    raise InputError.one("--from", "", name, hint)


def _choose(path: Path, known: list[dict], at: float | None) -> int:
    """The last snapshot, or the last one that is not after `at`."""
    if at is None:
        return len(known) - 1
    good = [
        n for n, s in enumerate(known)
        if s["t"] <= at + 1e-9 and (s["asked"] is None or s["asked"] <= at + 1e-9)
    ]  # fmt: skip
    if good:
        return good[-1]
    allowed = f"the first snapshot in {path} is at {known[0]['t']:.3f} s"
    raise InputError.one("--from", "", f"@{at:g}", allowed)


# --- going on from one -------------------------------------------------------------------------


class _Restored:
    """A Sim for a Session that believes it begins: what has happened is not done again."""

    def __init__(self, sim, snapshot: Snapshot):
        self._sim, self._snapshot = sim, snapshot
        self._there = False  # the snapshot is in; a processor has started before

    def __getattr__(self, name):
        return getattr(self._sim, name)

    @property
    def time(self) -> float:
        return self._sim.time if self._there else self._snapshot.record.motion_start_s

    def open(self, _flags: int = 2) -> int:
        return 0  # a session's program is the first and only one

    def add_segment(self, **_fields) -> None:
        """It is in the snapshot."""

    def start_motion(self, _client: int) -> int:
        try:
            self._sim.restore_bytes(self._snapshot.state, self._snapshot.history)
        except ValueError as error:
            raise InputError.one(self._snapshot.path, "", None, str(error)) from None
        self._there = True
        return 0

    def run(self, until_s: float) -> bool:
        return self._sim.time >= until_s or self._sim.run(until_s)


class ResumedSession(Session):
    """A session from a snapshot on; its result is that of the whole run."""

    def __init__(self, sim, setup, snapshot: Snapshot, realtime: bool = False):
        super().__init__(_Restored(sim, snapshot), setup, realtime)
        self._snapshot = snapshot

    def _schedule(self, start: float, at_power_on: bool) -> None:
        """Events are in the snapshot."""

    def _configure(self, client: int) -> None:
        """So is the configured driver."""

    def _move(self, duration: float, progress) -> bool:
        now = self._snapshot.t
        for actor in self.actors:
            done = [c for c in actor.calls if c.at < now or (self._snapshot.ring and c.at <= now)]
            actor.calls = actor.calls[len(done) :]
            for call in done:
                if call.request == "MCALIB":
                    axes = range(self.setup.axes) if call.axis == "all" else call.axis
                    self.pots |= {a: v for a, v in self._snapshot.pots.items() if a in axes}
        return super()._move(duration, progress)

    def _watch(self, t: float) -> None:
        seen = self._snapshot.truth
        if t <= self._snapshot.t and len(self._truth) < len(seen):
            self._truth.append(list(seen[len(self._truth)]))
        else:
            super()._watch(t)


def resume(setup, snapshot: Snapshot, realtime: bool = False):
    """Carries the rest of the run out."""
    from mmcs.session.machine import machine, progress

    host = snapshot.record.host
    with machine(setup, host=host) as sim, progress(setup.scenario.duration) as advance:
        return ResumedSession(sim, setup, snapshot, realtime).run(advance)
