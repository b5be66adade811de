# SPDX-License-Identifier: Apache-2.0
"""Why a call was refused, as one sentence: what the driver's errno alone does not tell (§2.3)."""

import errno

from mmcs import mcdef
from mmcs.device.wire import EBADF, EBUSY, EINVAL, EIO, ENOTTY, ENXIO

IN_LOW_BITS = ("MSETENC", "MSETLED", "MSETDAC")  # the axis, of the argument's low 8 bits
STOPPED = "stopped or shut down, MENABLE first"
OF_OPEN = {
    ENXIO: "no adaptor answers there",
    EBUSY: "it is open already",
    EINVAL: "must be opened for reading, writing or both",
    errno.ENFILE: "the driver has no room for a further open",
    errno.ENOTDIR: "a device is no directory",
    errno.EEXIST: "it exists already",
}
# What the driver says nothing about, of any call; of one call; and of a bad argument.
OF_ANY = {
    EIO: "a card or the adaptor does not answer",
    EBUSY: "the machine starts or stops just now",
    EINVAL: "the argument is beyond its bounds",
    EBADF: "the device is open for reading only",
    errno.EFAULT: "the argument lies outside the program's memory",
}
OF_CALL = {
    ("MSETDAC", EIO): "the machine is not enabled",
    ("MSETPOINT", EIO): STOPPED,
    ("write", EIO): STOPPED,
    ("read", EBADF): "the device is open for writing only",
}
AXIS = "must be an axis that the servo controls"
ALLOWED = {
    **dict.fromkeys(("MGETPARAM", "MCALIB", "MCALIBEND", "MSETPOINT", "MSETENC", "MSETLED"), AXIS),
    "MSETNUMJOINTS": "must be 0 to the number of axes found",
    "MSETINTERVAL": "must be 100 us or more, exact to 0.1 %, and at most 50 ms by clkdivisor",
    "MSETPARAM": f"{AXIS}; b0 not 0; clkdivisor 1 to 50 ms; ilim, ilimax >= 0; ipole 0 to "
                 f"{mcdef.MC_FSCALE - 1}",
    "MSETDAC": f"{AXIS} and that is off, MD_OFF",
    "MDIAGMODE": "must be M_ANDIAG, M_ENDIAG, both or 0",
    "read": "must be 28 bytes, a state, or more",
    "write": "must be 4 bytes for each joint, of no more joints than the servo controls",
}  # fmt: skip
NAMES = {request.code: name for name, request in mcdef.requests().items()}
NAMES[mcdef.MLEASE] = "MLEASE"


def of_call(name: str, error: int, value: int) -> str:
    """Of any call that failed with this errno; value: its argument, or number of bytes."""
    if error == EINVAL and name in ALLOWED:
        return f"{name}: {value}: {ALLOWED[name]}"
    return f"{name}: {OF_CALL.get((name, error)) or OF_ANY.get(error, f'errno {error}')}"


def of_ioctl(error: int, request: int, argument: bytes) -> str:
    name = NAMES.get(request, "")
    if error == ENOTTY or not name:
        return f"there is no request 0x{request:08x}"
    value = int.from_bytes(argument[:4], "little", signed=name != "MSETINTERVAL")
    return of_call(name, error, value & 0xFF if name in IN_LOW_BITS else value)
