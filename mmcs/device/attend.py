# SPDX-License-Identifier: Apache-2.0
"""The server in lock-step: its inner loop in C (sim/device/attend.c), and its core."""

import contextlib
import ctypes
import os
import time

import cffi

from mmcs.cached import once
from mmcs.device.libraries import compiled_library
from mmcs.device.lockstep import NO_SAMPLE_S, STRETCH_S
from mmcs.device.pace import IDLE_S
from mmcs.device.programs import Program
from mmcs.device.wire import REQUEST, Wait
from mmcs.engine.sim import Sim

END_IDLE, END_BYTES, END_WAIT, END_REFUSED = range(4)
TURNS = 1000
CHOICE_S = 0.1  # of the clock on the wall, between choices of a core
CALLS = ("read", "write", "run_to", "clock", "samples", "tap_head")
CDEF = """
struct attend {
  void *sim, *read, *write, *run_to, *clock, *samples, *tap_head;
  int epoll, timeout_ms, line, channel, client;
  char name[16];
  int64_t hz, limit, stretch, patience;
  int64_t quiet, wrote;
  void *later;
  int64_t events;
  int fd, length, result, sampled, failed, waits;
  char data[65592];
};
int attend(struct attend *a, int turns);
"""


@once
def _library():
    ffi = cffi.FFI()
    ffi.cdef(CDEF)
    return ffi, ffi.dlopen(str(compiled_library("attend", ("attend.c",))))


class Attendant:
    def __init__(self, sim: Sim, epoll: int):
        self._ffi, self._lib = _library()
        a = self._a = self._ffi.new("struct attend *")
        pointer = lambda what: self._ffi.cast("void *", int(sim.ffi.cast("uintptr_t", what)))  # noqa: E731
        a.sim = pointer(sim._sim)
        for name in CALLS:
            setattr(a, name, pointer(getattr(sim.lib, f"mmcs_sim_{name}")))
        hz = sim.build()["clk_hz"]
        a.quiet, a.wrote, a.epoll, a.timeout_ms, a.hz = -1, -1, epoll, round(IDLE_S * 1000), hz
        a.stretch, a.patience = int(STRETCH_S * hz), round(NO_SAMPLE_S * hz)

    def attend(self, server) -> bool:
        """False: this is not the usual course."""
        a, steps = self._a, server.lockstep
        line, channel = steps.alone, self._channel(server)
        if line is None or channel is None:
            return False
        ((name, file),) = server.files.items()
        a.line, a.channel = line.connection.sock.fileno(), channel.sock.fileno()
        a.client, a.limit = file.client.driver, min(steps.limit, (1 << 62))
        memory = line.process.later.memory
        a.later = self._ffi.NULL if memory is None else self._ffi.from_buffer(memory)
        a.name = name.ljust(16, b"\0")
        end = self._lib.attend(a, TURNS)
        if a.waits:
            steps.has_gone_on()
        if end == END_IDLE:
            return True
        data = bytes(self._ffi.buffer(a.data)[: max(a.length, 0)])
        if end == END_WAIT:
            steps.wait(line, Wait.of(data[REQUEST.size :]))
            steps.passed(bool(a.failed), bool(a.sampled))
        elif end == END_REFUSED:
            channel.refused(file.client, a.result, data, a.events)
        else:
            server.heard(a.fd, data, a.length == 0)
        return True

    @staticmethod
    def _channel(server) -> Program | None:
        """The busiest of the one program that has one file open, if nobody else is there."""
        if len(server.files) != 1:
            return None
        (file,) = server.files.values()
        client, channels = file.client, []
        if client.driver < 0 or client.flags & 3 != os.O_RDWR or server.machine.held(client):
            return None
        for one in server.connections.values():
            if not isinstance(one, Program) or one.ended or one.busy or one.data or not one.idle():
                return None
            if one is not file and one.line is None:
                channels.append(one)
        return max(channels, key=lambda one: one.calls, default=None)


class Core:
    """The core that the server shares with its programs. Of all of them one runs at a time, and to
    wake a process on another core takes more processor time than all its calls of a sample."""

    def __init__(self):
        self._allowed = os.sched_getaffinity(0)
        self._due = 0.0
        self.share([], 0.0)  # programs that the server starts begin there

    def share(self, pids: list[int], now: float) -> None:
        """Chooses the core anew every CHOICE_S: an idle one, if there is one."""
        if now < self._due:
            return
        self._due = now + CHOICE_S
        os.sched_setaffinity(0, self._allowed)
        time.sleep(1e-6)  # the kernel wakes a process on an idle core
        self._move(pids, {ctypes.CDLL(None).sched_getcpu()})

    def leave(self, pids: list[int]) -> None:
        self._move(pids, self._allowed)

    @staticmethod
    def _move(pids: list[int], cores: set[int]) -> None:
        os.sched_setaffinity(0, cores)
        for pid in pids:
            with contextlib.suppress(OSError):  # it may have ended
                for thread in os.listdir(f"/proc/{pid}/task"):
                    os.sched_setaffinity(int(thread), cores)
