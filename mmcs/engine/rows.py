# SPDX-License-Identifier: Apache-2.0
"""Rows of numbers without end: a log as long as the run, in memory that does not grow with it."""

import tempfile
from collections.abc import Iterator

import numpy as np

IN_MEMORY = 32 << 20  # bytes; what is longer goes to a file without a name
BLOCK = 4096  # rows that are looked at together


class Rows:
    """Appended to while a run goes on, then read as a two-dimensional array is: whole columns,
    ranges of rows, or block after block."""

    def __init__(self, columns: int, in_memory: int = IN_MEMORY):
        self.columns, self._in_memory, self._count = columns, in_memory, 0
        self._file = tempfile.SpooledTemporaryFile(max_size=in_memory)  # noqa: SIM115

    def append(self, rows: np.ndarray) -> None:
        rows = np.ascontiguousarray(rows, dtype=np.float64).reshape(-1, self.columns)
        self._file.seek(0, 2)
        self._file.write(rows.tobytes())
        self._count += len(rows)

    def array(self):
        """What to go on with: an array while it is short, else itself."""
        short = self._count * self.columns * 8 <= self._in_memory
        return self._read(0, self._count).copy() if short else self

    def __len__(self) -> int:
        return self._count

    @property
    def shape(self) -> tuple[int, int]:
        return self._count, self.columns

    @property
    def size(self) -> int:
        return self._count * self.columns

    def _read(self, start: int, stop: int) -> np.ndarray:
        self._file.seek(start * self.columns * 8)
        raw = self._file.read(max(0, stop - start) * self.columns * 8)
        return np.frombuffer(raw, np.float64).reshape(-1, self.columns)

    def blocks(self, start: int = 0, stop: int | None = None) -> Iterator[np.ndarray]:
        stop = self._count if stop is None else min(stop, self._count)
        for at in range(start, stop, BLOCK):
            yield self._read(at, min(at + BLOCK, stop))

    def __getitem__(self, key) -> np.ndarray:
        """[:, column], [a:b, column], [a:b], [a:b:step], [row] and [row, column]."""
        rows, column = key if isinstance(key, tuple) else (key, slice(None))
        if not isinstance(rows, slice):
            row = range(self._count)[rows]
            return self._read(row, row + 1)[0][column]
        start, stop, step = rows.indices(self._count)
        if step < 1:
            raise IndexError("rows are read forwards")
        parts = []
        for at in range(start, stop, BLOCK * step):
            wanted = range(at, min(at + BLOCK * step, stop), step)
            if step == 1:
                parts.append(self._read(wanted.start, wanted.stop)[:, column].copy())
            else:
                parts += [self._read(n, n + 1)[:, column] for n in wanted]
        width = len(range(self.columns)[column]) if isinstance(column, slice) else None
        empty = np.empty((0,) if width is None else (0, width))
        return np.concatenate(parts) if parts else empty


def blocks(log) -> Iterator[np.ndarray]:
    """Of an array or of Rows."""
    if isinstance(log, Rows):
        return log.blocks()
    return (log[at : at + BLOCK] for at in range(0, len(log), BLOCK))
