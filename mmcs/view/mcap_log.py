# SPDX-License-Identifier: Apache-2.0
"""A finished run as MCAP, the way mctool writes its recordings."""

from mmcs import logcols
from mmcs.view.mcap_file import from_rows
from mmcs.view.runs import Run


def from_run(run: Run) -> bytes:
    """Topics /axis/N with the fields of the log."""
    names = logcols.header(run.axes)
    return from_rows(names, ([float(value) for value in row] for row in run.log), kind="number")
