# SPDX-License-Identifier: Apache-2.0
"""The simulator as a server: /dev/mcN and /dev/vme16 for other processes (§2.3, §2.4), messages for
a tool beside them, and the stop path (docs/use/device.md, docs/use/protocol.md).

One thread does everything, a step at a time: one request of each connection that has one, a stretch
of simulated time, and what is to be sent. Lines of the stop path act as they are read: first in
every step, and again between requests and while one waits.
"""

import contextlib
import fcntl
import os
import resource
import select
import signal
import socket
import time
import traceback
from collections.abc import Iterator
from pathlib import Path

from mmcs.device import wire
from mmcs.device.connection import GONE, IN, OUT, Connection
from mmcs.device.machine import ServedMachine
from mmcs.device.messages import Messenger
from mmcs.device.programs import Program
from mmcs.device.sockets import Name, peer
from mmcs.device.stop import Stop
from mmcs.device.turns import Core, Turns

MOST_CONNECTIONS = 1000
STOPS = 64  # connections of the stop path beyond them
SPARE_DESCRIPTORS = 120  # for those, and everything else that the process opens
TURNS = 64  # of lock-step between looks at everything else
NO_SAMPLE_S = 2.5  # of the machine, until the wait for a sample fails
# Simulated time between looks at the sockets: short while somebody talks, doubling to the longest.
CHUNK_MIN_S, CHUNK_MAX_S = 50e-6, 2e-3
IDLE_S = 0.1  # longest sleep: signals are seen this often
BEHIND_S = 0.02  # jitter of the computer; what is lost beyond it is not made up


class Server:
    """Serves one machine. step() does a little work; run() goes on until told to stop."""

    def __init__(self, sim, path: Path, speed: float | None, about: dict | None = None,
                 console=lambda text: None, lockstep: bool = False):  # fmt: skip
        """speed: simulated seconds per second; None runs as fast as it goes. about: what messages
        tell of the machine. console: gets the lines that the driver says."""
        self.name = Name(path)
        self.path, self.sim, self.about = path, sim, about or {}
        self.machine, self.say = ServedMachine(sim, console), console
        self._hz = sim.build()["clk_hz"]
        self.machine.now.speed = speed or 0
        self.chunk = CHUNK_MIN_S
        self.files: dict[int, Program] = {}
        self.connections: dict[int, Connection] = {}
        self.stopping = False
        self.advances: tuple[Messenger, object] | None = None  # who lets time pass, and its id
        self._events = 0  # of the tap: signals among them
        # who waits for a sample: how many there were before, and the clock until which it waits
        self._watchers: list[tuple[Program, int, int]] = []
        self.listened = time.monotonic()
        self.restart()
        self.poll = select.epoll()
        fd = self.poll.fileno()
        self.lockstep = Turns(self.machine, fd, lockstep, self.signal, console)
        self._core = Core(self.lockstep) if lockstep else None
        limit = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        self.most = max(1, min(MOST_CONNECTIONS, limit - SPARE_DESCRIPTORS))
        self._doors = {}
        for suffix, kind in ((".sock", Program), (".msg", Messenger), (".stop", Stop)):
            door = self.name.listen(suffix)
            self._doors[door.fileno()] = (door, kind)
            self.poll.register(door, IN)
        sim.set_look(self._look)

    def close(self) -> None:
        self.sim.set_look(lambda: 0)
        for connection in list(self.connections.values()):
            self._hang_up(connection)
        if self._core is not None:
            self._core.leave()
        self.lockstep.close()
        self.name.release()
        self.poll.close()

    def run(self) -> None:
        while not self.stopping:
            self.step()

    # --- a step ---

    def step(self) -> None:
        """Answers what has come in, and lets time pass if it is due."""
        if self._core is not None:
            self._core.share(self.listened)
        self._take_turns()
        self._listen(self._wait())
        self._hang_up_ended()  # first: whoever closes and then asks has closed
        for connection in list(self.connections.values()):
            if connection.has_request() and not connection.busy:
                self.chunk = CHUNK_MIN_S
                self._serve(connection)
                self.signal()
                self._listen(0)  # for the stop path
                self._hang_up_ended()
        self._pass_time()
        self._answer_watchers()
        self._send()

    def _take_turns(self) -> None:
        """In lock-step, until something else than a line has to be served."""
        if self.lockstep.on and not self.machine.now.paused and self.advances is None:
            asked = any(c.has_request() for c in self.connections.values())  # is served before more
            self.lockstep.run(TURNS, 0 if asked else round(IDLE_S * 1000))

    def _serve(self, connection: Connection, nested: bool = False) -> None:
        with self._unharmed(connection):
            connection.serve(nested)

    @contextlib.contextmanager
    def _unharmed(self, connection: Connection) -> Iterator[None]:
        """No error in serving one client ends the server: the client is told and hung up on, and
        the console has a line. Signals' exceptions go on."""
        try:
            yield
        except Exception as error:
            frame = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(frame.filename).name}:{frame.lineno}"
            what = f"{type(error).__name__} at {where}: {str(error)[:200]}"
            self.say(f"server: a request failed, its connection is closed: {what}")
            connection.busy = False
            connection.fail(f"the server failed at this request ({what}); connection closed")
            connection.end()

    def _look(self) -> int:
        """While a request waits: the stop path, requests of others that do not wait, signals. 1: it
        shall not go on waiting. Nobody is hung up, for who waits may be the one."""
        self._listen(0)
        for connection in list(self.connections.values()):
            if connection.has_request() and not connection.busy:
                self._serve(connection, nested=True)
        self.signal()
        self._send()
        return int(self.stopping)

    # --- time ---

    def restart(self) -> None:
        """Time is counted from here on."""
        self._started = (time.monotonic(), self.sim.time)

    def _wait(self) -> float:
        """Seconds until there is something to do."""
        due = (c.has_request() and not (c.busy or c.paused_at) for c in self.connections.values())
        if self.advances is not None or any(due):
            return 0.0
        if self.lockstep.on:
            return IDLE_S if self.lockstep.rest() or self.machine.now.paused else 0.0
        return self._left()

    def _left(self) -> float:
        """Seconds until the next stretch of time is due. Without an open file time stands still,
        but where it is that of the wall."""
        now = self.machine.now
        if now.paused or not (now.opens or now.speed):
            self.restart()
            return IDLE_S
        if not now.speed:
            return 0.0
        wall, simulated = self._started
        left = wall + (self.sim.time - simulated) / now.speed - time.monotonic()
        if left < -BEHIND_S:
            self.restart()
        return min(max(0.0, left), IDLE_S)

    def _pass_time(self) -> None:
        if self.advances is not None:
            self._go_on()
        elif not self.lockstep.on and self._left() == 0:
            self._run(self.sim.time + self.chunk)

    def _run(self, until: float) -> None:
        """Not past the next sample, if somebody waits for it."""
        clock, before = round(until * self._hz), self.sim.samples
        self.sim.run_to(max(clock, self.sim.clock + 1), bool(self._watchers))
        self.chunk = CHUNK_MIN_S if self.signal() else min(2 * self.chunk, CHUNK_MAX_S)
        self.lockstep.passed(self.sim.samples != before)

    def watch(self, connection: Program) -> None:
        """It is answered behind the next sample, or with EIO if the servo stands still."""
        late = self.sim.clock + round(NO_SAMPLE_S * self._hz)
        self._watchers.append((connection, self.sim.samples, late))

    def _answer_watchers(self) -> None:
        watchers, self._watchers = self._watchers, []
        for connection, before, late in watchers:
            if self.sim.samples != before:
                connection.reply(0, (self.sim.samples & 0xFFFFFFFF).to_bytes(4, "little"))
            elif self.sim.clock > late:
                connection.fail("no servo sample comes: interrupts are off")
            else:
                self._watchers.append((connection, before, late))

    def _go_on(self) -> None:
        now, (asker, id_) = self.machine.now, self.advances
        self._run(min(now.target / self._hz, self.sim.time + self.chunk))
        if self.sim.clock >= now.target or asker.ended:
            now.target, self.advances = -1, None
            asker.answer(id_, {"ok": True, "t": self.sim.time})

    def _send(self) -> None:
        now = time.monotonic()
        self.machine.check(self.listened)
        self.machine.tell_console()
        for connection in self.connections.values():
            if isinstance(connection, Messenger) and not connection.ended:
                with self._unharmed(connection):
                    connection.stream(now)

    def signal(self) -> list[int]:
        """Delivers SIGUSR1 where the driver sent it; the processes that get one."""
        events, sent = self.sim.tap_head()[1], []
        if events == self._events:
            return sent  # each is an event as well
        self._events = events
        for file in self.files.values():
            client = file.client
            if client.driver >= 0 and self.sim.signals(client.driver) and client.writes:
                sent += file.signal()
        for pid in sent:
            self.lockstep.signalled(pid, 1 << (signal.SIGUSR1 - 1))
        return sent

    # --- connections ---

    def _listen(self, wait: float) -> None:
        """Accepts, reads and sends what the sockets are ready for; serves nothing but stops."""
        ready = self.poll.poll(wait)
        self.listened = time.monotonic()
        for fd, mask in sorted(ready, key=lambda r: r[0] in self._doors):  # a new fd is in none
            if fd in self._doors:
                while self._accept(*self._doors[fd]):
                    pass
            elif self.lockstep.on and self.lockstep.hear(fd):
                pass
            elif connection := self.connections.get(fd):
                if mask & IN:
                    connection.receive()
                elif mask & GONE:
                    connection.ended = True
                if mask & OUT:
                    connection.flush()

    def _accept(self, door, kind) -> bool:
        try:
            sock, _ = door.accept()
        except OSError:
            return False
        stops = [c for c in self.connections.values() if isinstance(c, Stop)]
        others = len(self.connections) - len(stops) + self.lockstep.now.lines
        if (others >= self.most and kind is not Stop) or peer(sock)[1] != os.geteuid():
            sock.close()
            return True
        if kind is Stop and len(stops) >= STOPS:  # the oldest may be idle; what it has sent counts
            stops[0].receive()
            self._hang_up(stops[0])
        # what it asks is heard together with the ends that came before it
        self.connections[sock.fileno()] = kind(sock, self)
        return True

    def becomes_line(self, connection: Connection, request: bytes) -> None:
        """Its thread gets a page for requests and answers, and what tells of them; or it ends."""
        with open(os.memfd_create("mmcs", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "wb", 0) as page:
            wake = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
            page.write(b"\1".ljust(wire.PAGE_SIZE, b"\0"))  # it has asked for its line
            fcntl.fcntl(page, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK)  # which a program cannot take
            ends = [page.fileno(), wake, self.lockstep.now.bell]
            with contextlib.suppress(ConnectionError):  # the thread is gone: its line ends at once
                socket.send_fds(connection.sock, [b"."], ends)
            del self.connections[fd := connection.sock.detach()]
            self.lockstep.line(fd, page.fileno(), wake, request)

    def _hang_up_ended(self) -> None:
        for connection in [c for c in self.connections.values() if c.ended and not c.busy]:
            self._hang_up(connection)

    def _hang_up(self, connection: Connection) -> None:
        del self.connections[connection.sock.fileno()]
        connection.close()
        with self._unharmed(connection):
            connection.leave()
        self.signal()
