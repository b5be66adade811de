# SPDX-License-Identifier: Apache-2.0
"""The line of a Python program that joins a machine in lock-step by itself (see lockstep.py).

Under `mmcs exec --lockstep` no program needs one: its library has a line for every thread.
"""

import asyncio
import errno
import os
import socket
from pathlib import Path

from mmcs.device import wire
from mmcs.device.sockets import connect

ALL_SIGNALS = (1 << 64) - 1  # none ends a wait: Python's handlers run by themselves


class OwnLine:
    """From now on machine time stands still but in wait()."""

    def __init__(self, where: Path):
        self._sock: socket.socket = connect(where)
        ask(self._sock, wire.LINE, wire.LINE_PROGRAM)
        result, _ = take(self._sock)
        if result < 0:
            self.close()
            text = "the machine is not in lock-step; start `mmcs serve --lockstep SCENARIO`"
            raise OSError(errno.EINVAL, text, "/dev/mc0")

    def close(self) -> None:
        self._sock.close()

    def _post(self) -> None:
        head = wire.WAIT_HEAD.pack(wire.NEVER, 0, ALL_SIGNALS, 0, wire.WAIT_SAMPLE, 0)
        ask(self._sock, wire.WAIT, 0, head)

    def wait(self) -> int:
        """The number of the next sample, when it has come."""
        self._post()
        return sample_of(take(self._sock))

    async def next_sample(self) -> int:
        self._post()
        return sample_of(await take_async(self._sock))


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


def sample_of(reply: tuple[int, bytes]) -> int:
    result, data = reply
    if result in (-errno.EIO, wire.CAUSE_LATE):
        raise OSError(errno.EIO, "no servo sample comes: interrupts are off")
    if result < 0:
        raise OSError(-result, os.strerror(-result))
    return wire.NOW_DATA.unpack(data)[1]


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
