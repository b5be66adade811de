# SPDX-License-Identifier: Apache-2.0
"""`mmcs.Device`: /dev/mc0 for Python programs, call by call as chapter 2.3 has it.

Speaks to a running `mmcs serve` over its socket; the same calls as a C program makes under
`mmcs exec`. Errors are OSError with the driver's errno.
"""

from __future__ import annotations

import os
import socket
import struct
from dataclasses import dataclass
from pathlib import Path

from mmcs import mcdef
from mmcs.device.server import IOCTL, MAGIC, OPEN, READ, REPLY, REQUEST, WRITE, socket_path

MC_STATE = struct.Struct("<7i")


@dataclass(frozen=True)
class State:
    """struct mc_state of one axis at the latest sample."""

    adcvai: int  # processed A/D value
    encnow: int  # position, counts
    inow: int  # current command, D/A units (times MC_FSCALE when ipole filters it)
    error: int  # setpoint minus feedback
    fbnow: int  # feedback, counts or processed A/D units
    vel: int  # velocity, feedback units per servo period
    errcode: int  # MERR_ bits, axis in bits 8-15, index count in bits 16-31


class Device:
    """An open /dev/mc0. Use as a context manager, or close() it: the last close stops the motors.

    flags: os.O_RDWR, or os.O_RDONLY for a monitor, which may only read and get.
    server: name given to `mmcs serve --dev`; ignored inside `mmcs exec`.
    """

    def __init__(self, path: str = "/dev/mc0", flags: int = os.O_RDWR, server: str = "mc0"):
        where = Path(os.environ.get("MMCS_SOCKET") or socket_path(server))
        self._file = _connect(where)
        self._name = self._file.getsockname().strip(b"\0")
        self._channel = _connect(where)
        inode = os.fstat(self._file.fileno()).st_ino
        result, _ = _exchange(self._file, OPEN, b"", flags, inode, path.encode())
        if result < 0:
            self.close()
            raise OSError(-result, os.strerror(-result), path)

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()
        self._channel.close()

    # --- the calls ---

    def ioctl(self, request: int, data: bytes = b"") -> bytes:
        """Any request of Table 2.3 by number; the argument in, the argument out."""
        return self._call(IOCTL, request, data)[1]

    def read(self, axes: int = 32) -> list[State]:
        """The states of axes 0 to axes-1 (fewer if the driver controls fewer), of one sample."""
        _, data = self._call(READ, axes * MC_STATE.size)
        return [State(*values) for values in MC_STATE.iter_unpack(data)]

    def write(self, setpoints: list[int]) -> None:
        """Setpoints of axes 0 to n-1, in feedback units, units per period, or D/A units."""
        self._call(WRITE, 0, struct.pack(f"<{len(setpoints)}i", *setpoints))

    def num_cards(self) -> int:
        """Cards found by the scan at first open."""
        return self._get("MGETNUMCARDS")

    def set_num_joints(self, joints: int) -> None:
        """How many axes, from axis 0, the servo controls."""
        self._set("MSETNUMJOINTS", joints)

    def set_interval(self, microseconds: int) -> None:
        """The sample interval; over 50 ms the heartbeats run out between samples."""
        self._set("MSETINTERVAL", microseconds)

    def interval(self) -> int:
        """The actual sample interval, microseconds."""
        return self._get("MGETINTERVAL")

    def get_param(self, axis: int) -> dict[str, int]:
        """struct mc_param of an axis."""
        request, param = mcdef.MGETPARAM, mcdef.new_param(axis)
        ffi = mcdef.make_ffi()
        data = self.ioctl(request, bytes(ffi.buffer(param)))
        ffi.buffer(param)[:] = data
        return {name: getattr(param, name) for name, _ in ffi.typeof("struct mc_param").fields}

    def set_param(self, axis: int, param: dict[str, int]) -> None:
        """Sets every parameter of an axis at once, between two samples."""
        made = mcdef.new_param(axis)
        for name, value in param.items():
            setattr(made, name, axis if name == "which" else value)
        self.ioctl(mcdef.MSETPARAM, bytes(mcdef.make_ffi().buffer(made)))

    def enable(self) -> None:
        """Lets the servo drive the motors; PANIC clears with the servo holding."""
        self.ioctl(mcdef.MENABLE)

    def stop(self) -> None:
        """Zero torque, all axes off, brakes on."""
        self.ioctl(mcdef.MSTOP)

    def clear_error(self) -> None:
        """Clears what the last read() showed."""
        self.ioctl(mcdef.MCLEARERROR)

    def set_encoder(self, axis: int, count: int) -> None:
        """Sets the 16-bit counter of an axis."""
        self._set("MSETENC", (count & 0xFFFF) << 8 | axis)

    def set_leds(self, axis: int, leds: int) -> None:
        """The axis's software LED (bit 0)."""
        self._set("MSETLED", leds << 8 | axis)

    def set_dac(self, axis: int, code: int) -> None:
        """Raw 12-bit D/A code of an axis that is off; 0x800 is 0 V."""
        self._set("MSETDAC", code << 8 | axis)

    def set_dac_mode(self, double_buffered: bool) -> None:
        """Double buffered: a new current appears exactly one sample later."""
        self._set("MDACMODE", int(double_buffered))

    def set_diag_mode(self, bits: int) -> None:
        """M_ANDIAG loops D/A to A/D, M_ENDIAG feeds synthetic encoder signals."""
        self._set("MDIAGMODE", bits)

    def calibrate(self, axis: int) -> None:
        """Arms the index of an axis; MERR_ZINDEX with its count comes in errcode."""
        self._set("MCALIB", axis)

    def stats(self) -> dict[str, int]:
        """struct mc_stats: interrupts in total, missed, overrun, and more."""
        ffi = mcdef.make_ffi()
        stats = ffi.new("struct mc_stats *")
        ffi.buffer(stats)[:] = self.ioctl(mcdef.MGETSTATS)
        return {name: getattr(stats, name) for name, _ in ffi.typeof("struct mc_stats").fields}

    def zero_stats(self) -> None:
        self.ioctl(mcdef.MZEROSTATS)

    # --- the wire ---

    def _get(self, name: str) -> int:
        return struct.unpack("<i", self.ioctl(getattr(mcdef, name)))[0]

    def _set(self, name: str, value: int) -> None:
        self.ioctl(getattr(mcdef, name), struct.pack("<I", value & 0xFFFFFFFF))

    def _call(self, op: int, a: int, data: bytes = b"") -> tuple[int, bytes]:
        result, out = _exchange(self._channel, op, self._name, a, 0, data)
        if result < 0:
            raise OSError(-result, os.strerror(-result))
        return result, out


def _connect(path: Path) -> socket.socket:
    sock = socket.socket(socket.AF_UNIX)
    try:
        sock.bind("")  # the kernel gives it a name of its own, which names the file later
        sock.connect(str(path))
    except OSError:
        sock.close()
        raise OSError(
            6, "no simulator is serving; start `mmcs serve SCENARIO`", "/dev/mc0"
        ) from None
    return sock


def _exchange(sock, op: int, name: bytes, a: int, b: int, data: bytes) -> tuple[int, bytes]:
    try:
        sock.sendall(REQUEST.pack(MAGIC, op, name, a, b, len(data), os.getpid()) + data)
        result, length = REPLY.unpack(_receive(sock, REPLY.size))
        return result, _receive(sock, length)
    except (BrokenPipeError, ConnectionError):
        raise OSError(5, "the simulator is gone") from None


def _receive(sock, length: int) -> bytes:
    data = b""
    while len(data) < length:
        part = sock.recv(length - len(data))
        if not part:
            raise ConnectionError
        data += part
    return data
