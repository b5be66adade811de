# SPDX-License-Identifier: Apache-2.0
"""A client of the messages in Python (docs/use/protocol.md): for tools, recorders and tests."""

from __future__ import annotations

import errno
import itertools
import json
import os
import struct
from collections import deque
from pathlib import Path

from mmcs.device.sockets import connect, socket_path

LENGTH = struct.Struct("<I")
HEAD = struct.Struct("<4sIIHHdd")


class Samples:
    """One message of samples."""

    def __init__(self, message: bytes):
        _, self.rows, self.row_bytes, self.axes, self.cards, self.lost, self.first = (
            HEAD.unpack_from(message)
        )
        self.data = message[HEAD.size :]

    def row(self, n: int) -> dict:
        """number, t, lines, joints, axes (a list of ten values for each), lights."""
        layout = struct.Struct(f"<ddii{10 * self.axes}i{self.cards}i")
        number, t, lines, joints, *rest = layout.unpack_from(self.data, n * self.row_bytes)
        axes = [rest[10 * a : 10 * a + 10] for a in range(self.axes)]
        return {"number": int(number), "t": t, "lines": lines, "joints": joints, "axes": axes,
                "lights": rest[10 * self.axes :]}  # fmt: skip


class Link:
    """A connection to a server's messages; `hello` holds what it said first.

    request() waits for its answer; what comes meanwhile is kept for receive(), in order."""

    def __init__(self, server: str = "mc0", path: Path | None = None, timeout: float | None = 10.0):
        """path: of the server's device socket, if not by its name. Inside `mmcs exec`: its own."""
        where = path or Path(os.environ.get("MMCS_SOCKET") or socket_path(server))
        self._sock = connect(where.with_suffix(".msg"), timeout)
        self._data = bytearray()
        self._kept: deque[dict | Samples] = deque()
        self._ids = itertools.count(1)
        self.hello = self._next()

    def __enter__(self) -> Link:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        self._sock.close()

    def set_timeout(self, seconds: float) -> None:
        """How long an answer may take from now on."""
        self._sock.settimeout(seconds)

    def fileno(self) -> int:
        return self._sock.fileno()

    def post(self, op: str, **arguments) -> int:
        """Asks without waiting; the number that the reply will have."""
        number = next(self._ids)
        text = json.dumps({"id": number, "op": op, **arguments}).encode()
        self._sock.sendall(LENGTH.pack(len(text)) + text)
        return number

    def request(self, op: str, **arguments) -> dict:
        """The reply; OSError with the driver's errno when it is a refusal."""
        number = self.post(op, **arguments)
        while True:
            message = self._next()
            if isinstance(message, dict) and message.get("id") == number:
                break
            self._kept.append(message)
        if not message["ok"]:
            raise OSError(message["errno"], message["text"])
        return message

    def receive(self) -> dict | Samples:
        """The next message that is no answer to request()."""
        return self._kept.popleft() if self._kept else self._next()

    def kept(self) -> list[dict | Samples]:
        """What came while request() waited, without waiting for more."""
        kept, self._kept = list(self._kept), deque()
        return kept

    def _next(self) -> dict | Samples:
        (length,) = LENGTH.unpack(self._take(LENGTH.size))
        message = self._take(length)
        return json.loads(message) if message[:1] == b"{" else Samples(message)

    def _take(self, count: int) -> bytes:
        while len(self._data) < count:
            part = self._sock.recv(1 << 16)
            if not part:
                raise OSError(errno.EIO, os.strerror(errno.EIO) + ": the simulator is gone")
            self._data += part
        taken = bytes(self._data[:count])
        del self._data[:count]
        return taken
