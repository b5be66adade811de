# SPDX-License-Identifier: Apache-2.0
"""Why a call was refused, as one sentence: what the driver's errno alone does not tell (§2.3)."""

import errno
import functools
import struct

from mmcs import mcdef
from mmcs.device.wire import EBADF, EBUSY, EINVAL, EIO, ENOTTY, ENXIO

SERVO_US = 50_000
IN_LOW_BITS = ("MSETENC", "MSETLED", "MSETDAC")  # the axis, of the argument's low 8 bits
OF_PARAM = ("MGETPARAM", "MSETPARAM")
OF_AXIS = (*IN_LOW_BITS, *OF_PARAM, "MCALIB", "MCALIBEND", "MSETPOINT")
STOPPED = "stopped or shut down, MENABLE first"
OF_OPEN = {
    ENXIO: "no adaptor answers there",
    EBUSY: "it is open already",
    EINVAL: "must be opened for reading, writing or both",
    errno.ENFILE: "the driver has no room for a further open",
    errno.ENOTDIR: "a device is no directory",
    errno.EEXIST: "it exists already",
}
# What the driver says nothing about, of any request; of a call; and of an argument's bounds.
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
BOUNDS = {
    "MSETNUMJOINTS": "{0} joints: must be 0 to {axes}",
    "MSETINTERVAL": "{0} us: must be 100 or more, exact to 0.1 %, and at most 50 ms by clkdivisor",
    "MDIAGMODE": "{0}: must be M_ANDIAG, M_ENDIAG, both or 0",
    "read": "{0} bytes: a state has 28",
    "write": "{0} bytes: must be 4 for each of at most {joints} joints",
}
NAMES = {request.code: name for name, request in mcdef.requests().items()}
NAMES[mcdef.MLEASE] = "MLEASE"


def of_open(error: int) -> str:
    return OF_OPEN.get(error, "")


def of_ioctl(error: int, request: int, argument: bytes, joints: int, axes: int) -> str:
    """Of a request that failed with this errno and without a line of the driver."""
    name = NAMES.get(request, "")
    if error == ENOTTY or not name:
        return f"there is no request 0x{request:08x}"
    kind = "<I" if name == "MSETINTERVAL" else "<i"
    (value,) = struct.unpack_from(kind, argument.ljust(4, b"\0"))
    axis = value & 0xFF if name in IN_LOW_BITS else value
    if error != EINVAL or name not in OF_AXIS:
        return _of_call(name, error, value, axes=axes)
    if not joints:
        return f"{name}: no joints"
    if not 0 <= axis < joints:
        return f"{name}: axis {axis}: must be 0 to {joints - 1}"
    if name in OF_PARAM:
        return f"{name}: axis {axis}: {_of_param(argument)}"
    if name == "MSETDAC":
        return f"{name}: axis {axis} is not off; a raw code needs MD_OFF"
    return _of_call(name, error, value)


def _of_call(name: str, error: int, value: int, joints: int = 0, axes: int = 0) -> str:
    """Of any call: of this errno, with this argument or number of bytes."""
    if error == EINVAL and name in BOUNDS:
        return f"{name}: {BOUNDS[name].format(value, joints=joints, axes=axes)}"
    return f"{name}: {OF_CALL.get((name, error)) or OF_ANY.get(error, f'errno {error}')}"


of_read, of_write = functools.partial(_of_call, "read"), functools.partial(_of_call, "write")


def _of_param(argument: bytes) -> str:
    names = mcdef.fields("mc_param")
    values = struct.unpack(f"<{len(names)}i", argument.ljust(4 * len(names), b"\0"))
    param = dict(zip(names, values, strict=True))
    allowed = {
        "b0": (param["b0"] != 0, "must not be 0: it divides"),
        "clkdivisor": (param["clkdivisor"] >= 1, f"must be 1 or more, and at most {SERVO_US} us"),
        "ilim": (param["ilim"] >= 0, "must not be negative"),
        "ilimax": (param["ilimax"] >= 0, "must not be negative"),
        "ipole": (0 <= param["ipole"] < mcdef.MC_FSCALE, f"must be 0 to {mcdef.MC_FSCALE - 1}"),
    }
    for field, (good, what) in allowed.items():
        if not good:
            return f"{field} {param[field]}: {what}"
    return f"clkdivisor {param['clkdivisor']}: longer than {SERVO_US} us"
