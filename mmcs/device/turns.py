# SPDX-License-Identifier: Apache-2.0
"""Lock-step: sim/device/turns.h, whose names the names here are, for the server. And its core."""

import contextlib
import ctypes
import os
import time

from mmcs.device import wire

WHY = (
    "has gone on for {:g} s without a call that waits for the machine: machine time stands still",
    "waits for the outside world: machine time stands still",
    "goes on no more: its threads wait for each other",
)
CHOICE_S = 0.1  # of real time, between choices of a core


class Turns:
    """Whose turn it is. `now` has the fields of struct turns."""

    def __init__(self, machine, epoll: int, on: bool, signal, tell):
        """signal(): sends the driver's signals, of which signalled() tells. tell(text): stderr."""
        sim = machine.sim
        self._ffi, self._lib, self.on, self._tell = sim.ffi, sim.lib, on, tell
        made = self._lib.turns_create(sim.handle, machine.now, epoll)
        self.now = self._ffi.gc(made, self._lib.turns_destroy)
        callback = self._ffi.callback
        self._calls = [  # C has them as long as this lives
            callback("int(void)", lambda: len(signal())),
            callback("int(int, int)", lambda *end: int(wire.is_outside(*end, self.pids()))),
            callback("void(int, int)", self._say),
        ]
        self.now.send_signals, self.now.is_outside, self.now.tell = self._calls
        self.close = lambda: self._ffi.release(self.now)  # all lines end

    def __getattr__(self, name: str):
        """turns_NAME(), of this."""
        call = getattr(self._lib, f"turns_{name}")
        return lambda *arguments: call(self.now, *arguments)

    def read_states(self, pid: int, client, size: int) -> tuple[int, bytes]:
        states = self._ffi.new("char[]", size)
        result = self._lib.turns_read(self.now, pid, client, states, size)
        return result, bytes(self._ffi.buffer(states, max(result, 0)))

    def pids(self) -> list[int]:
        pids = self._ffi.new("int32_t[]", 1000)
        return [*pids[0 : self._lib.turns_pids(self.now, pids, len(pids))]]

    def _say(self, pid: int, why: int) -> None:
        who = f"{wire.command(pid) or 'a program'} ({pid})" if pid else "a program"
        self._tell(f"mmcs: lock-step: {who} {WHY[why].format(self.now.silent_s)}")


class Core:
    """The core that the server shares with its programs. Of all of them one runs at a time, and to
    wake a process on another core takes more processor time than all its calls of a sample."""

    def __init__(self, turns: Turns):
        self._allowed = os.sched_getaffinity(0)
        self._turns, self._due = turns, 0.0
        self.share(0.0)  # programs that the server starts begin there

    def share(self, now: float) -> None:
        """Chooses the core anew every CHOICE_S: an idle one, if there is one."""
        if now >= self._due:
            self._due = now + CHOICE_S
            os.sched_setaffinity(0, self._allowed)
            time.sleep(1e-6)  # the kernel wakes a process on an idle core
            self._move({ctypes.CDLL(None).sched_getcpu()})

    def leave(self) -> None:
        self._move(self._allowed)

    def _move(self, cores: set[int]) -> None:
        os.sched_setaffinity(0, cores)
        for pid in self._turns.pids():
            with contextlib.suppress(OSError):  # it may have ended
                for thread in os.listdir(f"/proc/{pid}/task"):
                    os.sched_setaffinity(int(thread), cores)
