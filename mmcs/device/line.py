# SPDX-License-Identifier: Apache-2.0
"""Requests of a Python program to the server, and their replies, over a socket (see wire.py)."""

import asyncio
import errno
import os
import socket

from mmcs.device import wire


def ask(sock: socket.socket, op: int, a: int, data: bytes = b"", name: bytes = b"",
        b: int = 0) -> None:  # fmt: skip
    try:
        sock.sendall(wire.REQUEST.pack(wire.MAGIC, op, name, a, b, len(data), os.getpid()) + data)
    except OSError:
        raise _gone() from None


def take(sock: socket.socket) -> tuple[int, bytes]:
    """A reply: its result and data."""
    result, length = wire.REPLY.unpack(_receive(sock, wire.REPLY.size))
    if length > wire.MAX_DATA:
        raise _gone()
    return result, _receive(sock, length)


async def take_async(sock: socket.socket) -> tuple[int, bytes]:
    """The same in an event loop, which goes on until the reply comes; it comes in one piece."""
    loop = asyncio.get_running_loop()
    ready = loop.create_future()
    loop.add_reader(sock, lambda: ready.done() or ready.set_result(None))
    try:
        await ready
    finally:
        loop.remove_reader(sock)
    return take(sock)


def _receive(sock: socket.socket, length: int) -> bytes:
    data = b""
    while len(data) < length:
        try:
            part = sock.recv(length - len(data))
        except ConnectionError:
            part = b""
        if not part:
            raise _gone()
        data += part
    return data


def _gone() -> OSError:
    return OSError(errno.EIO, "the simulator is gone")
