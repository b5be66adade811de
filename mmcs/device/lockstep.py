# SPDX-License-Identifier: Apache-2.0
"""Lock-step: machine time passes only while every attached program waits (docs/use/device.md).

Each thread of a program has a line, a connection on which it says what it waits for
(sim/device/wire.h). Of all of them one runs at a time, in the order of programs and threads; when
nobody can, the machine runs up to what ends a wait first. The same programs: the same run.
"""

from __future__ import annotations

import ctypes
import os
import select
import time
from dataclasses import dataclass, field

from mmcs.device import wire

STRETCH_S = 0.01  # of time between looks at the stop path
LOOK_S = 0.001  # of time between looks at descriptors from outside, when a wait has an end
SILENT_S, OUTSIDE_S = 5.0, 1.0  # of the clock on the wall, and it is told
NO_SAMPLE_S = 2.5  # of the machine: with an interval over 1 s MENABLE fails
SIGUSR1, SIGCHLD = 10, 17


@dataclass(eq=False)
class Line:
    """A thread: it runs (no wait), waits, or may go on (`cause` is set)."""

    connection: object
    process: Process
    number: int
    key: int
    wait: wire.Wait | None = None
    cause: int | None = None
    patience: int = 0  # the clock until which it waits for a sample
    look: bool = False  # others have run since it looked at its descriptors
    outside: bool = False  # some of them are of the outside world

    @property
    def order(self) -> tuple[int, int]:
        return self.process.number, self.number

    def wants(self, what: int) -> bool:
        return self.cause is None and self.wait is not None and bool(self.wait.what & what)

    @property
    def sleeps(self) -> bool:
        """It waits for another thread or a child, for ever."""
        wait = self.wait
        if self.cause is not None or wait is None or wait.until != wire.NEVER:
            return False
        return not wait.what & (wire.WAIT_SAMPLE | wire.WAIT_FILES)

    def hears(self, signals: int) -> bool:
        """It waits, or may go on, and lets one of them through."""
        wait = self.wait
        return wait is not None and not wait.what & wire.WAIT_DEAF and bool(signals & ~wait.mask)


@dataclass(eq=False)
class Process:
    pid: int
    number: int
    starting: bool = True  # has no line yet, and will
    expected: int = 0  # threads of it of which the same holds
    handle: int = -1
    lines: list[Line] = field(default_factory=list)
    timers: dict[int, list[int]] = field(default_factory=dict)  # first, interval, value, signal, fd
    fired: dict[int, int] = field(default_factory=dict)  # descriptor: how often
    later: wire.Later = field(default_factory=wire.Later)

    def join(self) -> None:
        """Waits for the end of a thread end when it is neither there nor on its way."""
        for line in self.lines if self.expected == 0 else ():
            if line.wants(wire.WAIT_THREAD) and all(x.key != line.wait.key for x in self.lines):
                line.cause = wire.CAUSE_WOKEN

    def __str__(self) -> str:
        return f"{wire.command(self.pid) or 'a program'} ({self.pid})"


class Lockstep:
    def __init__(self, sim, poll: select.epoll, signal, tell):
        """signal(): sends the driver's signals, of which signalled() tells. tell(text): stderr."""
        self._sim, self._poll, self.signal, self._tell = sim, poll, signal, tell
        self._hz = sim.build()["clk_hz"]
        self._processes: dict[int, Process] = {}
        self._handles: dict[int, Process] = {}
        self._ended: list[Process] = []
        self._numbers = 0
        self._running: Line | None = None
        self._last = (-1, -1)  # the order of who ran last
        self.watchers: list[tuple[object, int]] = []  # for a sample, beside the lines
        self._patience = 0  # the clock until which they wait
        self._began = time.monotonic()  # of what runs now
        self._told = self.on = False
        self.limit = 1 << 62  # a clock that time does not go past
        self.good = True  # no assertion of the model has failed

    # --- who there is ---

    def expect(self, pid: int) -> Process:
        """A program that has been started: nothing goes on before it has come, or ended."""
        if pid in self._processes:
            return self._processes[pid]
        self._numbers += 1
        process = self._processes[pid] = Process(pid, self._numbers)
        try:
            process.handle = os.pidfd_open(pid)
        except OSError:
            self._ended.append(process)
            return process
        self._handles[process.handle] = process
        self._began, self._told = time.monotonic(), False
        self._poll.register(process.handle, select.EPOLLIN)
        return process

    def has(self, pid: int) -> bool:
        return pid in self._processes

    @property
    def attached(self) -> list[int]:
        """Processes with the library, of all whose threads one runs at a time."""
        return [p.pid for p in self._processes.values() if any(line.key for line in p.lines)]

    def heard(self, fd: int) -> bool:
        """True: this descriptor was a process, which has ended."""
        process = self._handles.pop(fd, None)
        if process is None:
            return False
        self._poll.unregister(fd)
        os.close(fd)
        self._ended.append(process)
        return True

    def close(self) -> None:
        for fd in list(self._handles):
            self.heard(fd)

    def open_line(self, connection, kind: int, key: int, pid: int) -> Line:
        process = self.expect(pid)
        if kind & 0xFF == wire.LINE_THREAD:
            process.expected -= 1
        else:
            for line in list(process.lines):  # of the program that it was before
                self._drop(line)
            process.starting, process.expected = False, 0
        line = Line(connection, process, kind >> 8, key)
        line.wait, line.cause = wire.Wait(wire.NEVER, 0, 0, 0, 0, ()), wire.CAUSE_DUE
        process.lines.append(line)
        process.join()
        return line

    def leave(self, line: Line, says_so: bool = False) -> None:
        """A thread says that it ends. A connection that ends unsaid: all of the program does."""
        if line not in line.process.lines:
            return
        for one in [line] if says_so else list(line.process.lines):
            self._drop(one)
        if not line.process.lines:
            line.process.starting = True  # another program, or its end

    def _drop(self, line: Line) -> None:
        line.process.lines.remove(line)
        if self._running is line:
            self._running = None
            self._others_ran(None)
        line.process.join()

    def _reap(self) -> None:
        for process in self._ended:
            for line in list(process.lines):
                self._drop(line)
            del self._processes[process.pid]
            self._others_ran(None)
            for line in self._lines():
                if line.wants(wire.WAIT_CHILD):
                    line.cause = wire.CAUSE_WOKEN
            for other in self._processes.values():
                self._deliver(other, 1 << (SIGCHLD - 1))
        self._ended = []

    def _lines(self) -> list[Line]:
        return [line for process in self._processes.values() for line in process.lines]

    # --- what a line asks ---

    def wait(self, line: Line, wait: wire.Wait) -> None:
        """It runs no more, until it may go on."""
        line.wait, line.cause, line.look = wait, None, False
        line.patience = self._last_moment()
        if self._running is line:
            self._running = None
        if not wait.what & wire.WAIT_AGAIN:
            self._others_ran(line)
        if wait.pending:
            self._deliver(line.process, wait.pending)
        line.process.join()
        if wait.what & wire.WAIT_CHILD and len(self._processes) == 1:
            line.cause, line.outside = wire.CAUSE_OUTSIDE, True
        if wait.what & wire.WAIT_FILES:
            line.outside = bool(wait.files) and all(
                wire.is_outside(line.process.pid, fd, self._processes) for fd in wait.files
            )
            if line.outside and wait.until == wire.NEVER:
                line.cause = wire.CAUSE_OUTSIDE

    def _others_ran(self, line: Line | None) -> None:
        for other in self._lines():
            if other is not line and other.wants(wire.WAIT_FILES):
                other.look = True

    def cancel(self, line: Line) -> None:
        if line.wait is not None and line.cause is None:
            line.cause = wire.CAUSE_SIGNAL

    def wake(self, line: Line, key: int, count: int) -> int:
        found = [x for x in line.process.lines if x.wants(wire.WAIT_KEY) and x.wait.key == key]
        for other in found[:count]:
            other.cause = wire.CAUSE_WOKEN
        return min(count, len(found))

    def spawn(self, line: Line, pid: int, in_vain: bool) -> None:
        if pid == 0:
            line.process.expected += -1 if in_vain else 1
        else:
            self.expect(pid)

    def timer(self, line: Line, number: int, timer: tuple | None) -> bytes:
        timers = line.process.timers
        before = timers.get(number, [0, 0, 0, 0, -1])
        if timer is not None and timer[0]:
            timers[number] = list(timer)
        elif timer is not None:
            timers.pop(number, None)
        return wire.TIMER.pack(*before)

    def take_later(self) -> list[tuple[bytes, bytes]]:
        """The write()s without an answer: each file's name, data."""
        return [due for process in self._processes.values() if (due := process.later.take())]

    def fired(self, line: Line) -> bytes:
        fired, line.process.fired = line.process.fired, {}
        return b"".join(wire.FIRED.pack(fd, count) for fd, count in fired.items())

    def signalled(self, pids: list[int], signals: int = 1 << (SIGUSR1 - 1)) -> None:
        """The driver, or somebody attached, has sent them these signals."""
        for pid in pids:
            if pid in self._processes:
                self._deliver(self._processes[pid], signals)

    def watch(self, connection, pid: int) -> None:
        """It is answered behind the next sample, or with EIO if the servo stands still."""
        self.watchers.append((connection, pid))
        self._patience = self._last_moment()

    def _last_moment(self) -> int:
        return self._sim.clock + round(NO_SAMPLE_S * self._hz)

    def _deliver(self, process: Process, signals: int) -> None:
        """Signals are pending in a process: the first thread that lets one through wakes."""
        able = [x for x in process.lines if x.hears(signals)]
        if able and all(line.cause is None for line in able):
            able[0].cause = wire.CAUSE_SIGNAL

    # --- whose turn it is ---

    @property
    def busy(self) -> bool:
        """Somebody runs, or is on his way."""
        return self._running is not None or any(
            p.starting or p.expected > 0 for p in self._processes.values()
        )

    @property
    def alone(self) -> Line | None:
        """The line that runs, if nothing else can go on but by what it does, as time passes."""
        line, programs = self._running, self._processes.values()
        if line is None or self._ended or self.watchers:
            return None
        usual = not any(p.starting or p.expected > 0 or p.timers or p.fired for p in programs)
        return line if usual and all(x is line or x.sleeps for x in self._lines()) else None

    def has_gone_on(self) -> None:
        """The line that runs has waited meanwhile."""
        self._began, self._told = time.monotonic(), False

    def passed(self, failed: bool, sampled: bool) -> None:
        """Time has, while all lines waited."""
        self.good = self.good and not failed
        self.signal()
        self._wake_up(self._lines(), sampled)

    @property
    def rests(self) -> bool:
        """There is nothing to do before somebody asks for something."""
        return not self._ended and (self.busy or not self._processes)

    def now(self) -> bytes:
        sim = self._sim
        fired = any(p.fired for p in self._processes.values())
        return wire.NOW_DATA.pack(sim.clock * 10**9 // self._hz, sim.samples & 0xFFFFFFFF, fired)

    def turn(self) -> None:
        """A little of what there is to do: one goes on, or time passes."""
        if self._ended:
            self._reap()
        if self.busy:
            self._tell_of_silence()
            return
        lines = self._lines()
        ready = [x for x in lines if x.cause is not None or x.look]
        if ready:
            later = [x for x in ready if x.order > self._last]
            self._release(min(later or ready, key=lambda x: x.order))
        elif lines:
            self._pass_time(lines)

    def _release(self, line: Line) -> None:
        cause = wire.CAUSE_WOKEN if line.cause is None else line.cause
        line.wait, line.cause, line.look = None, None, False
        self._running, self._last = line, line.order
        self._began, self._told = time.monotonic(), False
        line.outside = cause == wire.CAUSE_OUTSIDE
        line.connection.reply(cause, self.now())

    def _tell_of_silence(self) -> None:
        line = self._running
        outside = line is not None and line.outside
        if self._told or time.monotonic() - self._began < (OUTSIDE_S if outside else SILENT_S):
            return
        self._told = True
        waiting = (p for p in self._processes.values() if p.starting or p.expected > 0)
        who = line.process if line is not None else next(waiting, "a program")
        what = (
            "waits for the outside world" if outside
            else f"has gone on for {SILENT_S:g} s without a call that waits for the machine"
        )  # fmt: skip
        self._tell(f"mmcs: lock-step: {who} {what}: machine time stands still")

    def _pass_time(self, lines: list[Line]) -> None:
        sim = self._sim
        ends = [x.wait.until for x in lines if x.wait.until != wire.NEVER]
        ends += [t[0] for p in self._processes.values() for t in p.timers.values()]
        samples = bool(self.watchers) or any(x.wait.what & wire.WAIT_SAMPLE for x in lines)
        files = [x for x in lines if x.wait.what & wire.WAIT_FILES]
        if files and not ends and not samples and len(files) == len(lines):
            files[0].cause = wire.CAUSE_OUTSIDE  # only the outside world can go on
            return
        stretch = LOOK_S if any(x.outside for x in files) else STRETCH_S
        end = min(self.limit, sim.clock + int(stretch * self._hz))
        if ends:
            end = min(end, -(-min(ends) * self._hz // 10**9))
        before = sim.samples
        failed = end > sim.clock and not sim.run_to(end, samples)
        self.passed(failed, sim.samples != before)

    def _wake_up(self, lines: list[Line], sampled: bool) -> None:
        now = self._sim.clock * 10**9 // self._hz
        for process in self._processes.values():
            for timer in list(process.timers.values()):
                self._run_out(process, timer, now)
        for line in lines:
            wait = line.wait
            if line.cause is None and wait.until <= now:
                line.cause = wire.CAUSE_DUE
            if sampled and wait.what & wire.WAIT_SAMPLE and line.cause in (None, wire.CAUSE_SIGNAL):
                line.cause = wire.CAUSE_DUE  # a signal that came with the sample takes it not away
            if line.wants(wire.WAIT_SAMPLE) and self._sim.clock > line.patience:
                line.cause = wire.CAUSE_LATE
            if line.outside and wait.what & wire.WAIT_FILES:
                line.look = True
        self.answer_watchers(sampled)

    def answer_watchers(self, sampled: bool) -> None:
        if not self.watchers or not (sampled or self._sim.clock > self._patience):
            return
        watchers, self.watchers = self.watchers, []
        for connection, pid in watchers:
            connection.reply(0 if sampled else -wire.EIO, self.now() if sampled else b"")
            for line in self._processes[pid].lines if pid in self._processes else ():
                line.look = line.wants(wire.WAIT_FILES)

    def _run_out(self, process: Process, timer: list[int], now: int) -> None:
        first, interval, value, number, fd = timer
        if first > now:
            return
        times = 1 + (now - first) // interval if interval else 1
        timer[0] = first + times * interval
        if not interval:
            process.timers = {n: t for n, t in process.timers.items() if t is not timer}
        if number:
            ctypes.CDLL(None).sigqueue(process.pid, number, ctypes.c_void_p(value))
            self._deliver(process, 1 << (number - 1))
        if fd >= 0:
            process.fired[fd] = process.fired.get(fd, 0) + times
            for line in process.lines:
                line.look = line.look or line.wants(wire.WAIT_FILES)
