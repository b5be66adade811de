# SPDX-License-Identifier: Apache-2.0
"""The simulated machine as a Python object: a thin wrapper of sim/abi/mmcs_sim.h.

The C declarations are read from the very headers of sim/abi (mcdef.py), so they cannot drift apart.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from mmcs import mcdef
from mmcs.cached import once
from mmcs.engine.script import Playing, listed, made_from
from mmcs.engine.watching import Watching
from mmcs.errors import RunError
from mmcs.mcdef import make_ffi

if TYPE_CHECKING:
    import numpy as np


@once
def load_library(path: Path):
    try:
        return make_ffi().dlopen(str(path))
    except OSError as error:
        raise RunError(f"{path}: the simulator library does not load: {error}") from None


class Sim(Watching, Playing):
    """One machine, from power-on until close(). Every call may let simulated time pass."""

    def __init__(self, library: Path, setup: bytes):
        """setup: a set-up file's bytes."""
        self.ffi, self.lib = make_ffi(), load_library(library)
        self._head = self.ffi.new("mmcs_tap_head *")
        self._sim = made_from(self.lib.mmcs_sim_create_from, setup)
        self.axes = self.lib.mmcs_sim_axes(self._sim)

    @property
    def handle(self):
        """What functions of the headers take."""
        return self._sim

    def destroy(self) -> None:
        if self._sim:
            self.lib.mmcs_sim_destroy(self._sim)
            self._sim = None

    def __enter__(self) -> Sim:
        return self

    def __exit__(self, *_) -> None:
        self.destroy()

    # --- what the build is ---

    def build(self) -> dict[str, int]:
        names = ("cards", "clk_hz")
        return {name: getattr(self.lib, f"mmcs_sim_build_{name}")() for name in names}

    def trace(self, path: Path, from_s: float = 0.0, to_s: float = 1e9) -> None:
        """Waveforms of this stretch, from now on if its beginning has passed."""
        if self.lib.mmcs_sim_trace(self._sim, os.fsencode(path), from_s, to_s):
            raise RunError(f"{path}: the trace file cannot be made")

    def build_id(self) -> str:
        return build_id(self.lib)

    def phases(self) -> dict[str, tuple[int, float, float]]:
        """Parts of a servo pass on a real processor: passes, mean and longest time in us."""
        found = self.ffi.new("mmcs_phase[]", 16)
        count = self.lib.mmcs_sim_phases(self._sim, found, 16)
        return {
            self.ffi.string(p.name).decode(): (p.passes, p.mean_us, p.max_us)
            for p in found[0:count]
        }

    def caches(self) -> dict[str, dict[str, int]]:
        """What the model's cache of each kind of part did: hits, misses, states and bytes now."""
        found = self.ffi.new("mmcs_cache[]", 16)
        count = self.lib.mmcs_sim_caches(self._sim, found, 16)
        return {
            self.ffi.string(c.part).decode(): {
                name: getattr(c, name) for name in ("hits", "misses", "states", "bytes")
            }
            for c in found[0:count]
        }

    # --- /dev/mc0 ---

    def open(self, flags: int = 2) -> int:
        return self.lib.mmcs_sim_open(self._sim, flags)

    def close(self, client: int) -> int:
        return self.lib.mmcs_sim_close(self._sim, client)

    def ioctl(self, client: int, request: int, arg: object = None) -> int:
        argument = self.ffi.NULL if arg is None else arg
        return self.lib.mmcs_sim_ioctl(self._sim, client, request, argument)

    def write(self, client: int, setpoints: list[int]) -> int:
        data = self.ffi.new("int32_t[]", setpoints)
        return self.lib.mmcs_sim_write(self._sim, client, data, 4 * len(setpoints))

    def read(self, client: int, axes: int | None = None) -> list[dict[str, int]]:
        """What the driver reports: one mc_state per axis."""
        count = self.axes if axes is None else axes
        states = self.ffi.new("struct mc_state[]", count)
        size = self.ffi.sizeof("struct mc_state")
        got = self.lib.mmcs_sim_read(self._sim, client, states, count * size)
        if got < 0:
            raise OSError(-got, "read of /dev/mc0")
        names = mcdef.fields("mc_state")
        return [{n: getattr(state, n) for n in names} for state in states[0 : got // size]]

    # what a program does with it for a scenario: sim/service

    def configure(self, client: int, driver: dict, params: list[dict], on: bool = True,
                  set_up: bool = True) -> tuple[int, str]:  # fmt: skip
        """driver: fields of mmcs_driver. The result, and the request that was refused."""
        what = set_up * self.lib.MMCS_SET_UP | on * self.lib.MMCS_SWITCH_ON
        given, refused = self.ffi.new("mmcs_driver *", driver), self.ffi.new("char[]", 80)
        result = self.lib.mmcs_sim_configure(
            self._sim, client, what, given, mcdef.new_params(params), refused, 80
        )
        return result, self.ffi.string(refused).decode()

    # ioctl for arguments that come from another process

    def ioctl_bytes(self, client: int, request: int, data: bytes) -> tuple[int, bytes]:
        return self.asked(request, data, self.lib.mmcs_sim_ioctl, self._sim, client)

    def asked(self, request: int, data: bytes, call, *of) -> tuple[int, bytes]:
        """The argument in, as long as the request number says; the argument out."""
        size = request >> 16 & 0x1FFF
        argument = bytearray(max(size, 256))
        argument[: len(data)] = data
        pointer = self.ffi.from_buffer(argument)
        result = call(*of, request, pointer)
        return result, bytes(argument[:size]) if result >= 0 and request & 0x40000000 else b""

    def signals(self, client: int) -> int:
        return self.lib.mmcs_sim_signals(self._sim, client)

    def set_look(self, look) -> None:
        """look() is called every millisecond of the machine's time while a request waits; True:
        the request gives up. It must not raise."""
        self._look = self.ffi.callback("int(void *)", lambda _: int(look()), error=1)
        self.lib.mmcs_sim_set_look(self._sim, self._look, self.ffi.NULL)

    # --- the bus by hand ---

    def bus_read(self, offset: int, am: int = 0x2D, size: int = 1) -> int:
        """Raises TimeoutError when nobody answers, OSError on a bus error."""
        value = self.ffi.new("uint32_t *")
        result = self.lib.mmcs_sim_bus_read(self._sim, offset, am, size, value)
        _bus_check(result, offset)
        return value[0]

    def bus_write(self, offset: int, value: int, am: int = 0x2D, size: int = 1) -> None:
        result = self.lib.mmcs_sim_bus_write(self._sim, offset, am, size, value)
        _bus_check(result, offset)

    # --- motion, events, time ---

    def add_segment(self, **fields) -> None:
        """Takes the fields of mmcs_segment; the kind by name, the table as a list."""
        table = list(fields.pop("table", ()))
        fields |= {"kind": mcdef.SEGMENT_KINDS.index(fields["kind"]), "table_len": len(table)}
        segment, numbers = self.ffi.new("mmcs_segment *", fields), self.ffi.new("double[]", table)
        if self.lib.mmcs_sim_add_segment(self._sim, segment, numbers):
            raise RunError(f"the engine refuses a motion of axis {fields.get('axis')}")

    def start_motion(self, client: int) -> int:
        return self.lib.mmcs_sim_start_motion(self._sim, client)

    def input_names(self) -> list[str]:
        return input_names(self.lib)

    def add_event(self, t: float, input_: int, index: int, value: float) -> None:
        event = self.ffi.new("mmcs_event *", {"t": t, "input": input_, "index": index})
        event.value = value
        if self.lib.mmcs_sim_add_event(self._sim, event):
            name = dict(enumerate(self.input_names())).get(input_, f"input {input_}")
            raise RunError(f"{name} at {t:.6f} s: {self.notes()[-1]['text']}")

    def input_value(self, input_: int, index: int, t: float) -> float:
        """At a time that has been."""
        return self.lib.mmcs_sim_input_value(self._sim, input_, index, t)

    def run(self, until_s: float) -> bool:
        """False when an assertion of the model failed; the notes tell which."""
        return self.lib.mmcs_sim_run(self._sim, until_s) == 0

    @property
    def time(self) -> float:
        return self.lib.mmcs_sim_time(self._sim)

    @property
    def clock(self) -> int:
        return self.lib.mmcs_sim_clock(self._sim)

    # --- results ---

    def log(self) -> np.ndarray:
        """A copy of the log, but for what was taken: a row per servo sample, columns as in the
        header."""
        import numpy as np

        rows, cols = self.ffi.new("int64_t *"), self.ffi.new("int32_t *")
        data = self.lib.mmcs_sim_log(self._sim, rows, cols)
        if not rows[0]:
            return np.empty((0, 1 + 7 * self.axes))
        raw = self.ffi.buffer(data, rows[0] * cols[0] * 8)
        return np.frombuffer(raw, dtype=np.float64).reshape(rows[0], cols[0]).copy()

    def take_log(self) -> np.ndarray:
        """The rows that have come since they were last taken; they are the caller's to keep."""
        rows = self.log()
        self.lib.mmcs_sim_log_taken(self._sim)
        return rows

    def notes_lost(self) -> int:
        """How many notes have come after the last that is kept."""
        return self.lib.mmcs_sim_notes_lost(self._sim)

    def notes(self) -> list[dict]:
        text = lambda chars: self.ffi.string(chars).decode(errors="replace")  # noqa: E731
        return [
            {"t": n.t, "kind": text(n.kind), "axis": n.axis, "text": text(n.text)}
            for n in listed("mmcs_note", self.lib.mmcs_sim_notes, self._sim)
        ]

    def stats(self) -> dict[str, float]:
        stats = self.ffi.new("mmcs_stats *")
        self.lib.mmcs_sim_get_stats(self._sim, stats)
        return {name: getattr(stats, name) for name, _ in self.ffi.typeof("mmcs_stats").fields}

    def true(self, axis: int) -> dict[str, float]:
        """What the physics did: angle and velocity (joint), current, encoder transitions."""
        truth = self.ffi.new("mmcs_truth *")
        self.lib.mmcs_sim_true(self._sim, axis, truth)
        return {n: getattr(truth, n) for n in ("angle", "velocity", "current", "count")}

    def encoder_register(self, axis: int) -> int:
        """The 16-bit counter on the card, read without disturbing it."""
        path = f"g_card[{axis // 2}].u_card.g_axis[{axis % 2}].u_axis.u_encoder.count_q"
        return self.register(list(self.registers()).index(path))

    def registers(self) -> dict[str, int]:
        """Every register of the hardware, by its name from mmcs down, and its bits."""
        return _registers(self.lib)

    def register(self, number: int) -> int:
        """The value of one now, by its place in registers(), read without disturbing it."""
        return self.lib.mmcs_sim_register(self._sim, number)

    def checkpoints(self) -> list[tuple[int, int, int, int]]:
        """Samples, clock, hash of the samples, hash of what left the machine; every 32 samples."""
        found = listed("mmcs_checkpoint", self.lib.mmcs_sim_checkpoints, self._sim)
        return [(p.samples, p.clock, p.hash, p.trail) for p in found]

    # --- time travel ---

    def snapshot(self, at_s: float | None = None) -> int:
        """The number of a snapshot of now; or runs until at_s, for one of that instant or of the
        last one before it at which no firmware is active."""
        number = self.lib.mmcs_sim_snapshot(self._sim, -1.0 if at_s is None else at_s)
        if number < 0:
            raise RunError("no snapshot: an assertion of the machine has failed")
        return number

    def restore(self, number: int) -> None:
        """Back to a snapshot; those taken later are forgotten."""
        if self.lib.mmcs_sim_restore(self._sim, number):
            raise RunError(f"there is no snapshot {number}")

    def drop(self, number: int) -> None:
        if self.lib.mmcs_sim_drop(self._sim, number):
            raise RunError(f"there is no snapshot {number}")

    def ring(self, every_s: float, count: int) -> None:
        """From now on run() takes a snapshot every so often and keeps the last `count`."""
        if self.lib.mmcs_sim_ring(self._sim, every_s, count):
            raise RunError("impossible ring of snapshots")

    def snapshots(self) -> list[dict]:
        """Those that there are: id, clock, t, bytes, rows; kept: not by the ring."""
        found = listed("mmcs_snapshot", self.lib.mmcs_sim_snapshots, self._sim)
        names = ("id", "clock", "t", "bytes", "rows", "kept")
        return [{n: getattr(one, n) for n in names} for one in found]

    def snapshot_bytes(self, number: int) -> bytes:
        out = self.ffi.new("const uint8_t **")
        size = self.lib.mmcs_sim_snapshot_bytes(self._sim, number, out)
        if size < 0:
            raise RunError(f"there is no snapshot {number}")
        return bytes(self.ffi.buffer(out[0], size))

    def history_bytes(self) -> bytes:
        """The log and notes so far, which go with every snapshot taken so far."""
        out = self.ffi.new("const uint8_t **")
        size = self.lib.mmcs_sim_history_bytes(self._sim, out)
        return bytes(self.ffi.buffer(out[0], size))

    def restore_bytes(self, snapshot: bytes, history: bytes) -> None:
        """Raises ValueError with one sentence when they come from elsewhere or are damaged."""
        err = self.ffi.new("char[]", 300)
        a, b = self.ffi.from_buffer(snapshot), self.ffi.from_buffer(history)
        result = self.lib.mmcs_sim_restore_bytes(
            self._sim, a, len(snapshot), b, len(history), err, 300
        )
        if result:
            raise ValueError(self.ffi.string(err).decode(errors="replace"))

    def future(self) -> int:
        """Digest of all that decides what comes, time included, and of nothing that has been."""
        return self.lib.mmcs_sim_future(self._sim)

    def hash(self) -> str:
        return f"0x{self.lib.mmcs_sim_hash(self._sim):016x}"


def build_id(lib) -> str:
    """Of a library: what a set-up and a snapshot must match."""
    return make_ffi().string(lib.mmcs_sim_build_id()).decode()


def input_names(lib) -> list[str]:
    return _names(lib.mmcs_sim_input_name)


def library_registers(library: Path) -> dict[str, int]:
    """The same of a machine that need not be made."""
    return _registers(load_library(library))


def _registers(lib) -> dict[str, int]:
    names = _names(lib.mmcs_sim_register_name)
    return {name: lib.mmcs_sim_register_width(n) for n, name in enumerate(names)}


def _names(name_of) -> list[str]:
    """Of the numbers from 0 on, up to the first without one."""
    names = []
    while (name := name_of(len(names))) != make_ffi().NULL:
        names.append(make_ffi().string(name).decode())
    return names


def _bus_check(result: int, offset: int) -> None:
    if result == 1:
        raise TimeoutError(f"bus time-out at offset 0x{offset:03x}")
    if result:
        raise OSError(f"bus error at offset 0x{offset:03x}")
