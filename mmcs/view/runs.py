# SPDX-License-Identifier: Apache-2.0
"""Reads the folder of a finished run."""

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mmcs import logcols
from mmcs.engine.rows import BLOCK, Rows
from mmcs.errors import InputError
from mmcs.files import log_lines, open_file, read_json
from mmcs.place import run_folders

LARGEST = 1e12  # of a log's numbers; NaN is none


@dataclass
class Run:
    folder: Path
    report: dict
    log: np.ndarray  # columns as in log.csv

    @property
    def axes(self) -> int:
        return (self.log.shape[1] - 1) // len(logcols.FIELDS)

    def column(self, axis: int, name: str) -> np.ndarray:
        return logcols.column(self.log, axis, name)


def read_run(name: str) -> Run:
    """A folder with report.json and log.csv, or the name of a scenario that was run."""
    folder = Path(name)
    if not folder.is_dir() and "/" not in name.rstrip("/"):
        folder = next((f for f in run_folders(name) if f.is_dir()), folder)
    if not folder.is_dir():
        raise InputError.one(name, "", None, "no such run; make it with `mmcs run`")
    try:
        return _read(folder)
    except OSError as error:
        why = "its results are not there; run the scenario again"
        why = why if isinstance(error, FileNotFoundError) else str(error)
        raise InputError.one(folder, "", None, f"is not a run: {why}") from None
    except ValueError as error:
        raise InputError.one(folder, "", None, f"is not a run: {error}") from None


def _log_file(folder: Path):
    try:
        return open_file(folder / "log.csv")
    except ValueError as error:
        raise ValueError(f"its log.csv {error}") from None


def _read(folder: Path) -> Run:
    """Raises ValueError with a sentence."""
    report = read_json(folder / "report.json")
    if not isinstance(report, dict) or not {"scenario", "axes", "hash"} <= report.keys():
        raise ValueError("its report.json is not one of MMCS")
    axes = report["axes"]
    good = isinstance(axes, list) and all(isinstance(axis, dict) for axis in axes)
    if not good or not isinstance(report["scenario"], str):
        raise ValueError("its report.json is damaged")
    rows, width = None, 0
    with _log_file(folder) as file:
        crc = zlib.crc32(b"".join(next(log_lines(file, 1), [])))
        for lines in log_lines(file, BLOCK):
            for line in lines:
                crc = zlib.crc32(line, crc)
            try:
                block = np.loadtxt(lines, delimiter=",", ndmin=2)
            except ValueError:  # numpy's words are for who calls it
                raise ValueError("its log.csv is damaged") from None
            rows, width = rows or Rows(block.shape[1]), block.shape[1]
            if width != rows.columns or not (np.abs(block) < LARGEST).all():
                raise ValueError("its log.csv is damaged")
            rows.append(block)
    if crc != report.get("log_crc32", crc):
        raise ValueError("its log.csv is damaged, or of another run than its report.json")
    if rows is None:
        raise ValueError("it has an empty log")
    if width != 1 + len(logcols.FIELDS) * len(report["axes"]):
        raise ValueError("its log.csv has other axes than its report.json")
    return Run(folder, report, rows.array())
