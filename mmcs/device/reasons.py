# SPDX-License-Identifier: Apache-2.0
"""Why a call was refused, as one sentence, where the driver says nothing but its errno (§2.3): the
table of requests tells what each errno of a request means."""

import errno
import re

from mmcs import mcdef
from mmcs.device.wire import EBADF, EBUSY, EINVAL, EIO, ENOTTY, ENXIO

OF_OPEN = {
    ENXIO: "no adaptor answers there",
    EBUSY: "it is open already",
    EINVAL: "must be opened for reading, writing or both",
    errno.ENFILE: "the driver has no room for a further open",
}
OF_ANY = {
    EIO: "a card or the adaptor does not answer",
    EBUSY: "the machine starts or stops just now",
    EINVAL: "the argument, or the axis in it, is beyond its bounds",
    EBADF: "the device is open for reading only",
    errno.EFAULT: "the argument lies outside the program's memory",
}
OF_CALL = {
    ("read", EINVAL): "must be 28 bytes, a state, or more",
    ("read", EBADF): "the device is open for writing only",
    ("write", EINVAL): "must be 4 bytes for each joint, of no more joints than the servo controls",
    ("write", EIO): "stopped or shut down, MENABLE first",
}
REQUESTS = {request.code: (name, request.meaning) for name, request in mcdef.requests().items()}
REQUESTS[mcdef.MLEASE] = ("MLEASE", "")


def of_call(name: str, error: int, value: int, meaning: str = "") -> str:
    """Of any call that failed with this errno; value: its argument, or number of bytes."""
    found = re.search(rf"{errno.errorcode.get(error)}: (.*?)(?:; E[A-Z]+:|$)", meaning)
    why = found[1] if found else OF_CALL.get((name, error)) or OF_ANY.get(error, f"errno {error}")
    return f"{name}: {value}: {why}" if error == EINVAL else f"{name}: {why}"


def of_ioctl(error: int, request: int, argument: bytes) -> str:
    if error == ENOTTY or request not in REQUESTS:
        return f"there is no request 0x{request:08x}"
    name, meaning = REQUESTS[request]
    value = int.from_bytes(argument[:4], "little", signed=name != "MSETINTERVAL")
    return of_call(name, error, value, meaning)
