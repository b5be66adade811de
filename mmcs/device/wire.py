# SPDX-License-Identifier: Apache-2.0
"""The wire between programs and the server, as sim/device/wire.h has it."""

from __future__ import annotations

import struct

MAGIC = 0x31434D4D
REQUEST = struct.Struct("<II16sQQIi")
REPLY = struct.Struct("<iI")
OPEN, IOCTL, READ, WRITE, LOAD, STORE, HOLD, CHANGE, LEASE, WHY = range(1, 11)
GENTLE = 1 << 32  # with OPEN: SIGUSR1 only to processes that catch it
LEASE_DROP, LEASE_TAKE = range(2)
BUS_OK, BUS_TIMEOUT, BUS_ERROR = range(3)
MAX_DATA = 65536
MAX_PATH = 256

ENXIO, EBADF, EBUSY, EINVAL, ENOTTY = 6, 9, 16, 22, 25


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
    return op in (READ, HOLD, LEASE, WHY) and size == 0
