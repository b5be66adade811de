# SPDX-License-Identifier: Apache-2.0
"""The one digest of the simulator's sources: a library, a snapshot and a set-up file are of these
very sources, or of others, whatever the times of files say.

`digest.py BUILD [RTL]` does what sim/Makefile needs before it goes by times: where a source has
changed and its time does not show that, it removes what is compiled; then it writes BUILD/sources.
"""

import hashlib
import os
import shutil
import sys
import sysconfig
from pathlib import Path

TREES = ("sim/abi", "sim/setup", "sim/model", "sim/engine", "sim/plant", "sim/service", "sim/dpi",
         "sim/card", "sim/device", "firmware/mc", "firmware/include")  # fmt: skip
FILES = ("sim/Makefile", "tools/sources.py", "mmcs.core")
KINDS = (".c", ".cpp", ".h", ".def", ".py", ".toml", ".sv", ".svh", ".vlt")
MADE = ("objects", "boards", "wires", "speed_", "trust_", "trace_", "asan_", "web_", "dpi")


def sources(root: Path, rtl: str = "rtl") -> dict[str, str]:
    """The digest of each source below root by its name, and of Verilator's version."""
    files = {name: root / name for name in FILES}
    for tree in (rtl, *TREES):
        for folder, _, names in os.walk(root / tree):
            inside = os.path.relpath(folder, root)
            files |= {f"{inside}/{n}": Path(folder, n) for n in names if n.endswith(KINDS)}
    verilator = Path(sysconfig.get_path("purelib"), "verilator", "include", "verilated_config.h")
    if verilator.is_file():
        files["verilator"] = verilator
    return {name: hashlib.sha256(files[name].read_bytes()).hexdigest() for name in sorted(files)}


def text(found: dict[str, str]) -> str:
    """What BUILD/sources holds: as sha256sum writes it."""
    return "".join(f"{digest}  {name}\n" for name, digest in found.items())


def digest(found: dict[str, str]) -> str:
    """16 digits: those that sha256sum gives of BUILD/sources."""
    return hashlib.sha256(text(found).encode()).hexdigest()[:16]


def forget(build: Path) -> None:
    """Removes all that is compiled but the libraries, which tell their digest."""
    found = [p for folder in build.glob("*") if folder.is_dir() and folder.name.startswith(MADE)
             for p in folder.iterdir() if not p.name.startswith("libmmcs_")]  # fmt: skip
    for path in found:
        shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)


def settle(build: Path, rtl: str) -> None:
    """What is compiled was made before each source that has changed since, or is gone."""
    kept, now = build / "sources", sources(Path(), rtl)
    try:
        before = dict(reversed(line.split("  ", 1)) for line in kept.read_text().splitlines())
    except (OSError, ValueError):
        before = {}
    if now == before:
        return
    made = max((p.stat().st_mtime_ns for p in build.glob("*/**/*.o")), default=0)
    changed = {name for name in now.keys() | before.keys() if now.get(name) != before.get(name)}
    if "verilator" not in before and before:  # what was compiled before the packages came
        changed.discard("verilator")
    if not all(Path(n).is_file() and Path(n).stat().st_mtime_ns > made for n in changed):
        forget(build)
    build.mkdir(parents=True, exist_ok=True)
    part = kept.with_suffix(f".{os.getpid()}")
    part.write_text(text(now))
    part.replace(kept)


if __name__ == "__main__":
    settle(Path(sys.argv[1]), *(sys.argv[2:] or ["rtl"]))
