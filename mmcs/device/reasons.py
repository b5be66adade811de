# SPDX-License-Identifier: Apache-2.0
"""Why a call was refused, as one sentence: what the driver's errno alone does not tell (§2.3)."""

import errno
import struct

from mmcs import mcdef
from mmcs.device.wire import EBADF, EBUSY, EINVAL, EIO, ENOTTY, ENXIO

STATE_BYTES, INTERVAL_MIN_US, SERVO_US = 28, 100, 50_000
OF_AXIS = ("MSETENC", "MSETLED", "MSETDAC")  # in the low 8 bits
STOPPED = "stopped or shut down, MENABLE first"
OF_OPEN = {
    ENXIO: "no adaptor answers there",
    EBUSY: "it is open already",
    EINVAL: "must be opened for reading, writing or both",
    errno.ENFILE: "the driver has no room for a further open",
    errno.ENOTDIR: "a device is no directory",
    errno.EEXIST: "it exists already",
}
# What the driver says nothing about, of any request.
OF_ANY = {
    EIO: "a card or the adaptor does not answer",
    EBUSY: "the machine starts or stops just now",
    EINVAL: "the argument is beyond its bounds",
    errno.EFAULT: "the argument lies outside the program's memory",
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
    if error == EBADF:
        return f"{name}: the device is open for reading only"
    if error == EIO and name == "MSETDAC":
        return f"{name}: the machine is not enabled"
    if error == EIO and name == "MSETPOINT":
        return f"{name}: {STOPPED}"
    of_argument = _of_argument(name, argument, joints, axes) if error == EINVAL else ""
    return of_argument or f"{name}: {OF_ANY.get(error, f'errno {error}')}"


def _of_argument(name: str, argument: bytes, joints: int, axes: int) -> str:
    """What of it must be another; "" if nothing is known."""
    if name in ("MGETPARAM", "MSETPARAM"):
        return _of_param(name, argument, joints)
    (value,) = struct.unpack_from("<I", argument.ljust(4, b"\0"))
    if name == "MSETNUMJOINTS":
        return f"{name}: {_signed(value)} joints: must be 0 to {axes}"
    if name == "MSETINTERVAL":
        allowed = (
            f"must be {INTERVAL_MIN_US} or more, exact to 0.1 %, and at most 50 ms by clkdivisor"
        )
        return f"{name}: {value} us: {allowed}"
    if name == "MDIAGMODE":
        return f"{name}: {_signed(value)}: must be M_ANDIAG, M_ENDIAG, both or 0"
    if name not in (*OF_AXIS, "MCALIB", "MCALIBEND", "MSETPOINT"):
        return ""
    axis = value & 0xFF if name in OF_AXIS else _signed(value)
    if not 0 <= axis < joints:
        return _of_axis(name, axis, joints)
    return f"{name}: axis {axis} is not off; a raw code needs MD_OFF" if name == "MSETDAC" else ""


def _of_param(name: str, argument: bytes, joints: int) -> str:
    param = mcdef.new_param(0)
    ffi = mcdef.make_ffi()
    ffi.buffer(param)[:] = argument.ljust(ffi.sizeof("struct mc_param"), b"\0")
    if not 0 <= param.which < joints:
        return _of_axis(name, param.which, joints)
    allowed = (
        ("b0", param.b0 != 0, "must not be 0: it divides"),
        ("clkdivisor", param.clkdivisor >= 1, f"must be 1 or more, and at most {SERVO_US} us"),
        ("ilim", param.ilim >= 0, "must not be negative"),
        ("ilimax", param.ilimax >= 0, "must not be negative"),
        ("ipole", 0 <= param.ipole < mcdef.MC_FSCALE, f"must be 0 to {mcdef.MC_FSCALE - 1}"),
    )
    for field, good, what in allowed:
        if not good:
            return f"{name}: axis {param.which}: {field} {getattr(param, field)}: {what}"
    return f"{name}: axis {param.which}: clkdivisor {param.clkdivisor}: longer than {SERVO_US} us"


def _of_axis(name: str, axis: int, joints: int) -> str:
    return f"{name}: axis {axis}: must be 0 to {joints - 1}" if joints else f"{name}: no joints"


def of_read(error: int, size: int) -> str:
    if error == EBADF:
        return "read: the device is open for writing only"
    if error == EINVAL:
        return f"read: {size} bytes: a state has {STATE_BYTES}"
    return f"read: {OF_ANY.get(error, f'errno {error}')}"


def of_write(error: int, size: int, joints: int) -> str:
    if error == EBADF:
        return "write: the device is open for reading only"
    if error == EIO:
        return f"write: {STOPPED}"
    if error == EINVAL:
        return f"write: {size} bytes: must be 4 for each of at most {joints} joints"
    return f"write: {OF_ANY.get(error, f'errno {error}')}"


def _signed(value: int) -> int:
    return value - (1 << 32) if value >> 31 else value
