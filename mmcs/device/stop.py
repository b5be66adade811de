# SPDX-License-Identifier: Apache-2.0
"""The stop path: a socket of its own, served before anything else (docs/use/protocol.md).

Whoever can connect may stop the machine. A line is at most 64 bytes; of each connection one read is
served at a time, so that nobody holds up the others.
"""

import contextlib
import select
import socket

from mmcs.device.machine import ServedMachine

LINE = 64
CONNECTIONS = 64
IN = select.EPOLLIN


class StopPath:
    def __init__(self, listener: socket.socket, machine: ServedMachine):
        self._listener, self._machine = listener, machine
        self._poll = select.epoll()
        self._poll.register(listener, IN)
        self._open: dict[int, tuple[socket.socket, bytearray]] = {}

    def fileno(self) -> int:
        """Readable when there is something to serve."""
        return self._poll.fileno()

    def close(self) -> None:
        for sock, _ in list(self._open.values()):
            self._hang_up(sock)
        self._poll.close()

    def serve(self) -> bool:
        """Everything that can be read now; True: there was something."""
        ready = self._poll.poll(0)
        for fd, _ in ready:
            if fd == self._listener.fileno():
                while self._accept():
                    pass
            elif fd in self._open:
                self._read(*self._open[fd])
        return bool(ready)

    def _accept(self) -> bool:
        try:
            sock, _ = self._listener.accept()
        except OSError:
            return False
        if len(self._open) >= CONNECTIONS:  # the oldest may be idle; what it has sent counts
            oldest = next(iter(self._open.values()))
            self._read(*oldest)
            if oldest[0].fileno() in self._open:
                self._hang_up(oldest[0])
        sock.setblocking(False)
        self._poll.register(sock, IN)
        self._open[sock.fileno()] = (sock, bytearray())
        self._read(sock, self._open[sock.fileno()][1])
        return True

    def _hang_up(self, sock: socket.socket) -> None:
        del self._open[sock.fileno()]
        self._poll.unregister(sock)
        sock.close()

    def _read(self, sock: socket.socket, data: bytearray) -> None:
        try:
            part = sock.recv(LINE)
        except BlockingIOError:
            return
        except OSError:
            part = b""
        data += part
        *lines, rest = bytes(data).split(b"\n")
        data[:] = rest
        answers = "".join(self._answer(line.strip().decode(errors="replace")) for line in lines)
        with contextlib.suppress(OSError):
            sock.send(answers.encode())
        if not part or len(rest) > LINE:
            self._hang_up(sock)

    def _answer(self, line: str) -> str:
        machine, sim = self._machine, self._machine.sim
        if line == "stop":
            result = machine.stop()
            return f"stopped {sim.time:.6f}\n" if result >= 0 else f"failed {sim.time:.6f}\n"
        if line in ("press", "release"):
            machine.set_input("estop", 0, int(line == "press"))
            return f"{line}{'d' if line == 'release' else 'ed'} {sim.time:.6f}\n"
        if line == "state":
            state = machine.request(None, {"op": "hello"})
            flags = " ".join(
                f"{k} {int(state[k])}" for k in ("enabled", "stopped", "panic", "button")
            )
            return f"state {sim.time:.6f} {flags}\n"
        return "what? stop, press, release or state\n"
