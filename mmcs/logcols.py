# SPDX-License-Identifier: Apache-2.0
"""The columns of the log, as the engine's header names them."""

import re

import numpy as np

from mmcs import ROOT

_HEADER = (ROOT / "sim" / "abi" / "mmcs_sim.h").read_text()
FIELDS = tuple(re.search(r'#define MMCS_SIM_LOG_FIELDS "(.*)"', _HEADER)[1].split())


def column(log: np.ndarray, axis: int, name: str) -> np.ndarray:
    return log[:, 1 + len(FIELDS) * axis + FIELDS.index(name)]


def header(axes: int) -> list[str]:
    return ["t_s"] + [f"{name}_{axis}" for axis in range(axes) for name in FIELDS]
