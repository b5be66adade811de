# SPDX-License-Identifier: Apache-2.0
"""Requests of a Python program to the server, and their replies, over a socket (see wire.py)."""

import contextlib
import errno
import os

from mmcs.device import wire

GONE = errno.EIO, "the simulator is gone"


def send(sock, op: int, name: bytes, a: int, b: int = 0, data: bytes = b"") -> None:
    try:
        sock.sendall(wire.REQUEST.pack(wire.MAGIC, op, name, a, b, len(data), os.getpid()) + data)
    except OSError:
        raise OSError(*GONE) from None


def take(sock) -> tuple[int, bytes]:
    """A reply: its result and data."""
    result, length = wire.REPLY.unpack(_receive(sock, wire.REPLY.size))
    if length > wire.MAX_DATA:
        raise OSError(*GONE)
    return result, _receive(sock, length)


def _receive(sock, length: int) -> bytes:
    data = b""
    while len(data) < length:
        part = b""
        with contextlib.suppress(ConnectionError):
            part = sock.recv(length - len(data))
        if not part:
            raise OSError(*GONE)
        data += part
    return data
