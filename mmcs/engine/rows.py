# SPDX-License-Identifier: Apache-2.0
"""Rows of numbers without end: a log as long as the run, in memory that does not grow with it."""

import mmap
import tempfile
import weakref
from collections.abc import Iterator

import numpy as np

IN_MEMORY = 32 << 20  # bytes; what is longer goes to a file without a name
BLOCK = 4096  # rows that are looked at together


class Rows:
    """Appended to while a run goes on, then read as an array."""

    def __init__(self, columns: int, in_memory: int = IN_MEMORY):
        self.columns, self._in_memory, self._count = columns, in_memory, 0
        self._file = tempfile.SpooledTemporaryFile(max_size=in_memory)  # noqa: SIM115
        weakref.finalize(self, self._file.close)  # its mapping stays

    def append(self, rows: np.ndarray) -> None:
        rows = np.ascontiguousarray(rows, dtype=np.float64).reshape(-1, self.columns)
        self._file.write(rows.tobytes())
        self._count += len(rows)

    def __len__(self) -> int:
        return self._count

    def array(self) -> np.ndarray:
        """(rows, columns) of now. A longer one is the file, mapped, and cannot be written."""
        if self._count * self.columns * 8 <= self._in_memory:
            self._file.seek(0)
            raw = bytearray(self._file.read())
        else:
            number = self._file.fileno()
            self._file.flush()
            raw = mmap.mmap(number, 0, access=mmap.ACCESS_READ)
        return np.frombuffer(raw, np.float64).reshape(-1, self.columns)


def blocks(log: np.ndarray) -> Iterator[np.ndarray]:
    """Of BLOCK rows each, the last shorter."""
    return (log[at : at + BLOCK] for at in range(0, len(log), BLOCK))
