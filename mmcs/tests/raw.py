# SPDX-License-Identifier: Apache-2.0
"""Programs at the wire and clients of the messages in the test's own thread: every byte and every
step is the test's."""

import contextlib
import json
import os
import socket
import struct

from mmcs import mcdef
from mmcs.device.wire import IOCTL, MAGIC, OPEN, READ, REPLY, REQUEST, WRITE

STEPS = 100_000  # of a server: what has not come after so many never comes


class Asker:
    """A client of the messages."""

    def __init__(self, server):
        self.server, self.data = server, bytearray()
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.sock.connect(str(server.path.with_suffix(".msg")))
        self.sock.setblocking(False)

    def post(self, message: dict | str) -> None:
        text = (message if isinstance(message, str) else json.dumps(message)).encode()
        self.sock.send(struct.pack("<I", len(text)) + text)

    def heard(self, wanted) -> bytes:
        """The next message that is wanted, or nothing if the server closes the connection."""
        for _ in range(STEPS):
            while len(self.data) >= 4:
                end = 4 + struct.unpack_from("<I", self.data)[0]
                if len(self.data) < end:
                    break
                message = bytes(self.data[4:end])
                del self.data[:end]
                if wanted(message):
                    return message
            self.server.step()
            with contextlib.suppress(BlockingIOError):
                if not (part := self.sock.recv(1 << 20)):
                    return b""
                self.data += part
        raise AssertionError(f"{STEPS} steps of the server, and not what was waited for")

    def reply(self) -> dict:
        """The next; one for each request, in order."""
        told = self.heard(lambda told: told[:1] == b"{" and b'"type":"reply"' in told)
        assert told, "the server has closed the connection"
        return json.loads(told)


class Raw:
    """A program at the wire, in the test's own thread: nothing waits for an answer."""

    def __init__(self, bench, flags=os.O_RDWR, device=b"/dev/mc0"):
        self.bench = bench
        self.file, self.channel = self._connect(), self._connect()
        self.inode = os.fstat(self.file.fileno()).st_ino
        self._send(self.file, OPEN, self.inode, flags, 0, device)
        assert self._answer(self.file) == (0, b"")

    def _connect(self):
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        sock.connect(str(self.bench.server.path))
        sock.setblocking(False)
        return sock

    def _send(self, sock, op, inode, a, b, data):
        data = REQUEST.pack(MAGIC, op, inode, a, b, len(data), os.getpid()) + data
        while True:
            try:
                return sock.send(data)
            except BlockingIOError:
                self.bench.server.step()

    def _answer(self, sock):
        while True:
            self.bench.server.step()
            with contextlib.suppress(BlockingIOError):
                data = sock.recv(1 << 17)
                return REPLY.unpack_from(data)[0], data[REPLY.size :]

    def call(self, op, a=0, data=b"", b=0):
        self._send(self.channel, op, self.inode, a, b, data)
        return self._answer(self.channel)

    def flood(self):
        """As much as the socket takes of reads, writes and parameters; answers are thrown away."""
        states = REQUEST.pack(MAGIC, READ, self.inode, 56, 0, 0, os.getpid())
        some = REQUEST.pack(MAGIC, WRITE, self.inode, 0, 0, 8, os.getpid()) + bytes(8)
        asked = REQUEST.pack(MAGIC, IOCTL, self.inode, mcdef.MGETINTERVAL, 0, 0, os.getpid())
        with contextlib.suppress(BlockingIOError):
            while True:
                for packet in (states, some, asked):
                    self.channel.send(packet)
        with contextlib.suppress(BlockingIOError):
            while self.channel.recv(1 << 20):
                pass

    def close(self):
        self.file.close()
        self.channel.close()


def stop_line(bench):
    sock = socket.socket(socket.AF_UNIX)
    sock.connect(str(bench.server.path.with_suffix(".stop")))
    return sock


def holding(bench, program):
    """Both axes hold their position."""
    for axis in (0, 1):
        param = mcdef.new_param(axis)
        mcdef.fill_param(param, {"a0": 5, "b0": 1, "clkdivisor": 1, "ilim": 1024, "adc_a": 1,
                                 "plo": -(1 << 31), "phi": (1 << 31) - 1,
                                 "mode": "position", "flags": []})  # fmt: skip
        assert program.call(IOCTL, mcdef.MSETPARAM, bytes(mcdef.make_ffi().buffer(param)))[0] == 0
    assert program.call(IOCTL, mcdef.MENABLE)[0] == 0
