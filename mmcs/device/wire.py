# SPDX-License-Identifier: Apache-2.0
"""The wire between programs and the server, as sim/device/wire.h has it."""

import contextlib
import os
import socket
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path

from mmcs import mcdef
from mmcs.mcdef import MLEASE, MSTATUS, MWAIT, MWHY, MWHY_SIZE  # noqa: F401

_declared = mcdef.make_ffi()
_CODES = {"int": "i", "int32_t": "i", "uint32_t": "I", "uint64_t": "Q"}
_CODES |= {"unsigned int": "I", "unsigned long long": "Q"}


def _layout(name: str) -> struct.Struct:
    """A structure of the header."""
    fields = (field.type for _, field in _declared.typeof(f"struct {name}").fields)
    codes = (f"{kind.length}s" if kind.kind == "array" else _CODES[kind.cname] for kind in fields)
    return struct.Struct("<" + "".join(codes))


def _numbers(name: str) -> list[int]:
    """Those of an enum."""
    return sorted(_declared.typeof(f"enum {name}").relements.values())


REQUEST, REPLY = map(_layout, ("wire_request", "wire_reply"))
STATUS = _layout("mmcs_status")
PAGE_SIZE = _declared.sizeof("struct wire_page")
OPEN, IOCTL, READ, WRITE, LOAD, STORE, HOLD, LINE, *_ = _numbers("wire_op")
BUS_OK, BUS_TIMEOUT, BUS_ERROR = _numbers("wire_bus")
MAX_DATA, MAGIC = _numbers("wire_number")
MAX_PATH = 256

EIO, ENXIO, EBADF, EBUSY, EINVAL, ENOTTY = 5, 6, 9, 16, 22, 25


def command(pid: int) -> str:
    """What the process calls itself, for others to read."""
    try:
        with open(f"/proc/{pid}/comm") as file:
            return file.read().strip()
    except OSError:
        return ""


def _alive(pid: int) -> Path:
    """What /proc has of a thread of the process: main() may have ended before the others."""
    for task in Path(f"/proc/{pid}/task").glob("*"):
        with contextlib.suppress(OSError):
            if any((task / "fd").iterdir()):
                return task
    return Path(f"/proc/{pid}")


def links(pid: int) -> Iterator[str]:
    """Of the descriptors that the process has, what each is of."""
    with contextlib.suppress(OSError):
        for entry in os.scandir(_alive(pid) / "fd"):
            with contextlib.suppress(OSError):
                yield os.readlink(entry.path)


def is_request(packet: bytes) -> bool:
    """A head, and as many bytes as it says."""
    head = REQUEST.unpack_from(packet.ljust(REQUEST.size))
    return head[0] == MAGIC and len(packet) == REQUEST.size + head[5]


def well_formed(op: int, a: int, b: int, size: int) -> bool:
    """Whether the data of a request is as long as its kind says."""
    if op in (LOAD, STORE):
        return b in (1, 2) and size == (b if op == STORE else 0)
    if op == IOCTL:
        return size in (0, a >> 16 & 0x1FFF)
    if op == OPEN:
        return 0 < size <= MAX_PATH
    return op == WRITE or (op in (READ, HOLD) and size == 0)


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
        link = os.readlink(_alive(pid) / "fd" / str(fd))
    except OSError:
        return True
    if link.startswith("anon_inode:"):
        return False
    if not link.startswith(("pipe:", "socket:")):
        return True
    ends, both = 0, (link, _peer(link) if link.startswith("socket:") else "")
    for other in attached:
        ends += sum(link in both for link in links(other))
    return ends < 2
