# SPDX-License-Identifier: Apache-2.0
"""The server's end of the wire (sim/device/wire.h): programs that open /dev/mcN and /dev/vme16."""

import contextlib
import math
import os
import signal
import socket
import struct

from mmcs import mcdef
from mmcs.device import reasons, wire
from mmcs.device.connection import Connection

MOST_SAID = 1000  # bytes of why a call was refused
LEASE = {struct.pack("<i", take): name for take, name in enumerate(("drop", "take"))}
PAUSED_S = 1.0  # that a request waits for the end of a pause, and it is said


class Program(Connection):
    """A file, which is an open device, or a channel, which carries the calls of a thread."""

    def __init__(self, sock, server):
        super().__init__(sock, server)
        self._request = b""  # the packet that is to be served
        self._files: dict[int, Program] = server.files
        self.client = None  # of a file: its mmcs_client
        self._inode = 0  # of its other end
        self.pids: set[int] = set()  # processes that had the file open when they said so last
        self._said = ""  # by the driver, when the last call on this channel failed
        self._turns = server.lockstep

    def receive(self) -> None:
        if self._request or self.ended:
            return
        self._request = self.take()
        if self._request and not wire.is_request(self._request):
            self.end()

    def has_request(self) -> bool:
        return bool(self._request) and not self.ended

    def serve(self, nested: bool) -> None:
        _, op, inode, a, b, length, pid = wire.REQUEST.unpack_from(self._request)
        if op == wire.IOCTL:
            a &= 0xFFFFFFFF  # held in an int, a request arrives sign-extended
        waits = op == wire.IOCTL and a in self.machine.waits
        now = self.machine.now  # paused: what needs the machine's time waits for the end
        if waits and now.paused and now.target < 0:
            self._say_paused(a, pid)
            return
        self.paused_at = None
        if waits and nested:
            return
        request, self._request = self._request, b""
        if op == wire.LINE and self._turns.on and not length:
            self.ended = True
            self.server.becomes_line(self, request)
            return
        if op == wire.IOCTL and a == wire.MWAIT:
            self.server.watch(self)
            return
        self.busy = True
        result, out = self._call(op, inode, a, b, request[wire.REQUEST.size :], pid)
        self.busy = False
        self.server.signal()  # its own is there before the call returns
        self.reply(result, out)
        if op == wire.OPEN and result >= 0:
            # From now on only its end is waited for: bytes that a program writes past the library
            # fail there, and poll() finds it readable, as read() never blocks.
            self._send(b".")
            with contextlib.suppress(OSError):
                self.sock.shutdown(socket.SHUT_RD)
            self.watch(0)

    def _say_paused(self, request: int, pid: int) -> None:
        """Once, when it has waited for a while."""
        now = self.server.listened
        self.paused_at = self.paused_at or now
        if now - self.paused_at >= PAUSED_S:
            self.paused_at = math.inf
            name = next(n for n, known in mcdef.requests().items() if known.code == request)
            what = f"{name} waits: the machine is paused, and a tool must let it go on"
            self.server.say(f"mmcs: {wire.command(pid) or 'a program'} ({pid}): {what}")

    def fail(self, why: str) -> None:
        self._said = why
        self.reply(-wire.EIO)

    def reply(self, result: int, out: bytes = b"") -> None:
        self._send(wire.REPLY.pack(result, len(out)) + out)

    def _send(self, packet: bytes) -> None:
        """A program that does not fetch its answers is disconnected."""
        try:
            self.sock.send(packet)
        except OSError:
            self.end()

    def leave(self) -> None:
        if self.client is not None:
            del self._files[self._inode]
            self._turns.closes(self.client)
            self.machine.leave(self.client)

    def signal(self) -> list[int]:
        """SIGUSR1 to every process that has the file open at this moment; those processes. The
        kernel knows what dup2, exec and close have left of their descriptors."""
        told = []
        for pid in list(self.pids):
            if f"socket:[{self._inode}]" not in wire.links(pid):
                self.pids.discard(pid)
            else:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGUSR1)
                    told.append(pid)
        return told

    # --- calls ---

    def _call(self, op: int, inode: int, a: int, b: int, payload: bytes, pid: int):
        why = op == wire.IOCTL and a == wire.MWHY
        if not why:
            self._said = ""
        if not wire.well_formed(op, a, b, len(payload)):
            return -wire.EINVAL, b""
        if op == wire.OPEN:
            return self._open(payload, a, inode, pid), b""
        if why:
            room = min(b or wire.MWHY_SIZE, MOST_SAID)
            said = (self._said or self.machine.knows()).encode()
            return 0, said[: room - 1].ljust(room, b"\0")
        file = self._files.get(inode)
        if file is None:
            self._said = "the simulator that had this file open is gone"
            return -wire.EIO, b""
        file.pids.add(pid)
        if op == wire.HOLD:
            return (1 + file.client.writes if file.client.driver < 0 else 0), b""
        before = self.machine.sim.tap_head()[1]
        result, out = self._of_file(file.client, op, a, b, payload, pid)
        if result < 0:
            said = self.machine.said_since(before)
            self._said = said or self._because(file.client, -result, op, a, payload)
        return result, out

    def _because(self, client, error: int, op: int, a: int, payload: bytes) -> str:
        """Of a call that the driver said nothing about."""
        if error == wire.EBUSY and (held := self.machine.held(client)):
            return held
        if client.driver < 0:
            return ""
        if op == wire.IOCTL:
            return reasons.of_ioctl(error, a, payload)
        name, value = ("read", a) if op == wire.READ else ("write", len(payload))
        return reasons.of_call(name, error, value)

    def _of_file(self, client, op: int, a: int, b: int, payload: bytes, pid: int):
        machine = self.machine
        if op in (wire.LOAD, wire.STORE):
            if client.driver >= 0:
                return wire.BUS_TIMEOUT, b""
            return machine.bus(client, a, b, payload if op == wire.STORE else None)
        if op == wire.IOCTL and a == wire.MLEASE:
            if not (lease := LEASE.get(payload)):
                return -wire.EINVAL, b""
            return -machine.request(client, {"op": "lease", lease: True}).get("errno", 0), b""
        if client.driver < 0:
            return (-wire.ENOTTY if op == wire.IOCTL else -wire.EINVAL), b""
        if op == wire.IOCTL:
            return machine.ioctl(client, a, payload)
        if op == wire.READ:
            return self._turns.read_states(pid, client, min(a, wire.MAX_DATA))
        return self._turns.write(pid, client, payload, len(payload)), b""

    def _open(self, device: bytes, flags: int, inode: int, pid: int) -> int:
        if self.client is not None or not inode or inode in self._files:
            return -wire.EINVAL  # a file is opened once, and has an inode of its own
        machine = self.machine
        client = machine.enter("device", pid, wire.command(pid))
        result = machine.open(client, device, flags & 0x7FFFFFFF)
        if result < 0:
            machine.leave(client)
            return result
        self.client, self._inode = client, inode
        self.pids.add(pid)
        self._files[inode] = self
        return 0
