# SPDX-License-Identifier: Apache-2.0
"""Reads the folder of a finished run."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mmcs.engine import logcols
from mmcs.errors import InputError
from mmcs.place import run_folders


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
    if not folder.is_dir() and "/" not in name:
        folder = next((f for f in run_folders(name) if f.is_dir()), folder)
    if not folder.is_dir():
        raise InputError.one(name, "", None, "no such run; make it with `mmcs run`")
    try:
        report = json.loads((folder / "report.json").read_text())
        with warnings.catch_warnings():  # an empty log is told below
            warnings.simplefilter("ignore", UserWarning)
            log = np.loadtxt(folder / "log.csv", delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as error:
        raise InputError.one(folder, "", None, f"is not a run: {error}") from None
    if not isinstance(report, dict) or not {"scenario", "axes", "hash"} <= report.keys():
        raise InputError.one(folder, "", None, "is not a run: its report.json is none of MMCS")
    if log.size == 0:
        raise InputError.one(folder, "", None, "has an empty log")
    return Run(folder, report, log)
