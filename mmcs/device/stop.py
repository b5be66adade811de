# SPDX-License-Identifier: Apache-2.0
"""The stop path: a socket of its own, whose lines act as they are read (docs/use/protocol.md).

Whoever can connect may stop the machine. A line is at most 64 bytes.
"""

import contextlib

from mmcs.device.connection import Connection

LINE = 64


class Stop(Connection):
    def __init__(self, *args):
        super().__init__(*args)
        self.data = b""
        self.receive()

    def receive(self) -> None:
        *lines, self.data = (self.data + self.take()).split(b"\n")
        for line in lines:
            with contextlib.suppress(OSError):
                self.sock.send(self._answer(line.strip()).encode())
        if len(self.data) > LINE:
            self.end()

    def _answer(self, line: bytes) -> str:
        machine, sim = self.machine, self.machine.sim
        if line == b"stop":
            return f"{'stopped' if machine.stop() >= 0 else 'failed'} {sim.time:.6f}\n"
        if line in (b"press", b"release"):
            machine.set_input("estop", 0, int(line == b"press"))
            return f"{'pressed' if line == b'press' else 'released'} {sim.time:.6f}\n"
        if line == b"state":
            state = machine.request(None, {"op": "hello"})
            names = ("enabled", "stopped", "panic", "button")
            return f"state {sim.time:.6f} {' '.join(f'{n} {int(state[n])}' for n in names)}\n"
        return "what? stop, press, release or state\n"
