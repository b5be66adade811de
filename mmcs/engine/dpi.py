# SPDX-License-Identifier: Apache-2.0
"""The machine of a simulator that has started this process (docs/use/dpi.md).

Functions of mmcs_sim.h are called as if the library were here; sim/dpi/calls.h is the other end.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path

from mmcs.engine.sim import Sim, load_library, make_ffi
from mmcs.errors import RunError

NULL = -1  # the length of an array that is none
# What has another shape there: the rows beside their number, a segment's table beside it.
LOG = "int64_t (*)(mmcs_sim *, int64_t *, int32_t *, const double **)"
SEGMENT = "int (*)(mmcs_sim *, mmcs_segment *, const double *)"


class DpiSim(Sim):
    """Everything that a run needs; the rest of a Sim ends the line."""

    def hash(self) -> str:
        """None: the hash is of the registers, too."""
        return ""

    def destroy(self) -> None:
        """The simulator does so when this process ends."""


class Line:
    """What cffi's library object is, with every call carried out in the simulator.

    fd: the end that it has left us; library: sim/Makefile's KIND=dpi, for its declarations.
    """

    def __init__(self, fd: int, library: Path):
        try:
            self._file = os.fdopen(fd, "r+b", buffering=0)
        except OSError as error:
            raise RunError(f"--dpi {fd}: {error.strerror}; a simulator gives this option") from None
        self._declared = load_library(library)
        self._ffi = make_ffi()
        # the simulator has one of each, and keeps it
        self._there = [self._ffi.typeof(f"{name} *") for name in ("mmcs_sim", "mmcs_script")]
        self._kept: dict[str, object] = {}  # what the last call of a name pointed to

    def __getattr__(self, name: str):
        declared = getattr(self._declared, name)
        if not name.startswith(("mmcs_sim_", "mmcs_script_")):
            return declared
        kind = self._ffi.typeof(declared)
        return lambda *arguments: self._call(name, kind, arguments)

    def mmcs_sim_log(self, sim, rows, cols):
        data = self._ffi.new("const double **")
        self._call("mmcs_sim_log", self._ffi.typeof(LOG), (sim, rows, cols, data))
        return data[0]

    def mmcs_sim_add_segment(self, sim, segment) -> int:
        table = segment.table[0 : segment.table_len] if segment.table else self._ffi.NULL
        return self._call("mmcs_sim_add_segment", self._ffi.typeof(SEGMENT), (sim, segment, table))

    def _call(self, name: str, kind, arguments):
        arrays, request = [], [_array(name.encode())]
        for declared, value in zip(kind.args, arguments, strict=True):
            if declared.kind == "primitive":
                request.append(struct.pack("<d" if declared.cname == "double" else "<q", value))
            elif declared not in self._there:
                arrays.append((declared, value))
                if declared.item.kind != "pointer":
                    request.append(self._sent(value))
        reply = _Reply(self._exchange(b"".join(request)))
        result = self._result(name, kind.result, reply)
        for declared, value in arrays:
            now = reply.array()
            if declared.item.kind == "pointer":
                item = declared.item.item.cname
                self._kept[name] = self._ffi.from_buffer(f"{item}[]", now)
                value[0] = self._kept[name]
            elif now is not None:
                self._ffi.buffer(value)[:] = now
        return result

    def _sent(self, value) -> bytes:
        if isinstance(value, bytes):
            return _array(value + b"\0")
        null = value == self._ffi.NULL
        return struct.pack("<q", NULL) if null else _array(bytes(self._ffi.buffer(value)))

    def _result(self, name: str, kind, reply: _Reply):
        if kind.cname == "void":
            return None
        if kind.cname == "char *":
            text = reply.array()
            self._kept[name] = self._ffi.from_buffer("char[]", text)
            return self._kept[name] if text else self._ffi.NULL
        return reply.number("<d" if kind.cname == "double" else "<q")

    def _exchange(self, request: bytes) -> bytes:
        try:
            self._file.write(struct.pack("<I", len(request)) + request)
            (length,) = struct.unpack("<I", self._read(4))
            return self._read(length)
        except OSError:
            raise RunError(
                "the simulator has ended before the run; its last words say why"
            ) from None

    def _read(self, n: int) -> bytes:
        parts = []
        while n:
            part = self._file.read(n)
            if not part:
                raise OSError
            parts.append(part)
            n -= len(part)
        return b"".join(parts)


def _array(data: bytes) -> bytes:
    return struct.pack("<q", len(data)) + data


class _Reply:
    def __init__(self, data: bytes):
        self._data, self._at = data, 0

    def number(self, how: str = "<q"):
        (value,) = struct.unpack_from(how, self._data, self._at)
        self._at += 8
        return value

    def array(self) -> bytes | None:
        length = self.number()
        if length == NULL:
            return None
        self._at += length
        return self._data[self._at - length : self._at]
