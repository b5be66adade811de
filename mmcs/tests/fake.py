# SPDX-License-Identifier: Apache-2.0
"""A stand-in for mmcs.sim.Sim: every axis follows its setpoint with one time constant."""

import math

import numpy as np

from mmcs import mcdef, setup_file
from mmcs.logcols import FIELDS

TAU_S = 0.02
SAMPLE_S = 0.001


class FakeScript:
    """Keeps what it is given; the driver is asked at its begin."""

    start, client = 0.0, -1

    def __init__(self, setup: bytes):
        self.found = setup_file.read(setup)

    def _records(self, kind: str) -> list[dict]:
        ffi = mcdef.make_ffi()
        names = [name for name, _ in ffi.typeof(self.found[kind]).item.fields]
        return [{name: getattr(one, name) for name in names} for one in self.found[kind]]

    def begin(self, sim):
        what = next(iter(sim.fail), "")
        sim.calls.append(("begin", self._records("driver")[0], len(self.found["param"])))
        sim.segments, sim.events, sim.start = (
            self._records("segment"),
            self._records("event"),
            sim.now,
        )
        self.start, self.client = sim.now, 0
        refusals = [mcdef.make_ffi().string(one.request).decode() for one in self.found["refusal"]]
        sign = 1 if what.split()[:1] and what.split()[0] in refusals else -1
        return sign * sim.fail.get(what, 0), what

    def answers(self):
        return []

    told = answers


class FakeSim:
    """Records every request; `fail` maps a request's name to the errno it returns."""

    def __init__(self, axes=1, fail=None, notes=(), assert_at=None, short=0.0):
        self.axes, self.fail, self.assert_at, self.short = axes, fail or {}, assert_at, short
        self.calls, self.segments, self.events = [], [], []
        self.rows, self.taken, self._notes, self.lost = [], [], list(notes), 0
        self.now, self.start = 0.0, None
        self.y = [0.0] * axes

    def build(self):
        return {"cards": (self.axes + 1) // 2, "clk_hz": 8_000_000, "skip": 0, "trace": 0}

    def close(self, client):
        self.calls.append(("close", client))
        return 0

    def ioctl(self, client, request, arg=None):
        known = mcdef.constants().items()
        name = next(n for n, v in known if v == request and n.startswith("M") and "_" not in n)
        value = None
        if arg is not None:
            value = arg[0] if "*" in str(arg) and "mc_param" not in str(arg) else arg.which
        self.calls.append((name, value))
        return -self.fail.get(name, 0)

    def new_script(self, setup):
        return FakeScript(setup)

    def play(self, script, until):
        return int(not self.run(script.start + until)), ""

    def write(self, client, setpoints):
        self.calls.append(("write", list(setpoints)))
        return 4 * len(setpoints)

    def read(self, client, axes=None):
        return [{"encnow": round(y), "errcode": 0} for y in self.y]

    def input_names(self):
        return ["estop", "cable_cut", "encoder_stuck"]

    def run(self, until_s):
        while self.now < until_s - 1e-12:
            self.now += SAMPLE_S
            t = self.now - self.start
            if self.assert_at is not None and t >= self.assert_at:
                self._notes.append({"t": self.now, "kind": "assert", "axis": -1, "text": "boom"})
                return False
            row = [t]
            for axis in range(self.axes):
                goal = self._setpoint(axis, t)
                reached = goal - self.short if goal else 0.0
                self.y[axis] += (reached - self.y[axis]) * (1 - math.exp(-SAMPLE_S / TAU_S))
                count = round(self.y[axis])
                row += [goal, count, 0, goal - count, 0, 0, self.y[axis] * 1e-3]
            self.rows.append(row)
        return True

    def _setpoint(self, axis, t):
        own = [s for s in self.segments if s["axis"] == axis and s["t0"] <= t]
        return own[-1].get("to", 0.0) if own else 0.0

    @property
    def time(self):
        return self.now

    def log(self):
        return np.array(self.rows).reshape(-1, 1 + len(FIELDS) * self.axes)

    def take_log(self):
        rows, self.rows[:] = self.log(), []
        self.taken += rows.tolist()
        return rows

    def notes_lost(self):
        return self.lost

    def notes(self):
        return self._notes

    def stats(self):
        names = "interrupts missed overruns panics spurious clips bus_errors evals bus_cycles"
        names += " cache_hits cache_misses cache_bytes"
        return {n: 0 for n in names.split()} | {"cycles": int(self.now * 8e6)}

    def phases(self):
        return {}

    def true(self, axis):
        y = self.y[axis]
        return {"angle": y * 1e-3, "velocity": 0.0, "current": 0.0, "count": round(y)}

    def encoder_register(self, axis):
        return round(self.y[axis]) & 0xFFFF

    def checkpoints(self):
        return []

    def build_id(self):
        return "fake"

    def hash(self):
        return f"0x{hash(tuple(map(tuple, self.taken + self.rows))) & (2**64 - 1):016x}"
