# SPDX-License-Identifier: Apache-2.0
"""The columns of the log, in the order of mmcs_sim_log()."""

import numpy as np

FIELDS = ("setpoint", "encoder", "velocity", "error", "current", "errcode", "angle_rad")


def column(log: np.ndarray, axis: int, name: str) -> np.ndarray:
    return log[:, 1 + len(FIELDS) * axis + FIELDS.index(name)]


def header(axes: int) -> list[str]:
    return ["t_s"] + [f"{name}_{axis}" for axis in range(axes) for name in FIELDS]
