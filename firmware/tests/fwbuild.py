# SPDX-License-Identifier: Apache-2.0
"""Compiles the firmware for the host, with sanitizers for programs, plain for Python."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "firmware-tests"
WARN = ["-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wstrict-prototypes",
        "-Werror"]  # fmt: skip
INCLUDE = [f"-I{ROOT / 'firmware' / d}" for d in ("include", "mc", "tests")]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1"]


def compile_c(name: str, sources: list[Path], extra: list[str]) -> Path:
    """Builds `name` from sources unless it is newer than all of firmware/."""
    BUILD.mkdir(parents=True, exist_ok=True)
    out = BUILD / name
    newest = max(f.stat().st_mtime for f in (ROOT / "firmware").rglob("*.[ch]"))
    if out.exists() and out.stat().st_mtime >= newest:
        return out
    part = BUILD / f"{name}.{os.getpid()}"
    command = ["cc", *WARN, *INCLUDE, *extra, "-o", str(part), *map(str, sources)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    part.replace(out)
    return out


def random_calls() -> Path:
    """random_calls.c with driver and mock, sanitizers on."""
    driver = sorted((ROOT / "firmware" / "mc").glob("*.c"))
    here = ROOT / "firmware" / "tests"
    return compile_c("random_calls", [here / "random_calls.c", here / "mock.c", *driver], SANITIZE)
