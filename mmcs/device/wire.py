# SPDX-License-Identifier: Apache-2.0
"""The wire between programs and the server, as sim/device/wire.h has it."""

from __future__ import annotations

import contextlib
import mmap
import os
import socket
import struct
from collections.abc import Iterable
from typing import NamedTuple

from mmcs.mcdef import MLEASE, MSTATUS, MWAIT, MWHY, MWHY_SIZE  # noqa: F401

MAGIC = 0x31434D4D
REQUEST = struct.Struct("<II16sQQIi")
REPLY = struct.Struct("<iI")
OPEN, IOCTL, READ, WRITE, LOAD, STORE, HOLD, CHANGE, LEASE, WHY, SAMPLE = range(1, 12)
LINE, WAIT, WAKE, SPAWN, TIMER_OP, FIRED_OP, NOW, POKE, CANCEL = range(12, 21)  # lock-step
GENTLE = 1 << 32  # with OPEN: SIGUSR1 only to processes that catch it
LEASE_DROP, LEASE_TAKE = range(2)
BUS_OK, BUS_TIMEOUT, BUS_ERROR = range(3)
STATUS = struct.Struct("<QI5i")  # struct mmcs_status
LINE_PROGRAM, LINE_THREAD, LINE_CHILD = range(3)
WAIT_SAMPLE, WAIT_KEY, WAIT_FILES, WAIT_CHILD, WAIT_DEAF, WAIT_THREAD, WAIT_AGAIN = (
    1 << n for n in range(7)
)
CAUSE_DUE, CAUSE_WOKEN, CAUSE_SIGNAL, CAUSE_OUTSIDE, CAUSE_LATE = range(5)
NEVER = (1 << 64) - 1
WAIT_HEAD = struct.Struct("<QQQQII")
NOW_DATA = struct.Struct("<QII")
TIMER = struct.Struct("<QQQii")
FIRED = struct.Struct("<ii")
LATER = struct.Struct("<II16s128s")  # struct wire_later
MAX_DATA = 65536
MAX_PATH = 256

EIO, ENXIO, EBADF, EBUSY, EINVAL, ENOTTY = 5, 6, 9, 16, 22, 25


class Later:
    """struct wire_later of a program; without memory each of its write()s has an answer."""

    memory: mmap.mmap | None = None

    def share(self, pid: int, fd: int) -> None:
        """A descriptor of the program, if it is what its library has made for this."""
        path = f"/proc/{pid}/fd/{fd}"
        with contextlib.suppress(OSError, ValueError):
            if os.readlink(path).startswith("/memfd:mmcs "):
                with open(path, "r+b") as file:
                    self.memory = mmap.mmap(file.fileno(), LATER.size)

    def take(self) -> tuple[bytes, bytes] | None:
        """The file's name, data."""
        if self.memory is None:
            return None
        due, length, name, data = LATER.unpack_from(self.memory)
        self.memory[:4] = bytes(4)
        return (name.rstrip(b"\0"), data[:length]) if due else None


class Wait(NamedTuple):
    """struct wire_wait."""

    until: int
    key: int
    mask: int
    pending: int
    what: int
    files: tuple[int, ...]

    @classmethod
    def of(cls, data: bytes) -> Wait:
        *head, count = WAIT_HEAD.unpack_from(data)
        return cls(*head, struct.unpack_from(f"<{count}i", data, WAIT_HEAD.size))


def command(pid: int) -> str:
    """What the process calls itself, for others to read."""
    try:
        with open(f"/proc/{pid}/comm") as file:
            return file.read().strip()
    except OSError:
        return ""


def signal_masks(pid: int, *names: str) -> int:
    """The sum of such lines of the process's status; 0 without it."""
    try:
        with open(f"/proc/{pid}/status") as status:
            rows = [line.split() for line in status]
    except OSError:
        return 0
    found = 0
    for row in rows:
        if row and row[0].rstrip(":") in names:
            found |= int(row[1], 16)
    return found


def pending_signals(pid: int) -> int:
    return signal_masks(pid, "SigPnd", "ShdPnd")


def well_formed(op: int, a: int, b: int, size: int) -> bool:
    """Whether the data of a request is as long as its kind says."""
    if op == OPEN:
        return 0 < size <= MAX_PATH and b > 0
    if op == IOCTL:
        return size in (0, a >> 16 & 0x1FFF)
    if op == WRITE:
        return True
    if op == STORE:
        return size == b and b in (1, 2)
    if op == LOAD:
        return size == 0 and b in (1, 2)
    if op == CHANGE:
        return size > 0 and size % 8 == 0
    if op == WAIT:
        return size >= WAIT_HEAD.size and (size - WAIT_HEAD.size) % 4 == 0
    if op == LINE:
        return size in (0, 4)
    if op == TIMER_OP:
        return size in (0, TIMER.size)
    return OPEN < op <= CANCEL and size == 0


def _peer(link: str) -> str:
    """The link of the other end of a Unix socket, as the kernel's sock_diag(7) knows it; or ""."""
    ask = struct.pack("<IHHIIBBHIIIii", 40, 20, 1, 0, 0, socket.AF_UNIX, 0, 0, 0xFFFFFFFF,
                      int(link[8:-1]), 4, -1, -1)  # fmt: skip
    with contextlib.suppress(OSError), socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 4) as diag:
        diag.settimeout(1)
        diag.send(ask)
        reply = diag.recv(4096)
        size, kind = struct.unpack_from("<IH", reply)
        if kind == 20 and size >= 40:  # behind its head an attribute, the peer's inode
            return f"socket:[{struct.unpack_from('<I', reply, 36)[0]}]"
    return ""


def is_outside(pid: int, fd: int, attached: Iterable[int]) -> bool:
    """No attached process has the other end: of a pipe that nobody else has open, too."""
    try:
        link = os.readlink(f"/proc/{pid}/fd/{fd}")
    except OSError:
        return True
    if link.startswith("anon_inode:"):
        return False
    if not link.startswith(("pipe:", "socket:")):
        return True
    ends, both = 0, (link, _peer(link) if link.startswith("socket:") else "")
    for other in attached:
        with contextlib.suppress(OSError):
            for entry in os.scandir(f"/proc/{other}/fd"):
                with contextlib.suppress(OSError):
                    ends += os.readlink(entry.path) in both
    return ends < 2
