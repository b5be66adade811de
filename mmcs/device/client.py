# SPDX-License-Identifier: Apache-2.0
"""`mmcs.Device`: /dev/mc0 for Python programs, call by call as chapter 2.3 has it.

Speaks to a running `mmcs serve` over its socket; the same calls as a C program makes under
`mmcs exec`. Errors are OSError with the driver's errno and what it said on its console.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import signal
import socket
import struct
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from mmcs import mcdef
from mmcs.device import reasons, wire
from mmcs.device.sockets import connect, socket_path

GONE = errno.EIO, "the simulator is gone"
_changing = threading.RLock()
MC_STATE = struct.Struct("<7i")


class State(NamedTuple):
    """struct mc_state of one axis at the latest sample."""

    adcvai: int  # processed A/D value
    encnow: int  # position, counts
    inow: int  # current command, D/A units (times MC_FSCALE when ipole filters it)
    error: int  # setpoint minus feedback
    fbnow: int  # feedback, counts or processed A/D units
    vel: int  # velocity, feedback units per servo period
    errcode: int  # MERR_ bits, axis in bits 8-15, index count in bits 16-31


# <sys/mmcs.h>, from MCAUSE_HEARTBEAT on
CAUSES = ("axis {} has no heartbeat", "card {} does not answer", "no card answers: cable or power",
          "button, or a cause that has passed", "an error of axis {}: see its errcode",
          "bus error, or the adaptor does not answer", "SYSRESET*, or a program wrote PCCSR",
          "no interrupts, or passes outlast SCLOCK")  # fmt: skip


@dataclass(frozen=True)
class Status:
    """struct mmcs_status: how the machine stands."""

    time_ns: int  # of the machine, since power-on
    sample: int  # number of the last servo sample since power-on, as wait() gives it
    enabled: bool  # the servo drives the joints
    stopped: bool  # a stop is latched, nothing moves until enable()
    stopped_by: int  # process that asked for it; 0: the host's stop path, or no stop
    cause: int  # MCAUSE_... of <sys/mmcs.h>: what shut the machine down, until enable(); 0: nothing
    number: int  # axis or card of the cause, or -1
    known: str = ""  # what the simulator knows of the cause beside the registers

    @property
    def why(self) -> str:
        """The cause as a sentence, or what the simulator alone knows of a PANIC; or empty."""
        known = f" ({self.known})" if self.known else ""
        if self.cause:
            return CAUSES[self.cause - 1].format(self.number) + known
        return known and f"PANIC stands, which no register tells{known}"


class Device:
    """An open /dev/mc0. Use as a context manager, or close() it: the last close stops the motors.

    flags: os.O_RDWR, or os.O_RDONLY for a monitor, which may only read, get, and stop.
    server: name given to `mmcs serve --dev`; ignored inside `mmcs exec`.
    Inside `mmcs exec --lockstep` machine time passes only in wait() and other calls that sleep.

    Threads and signal handlers may call it at any time, also while another call is under way: each
    call has a channel of its own to the server. One that an exception cuts short (Ctrl-C) may or
    may not have been carried out. SIGUSR1 is ignored where it has no handler.
    """

    def __init__(self, path: str = "/dev/mc0", flags: int = os.O_RDWR, server: str = "mc0"):
        self._where = Path(os.environ.get("MMCS_SOCKET") or socket_path(server))
        self._idle: list[socket.socket] = []  # channels without a call; append and pop are atomic
        self._owner = os.getpid()
        self._attached = "MMCS_LOCKSTEP" in os.environ  # by the library that every thread has
        if signal.getsignal(signal.SIGUSR1) is signal.SIG_DFL:  # which would end the process
            ctypes.CDLL(None).signal(signal.SIGUSR1, ctypes.c_void_p(1))  # SIG_IGN, in any thread
        self._file = connect(self._where)
        try:
            self._inode = os.fstat(self._file.fileno()).st_ino
            asked = _checked("flags", flags) & 0xFFFFFFFF
            result, _ = _exchange(self._file, wire.OPEN, self._inode, asked, os.fsencode(path))
            if result < 0:
                raise OSError(-result, _sentence(-result, reasons.OF_OPEN.get(-result, "")), path)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()
        while self._idle:
            self._idle.pop().close()

    # --- the calls ---

    def ioctl(self, request: int, data: bytes = b"") -> bytes:
        """Any request of Table 2.3 by number; the argument in, the argument out."""
        number = _checked("request", request, -(1 << 31), (1 << 32) - 1) & 0xFFFFFFFF
        return self._ask(wire.IOCTL, number, data)[0]

    def read(self, axes: int = 32) -> list[State]:
        """The states of axes 0 to axes-1 (fewer if the driver controls fewer), of one sample."""
        data, _ = self._ask(wire.READ, _checked("axes", axes, 0, 32) * MC_STATE.size)
        return [*map(State._make, MC_STATE.iter_unpack(data))]

    def write(self, setpoints: list[int]) -> None:
        """Setpoints of axes 0 to n-1, in feedback units, units per period, or D/A units."""
        values = [*setpoints]
        try:
            data = struct.pack(f"<{len(values)}i", *values)
        except struct.error:
            for value in values:
                _checked("setpoint", value)
            raise
        self._ask(wire.WRITE, 0, data)

    def write_axis(self, axis: int, setpoint: int) -> None:
        """The setpoint of one axis; the others keep theirs, whoever writes them."""
        data = struct.pack("<ii", _axis(axis), _checked("setpoint", setpoint))
        self.ioctl(mcdef.MSETPOINT, data)

    def wait(self) -> int:
        """Waits for the next servo sample; its number since power-on."""
        return int.from_bytes(self._ask(wire.IOCTL, wire.MWAIT)[0], "little")

    async def next_sample(self) -> int:
        """wait() for an event loop, whose other tasks go on meanwhile."""
        import asyncio

        return await asyncio.get_running_loop().run_in_executor(None, self.wait)

    def status(self) -> Status:
        """How the machine stands: its time, whether it is enabled or stopped, by whom and why."""
        data, known = self._ask(wire.IOCTL, wire.MSTATUS, why=True)
        time_ns, sample, enabled, stopped, *rest = wire.STATUS.unpack(data)
        return Status(time_ns, sample, bool(enabled), bool(stopped), *rest, known)

    def num_cards(self) -> int:
        """Cards found by the scan at first open."""
        return self._get("MGETNUMCARDS")

    def set_num_joints(self, joints: int) -> None:
        """How many axes, from axis 0, the servo controls."""
        self._set("MSETNUMJOINTS", _checked("joints", joints))

    def set_interval(self, microseconds: int) -> None:
        """The sample interval; over 50 ms the heartbeats run out between samples."""
        self._set("MSETINTERVAL", _checked("interval", microseconds, 0, (1 << 32) - 1))

    def interval(self) -> int:
        """The actual sample interval, microseconds."""
        return self._get("MGETINTERVAL")

    def get_param(self, axis: int) -> dict[str, int]:
        """struct mc_param of an axis."""
        return _named("mc_param", self.ioctl(mcdef.MGETPARAM, _bytes(_axis(axis), {})))

    def set_param(self, axis: int, param: dict[str, int]) -> None:
        """Sets every parameter of an axis at once, between two samples."""
        self.ioctl(mcdef.MSETPARAM, _bytes(_axis(axis), param))

    def change_param(self, axis: int, **values: int) -> dict[str, int]:
        """Sets some parameters of an axis and leaves the others, whatever other threads change;
        returns all. Against other programs the lease helps."""
        for name in values:
            if name not in mcdef.fields("mc_param") or name == "which":
                raise OSError(errno.EINVAL, f"there is no parameter {name!r} to change")
        with _changing:
            param = self.get_param(axis) | values
            self.set_param(axis, param)
        return param

    def enable(self) -> None:
        """Lets the servo drive the motors; PANIC clears with the servo holding."""
        self.ioctl(mcdef.MENABLE)

    def stop(self) -> None:
        """Zero torque, all axes off, brakes on, until enable(); a monitor may, too."""
        self.ioctl(mcdef.MSTOP)

    def clear_error(self) -> None:
        """Clears what the last read() showed."""
        self.ioctl(mcdef.MCLEARERROR)

    def set_encoder(self, axis: int, count: int) -> None:
        """Sets the 16-bit counter of an axis."""
        self._set("MSETENC", (_checked("count", count, -32768, 65535) & 0xFFFF) << 8 | _axis(axis))

    def set_leds(self, axis: int, leds: int) -> None:
        """The axis's software LED (bit 0)."""
        self._set("MSETLED", _checked("leds", leds, 0, 0xFFFFFF) << 8 | _axis(axis))

    def set_dac(self, axis: int, code: int) -> None:
        """Raw 12-bit D/A code of an axis that is off; 0x800 is 0 V."""
        self._set("MSETDAC", _checked("code", code, 0, 4095) << 8 | _axis(axis))

    def set_dac_mode(self, double_buffered: bool) -> None:
        """Double buffered: a new current appears exactly one sample later."""
        self._set("MDACMODE", int(bool(double_buffered)))

    def set_diag_mode(self, bits: int) -> None:
        """M_ANDIAG loops D/A to A/D, M_ENDIAG feeds synthetic encoder signals."""
        self._set("MDIAGMODE", _checked("bits", bits))

    def set_verbosity(self, bits: int) -> None:
        """What the driver says on the server's console: M_VERBOSE, M_ERRORPRINT."""
        self._set("MSETVERBOSITY", _checked("bits", bits))

    def verbosity(self) -> int:
        """The bits of set_verbosity()."""
        return self._get("MGETVERBOSITY")

    def calibrate(self, axis: int) -> None:
        """Arms the index of an axis; MERR_ZINDEX with its count comes in errcode."""
        self._set("MCALIB", _axis(axis))

    def end_calibration(self, axis: int) -> None:
        """The axis waits for its index no longer; others go on."""
        self.ioctl(mcdef.MCALIBEND, struct.pack("<i", _axis(axis)))

    def stats(self) -> dict[str, int]:
        """struct mc_stats: interrupts in total, missed, overrun, and more."""
        return _named("mc_stats", self.ioctl(mcdef.MGETSTATS))

    def zero_stats(self) -> None:
        self.ioctl(mcdef.MZEROSTATS)

    def take_lease(self) -> None:
        """Until drop_lease() or close() nobody else may change anything (they get EBUSY), but for a
        stop. EBUSY if somebody else has it."""
        self._set("MLEASE", 1)

    def drop_lease(self) -> None:
        self._set("MLEASE", 0)

    # --- the wire ---

    def _get(self, name: str) -> int:
        return struct.unpack("<i", self.ioctl(getattr(mcdef, name)))[0]

    def _set(self, name: str, value: int) -> None:
        self.ioctl(getattr(mcdef, name), struct.pack("<I", value & 0xFFFFFFFF))

    def _ask(self, op: int, a: int, data: bytes = b"", why: bool = False) -> tuple[bytes, str]:
        """Data and, if asked for, what is to be said of it."""
        if len(data) > wire.MAX_DATA:
            raise OSError(errno.EINVAL, f"{len(data)} bytes are too many for one call")
        if self._file.fileno() < 0:
            raise OSError(errno.EBADF, _sentence(errno.EBADF, "the device is closed"))
        channel = None if self._attached else self._take_channel()
        try:
            result, out = self._call(channel, op, a, data)
            said = ""
            if why or result < 0:
                text = self._call(channel, wire.IOCTL, wire.MWHY)[1]
                said = text.partition(b"\0")[0].decode()
        except BaseException:
            if channel:
                channel.close()  # an answer may still come on it, which nobody waits for
            raise
        if channel:
            self._idle.append(channel)
        if result < 0:
            raise OSError(-result, _sentence(-result, said))
        return out, said

    def _call(self, channel, op: int, a: int, data: bytes = b"") -> tuple[int, bytes]:
        """Result and data. In lock-step as a C program makes it: the library knows of every call,
        and its signals wait until it is over."""
        if channel:
            return _exchange(channel, op, self._inode, a, data)
        fd, size = self._file.fileno(), a >> 16 & 0x1FFF
        try:
            if op == wire.READ:
                return 0, os.read(fd, a)
            if op == wire.WRITE:
                return os.write(fd, data), b""
            out = fcntl.ioctl(fd, a, data.ljust(size, b"\0") if size else 0)
            return 0, out if size and a & mcdef.MC_ARG_OUT else b""
        except OSError as error:
            return -error.errno, b""

    def _take_channel(self) -> socket.socket:
        if self._owner != os.getpid():  # the parent's channels stay the parent's
            self._idle, self._owner = [], os.getpid()
        try:
            return self._idle.pop()
        except IndexError:
            try:
                return connect(self._where)
            except OSError:
                raise OSError(*GONE) from None


def _sentence(error: int, why: str) -> str:
    return ": ".join(filter(None, (os.strerror(error), why)))


def _bytes(axis: int, param: dict[str, int]) -> bytes:
    which, *names = mcdef.fields("mc_param")
    for name in param:
        if name not in (which, *names):
            raise OSError(errno.EINVAL, f"there is no parameter {name!r}")
    values = [_checked(name, param.get(name, 0)) for name in names]
    return struct.pack(f"<{1 + len(names)}i", axis, *values)


def _named(structure: str, data: bytes) -> dict[str, int]:
    """The fields of one of the driver's structures, all of which are int."""
    names = mcdef.fields(structure)
    return dict(zip(names, struct.unpack(f"<{len(names)}i", data), strict=True))


def _checked(what: str, value: object, low: int = -(1 << 31), high: int = (1 << 31) - 1) -> int:
    """A whole number that fits, or OSError as the driver would give."""
    try:
        number = value.__index__()
    except (AttributeError, TypeError):
        raise OSError(errno.EINVAL, f"{what} {value!r}: must be a whole number") from None
    if not low <= number <= high:
        raise OSError(errno.EINVAL, f"{what} {number}: must be from {low} to {high}")
    return number


def _axis(axis: object) -> int:
    return _checked("axis", axis, 0, 255)


def _exchange(sock, op: int, inode: int, a: int, data: bytes) -> tuple[int, bytes]:
    """A request and its reply: a result and data."""
    head = wire.MAGIC, op, inode, a, wire.MAX_DATA, len(data), os.getpid()
    try:
        sock.sendall(wire.REQUEST.pack(*head) + data)
        packet = sock.recv(wire.REPLY.size + wire.MAX_DATA)
        return wire.REPLY.unpack_from(packet)[0], packet[wire.REPLY.size :]
    except (OSError, struct.error):
        raise OSError(*GONE) from None
