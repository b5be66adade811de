# SPDX-License-Identifier: Apache-2.0
"""What sim/service decides without a machine: the text of a log, control design."""

import json
import os
from pathlib import Path

import numpy as np

from mmcs.cached import once
from mmcs.mcdef import ABI, make_ffi
from mmcs.place import BUILD, ROOT, compiled, digest, is_whole, workshop

SOURCES = ("record.cpp", "design.cpp")


@once
def load() -> tuple:
    """The library, and its declarations: a simulator's, or one of its own where none is built."""
    files = [ROOT / "sim" / "service" / name for name in SOURCES]
    command = [*(os.environ.get("CXX") or "g++").split(), "-std=c++17", "-O2", "-ffp-contract=off"]
    command += [f"-I{ABI[0].parent}", *files]
    inputs = [*files, *ABI, files[0].with_name("json.h")]
    library = _simulator()
    if library is None:
        library = compiled(BUILD / "service" / "libmmcs_service.so", command, inputs)
    return make_ffi(), make_ffi().dlopen(str(library))


def _simulator() -> Path | None:
    """A simulator's library of these very sources."""
    workshop()  # nobody else may write there: what is found there is loaded
    made_of = digest()
    for library in sorted((BUILD / "sim").glob("speed_*/libmmcs_sim.so")):
        if is_whole(library, made_of):
            return library
    return None


def _rows(ffi, rows: np.ndarray):
    return ffi.from_buffer("double[]", np.ascontiguousarray(rows, np.float64))


def log_lines(columns: int, rows: np.ndarray | None = None) -> bytes:
    """Of log.csv: these rows, or the first line."""
    ffi, lib = load()
    if rows is None:
        return ffi.string(lib.mmcs_log_lines(columns, ffi.NULL, 0))
    return ffi.string(lib.mmcs_log_lines(columns, _rows(ffi, rows), len(rows)))


def bus_lines(cycles: bytes) -> bytes:
    """Of bus.csv: its first line, and these mmcs_bus_cycles."""
    ffi, lib = load()
    given = ffi.from_buffer("mmcs_bus_cycle[]", cycles)
    lines = ffi.string(lib.mmcs_bus_lines(given, len(given))) if cycles else b""
    return ffi.string(lib.mmcs_bus_lines(ffi.NULL, 0)) + lines


class DesignError(ValueError):
    """The combination cannot be made; the text says why and what to take instead."""


def _answered(told) -> dict:
    answer = json.loads(load()[0].string(told))
    if "error" in answer:
        raise DesignError(answer["error"])
    return answer


def design_discrete(gains: list[float], method: str, t: float, prewarp: float) -> dict:
    """As mmcs_design_discrete(), and so on; DesignError is their errors."""
    return _answered(load()[1].mmcs_design_discrete(gains, method.encode(), t, prewarp))


def design_integers(num: list[float], den: list[float], scale: int | None) -> dict:
    ffi, lib = load()
    given = ffi.NULL if scale is None else ffi.new("int64_t *", scale)
    return _answered(lib.mmcs_design_integers(num, len(num), den, len(den), given))


def design_answer(gains: list[float], t: float) -> dict:
    return _answered(load()[1].mmcs_design_answer(gains, t))
