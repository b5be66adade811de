# SPDX-License-Identifier: Apache-2.0
"""Compiles the firmware for the host, with sanitizers for programs, plain for Python."""

from pathlib import Path

from tools.compiled import compiled

ROOT = Path(__file__).resolve().parents[2]

WARN = ["-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wstrict-prototypes",
        "-Werror"]  # fmt: skip
INCLUDE = [f"-I{ROOT / 'firmware' / d}" for d in ("include", "mc", "tests")]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1"]


def compile_c(name: str, sources: list[Path], extra: list[str]) -> Path:
    return compiled(name, ["cc", *WARN, *INCLUDE, *extra], sources)
