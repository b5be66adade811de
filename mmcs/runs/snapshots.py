# SPDX-License-Identifier: Apache-2.0
"""Snapshots of a run: a ring of them in every run's folder, and runs that begin from one.

A file of snapshots is a zip archive: the run's record, its past (log and notes), what was seen of
the physics, and one member per snapshot. The index has the SHA-256 of each other member, the
archive's comment that of the index. The engine checks that its own bytes come from the same build
and the same machine.
"""

import hashlib
import json
import tempfile
import zipfile
import zlib
from pathlib import Path

import numpy as np

from mmcs.engine.hosts import image_digest
from mmcs.engine.rows import BLOCK, Rows, blocks
from mmcs.errors import InputError, RunError
from mmcs.files import loads, open_file, short
from mmcs.folder import settle
from mmcs.place import run_file
from mmcs.runs.record import Record, parse
from mmcs.runs.session import Session

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

    def started(self, start: float) -> None:
        """The motion begins now."""
        self._start = start
        self._sim.ring(self._every, RING)

    def play(self, script, until: float) -> tuple[int, str]:
        """As Sim.play(), and takes the snapshots on the way."""
        while self._times and self._times[0] <= until:
            asked = self._times.pop(0)
            result = script.act(self._sim, asked)
            if result[0]:
                return result
            try:
                self._asked[self._sim.snapshot(self._start + asked)] = asked
            except RunError:
                return 1, ""  # an assertion has failed
        return self._sim.play(script, until)

    def taken(self) -> list[dict]:
        """Every snapshot that is kept, with its bytes."""
        return [
            {
                "t": s["t"] - self._start,
                "clock": s["clock"],
                "rows": s["rows"],
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
    index = {
        "snapshots": [{k: v for k, v in s.items() if k != "bytes"} for s in taken],
        "pots": result.pots,
        "log": result.log.shape,
        "truth": result.truth.shape,
    }
    sums = {}

    def add(name: str, parts) -> None:
        whole = hashlib.sha256()
        with file.open(name, "w", force_zip64=True) as member:
            for part in parts:
                whole.update(part)
                member.write(part)
        sums[name] = whole.hexdigest()

    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        add("record.json", [json.dumps(record).encode()])
        add("history.bin", [history])
        for name in ("log", "truth"):
            rows = blocks(getattr(result, name))
            add(f"{name}.bin", (np.ascontiguousarray(part).tobytes() for part in rows))
        for n, snapshot in enumerate(taken):
            add(f"{n}.bin", [snapshot["bytes"]])
        text = json.dumps(index | {"sha256": sums})
        file.writestr("index.json", text)
        file.comment = hashlib.sha256(text.encode()).hexdigest().encode()


class Snapshot:
    """One snapshot out of a file: "FILE", "RUN" or either with "@T", T since the motion began."""

    def __init__(self, name: str):
        self.name, at = _split(name)
        self.path = _find(self.name)
        settle(self.path.absolute().parent)
        try:
            with open_file(self.path) as data, zipfile.ZipFile(data) as file:
                self._read(file, at)
        except (zipfile.BadZipFile, zlib.error, LookupError, ValueError, TypeError, OSError,
                EOFError, RuntimeError, OverflowError, AttributeError):  # fmt: skip
            raise InputError.one(
                self.path, "", None, "not a file of snapshots of MMCS, or damaged"
            ) from None
        self._folder = tempfile.TemporaryDirectory()  # as long as the setup is used

    def _read(self, file: zipfile.ZipFile, at: float | None) -> None:
        """What is needed of the file."""
        text = file.read("index.json")
        if hashlib.sha256(text).hexdigest().encode() != file.comment:
            raise ValueError("index.json was changed")
        index = loads(text)
        sums = index["sha256"]
        self.record: Record = parse(self.path, loads(_member(file, "record.json", sums)))
        self.pots = {int(axis): (int(v[0]), int(v[1])) for axis, v in index["pots"].items()}
        known = index["snapshots"]
        n = _choose(self.path, known, at)
        chosen = known[n]
        self.t, self.clock, self.ring = chosen["t"], chosen["clock"], chosen["ring"]
        self.history = _member(file, "history.bin", sums)
        self.state = _member(file, f"{n}.bin", sums)
        self.log = _rows(file, "log", index["log"], sums, chosen["rows"])
        self.truth = _rows(file, "truth", index["truth"], sums)

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


def _member(file: zipfile.ZipFile, name: str, sums: dict) -> bytes:
    """sums: what the index has of every other member."""
    data = file.read(name)
    if hashlib.sha256(data).hexdigest() != sums[name]:
        raise ValueError(f"{name} was changed")
    return data


def _rows(file: zipfile.ZipFile, name: str, shape, sums: dict, count: int | None = None):
    """An array: the first `count` rows, or all."""
    length, width = shape
    rows, whole = Rows(width), hashlib.sha256()
    left = length if count is None else count
    with file.open(f"{name}.bin") as member:
        while data := member.read(BLOCK * width * 8):
            whole.update(data)
            part = np.frombuffer(data, np.float64)[: left * width]
            left -= len(part) // width
            rows.append(part)
    if whole.hexdigest() != sums[f"{name}.bin"]:
        raise ValueError(f"{name} was changed")
    return rows.array()


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
    if path := run_file(name, NAME):
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


class ResumedSession(Session):
    """A session from a snapshot on; its result is that of the whole run."""

    def __init__(self, sim, setup, snapshot: Snapshot, realtime: bool = False):
        super().__init__(sim, setup, realtime)
        self._snapshot = snapshot
        for rows in blocks(snapshot.log):
            self.log.append(rows)

    def begin(self) -> int:
        """Events, motions and the configured driver are in the snapshot."""
        snapshot = self._snapshot
        try:
            self.sim.restore_bytes(snapshot.state, snapshot.history)
        except ValueError as error:
            raise InputError.one(snapshot.path, "", None, str(error)) from None
        self.start, now, ring = snapshot.record.motion_start_s, snapshot.t, snapshot.ring
        self.script.resume(0, self.start, now, ring)  # a run's program is the first and only one
        for call in self.setup.scenario.call:
            if call.request == "MCALIB" and (call.at < now or (ring and call.at <= now)):
                axes = range(self.setup.axes) if call.axis == "all" else call.axis
                self.pots |= {a: v for a, v in snapshot.pots.items() if a in axes}
        return 0

    def play(self, until: float) -> bool:
        return self.sim.time >= self.start + until or super().play(until)

    def _watch(self, t: float) -> None:
        seen = self._snapshot.truth
        if t <= self._snapshot.t and len(self.truth) < len(seen):
            self.truth.append(seen[len(self.truth)])
        else:
            super()._watch(t)


def resume(setup, snapshot: Snapshot, realtime: bool = False):
    """Carries the rest of the run out."""
    from mmcs.runs.machine import machine, progress

    host = snapshot.record.host
    with machine(setup, host=host) as sim, progress(setup.scenario.duration) as advance:
        image = image_digest(host)
        result = ResumedSession(sim, setup, snapshot, realtime).run(advance)
    result.image = image
    return result
