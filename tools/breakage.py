# SPDX-License-Identifier: Apache-2.0
"""Breaks a copy of the design one line at a time and asks whether anything notices.

A list is a TOML file of [[break]] entries: `name`, `file`, `find` (text that stands once in the
file), `replace`, and what a judge needs: the tests that must turn red (tools/sabotage.py), or the
proof (tools/formal.py).
"""

import os
import shutil
import time
import tomllib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# (entry, folder of the broken copy) -> (complaint, or None if it was noticed; what noticed it)
Judge = Callable[[dict, Path], tuple[str | None, str]]


def entries(path: Path, only: str = "") -> list[dict]:
    """Breakages of a list; with `only`, those whose name, file or proof holds the text."""
    every = tomllib.loads(path.read_text())["break"]
    return [e for e in every if any(only in e.get(k, "") for k in ("name", "file", "proof"))]


def broken(entry: dict, folder: Path, parts: tuple[str, ...] = ("rtl",)) -> str | None:
    """Copies the parts of the project and breaks a line; the complaint if it is not there once."""
    shutil.rmtree(folder, ignore_errors=True)
    for part in parts:
        shutil.copytree(ROOT / part, folder / part)
    file = folder / entry["file"]
    if not file.is_file():
        return f"there is no {entry['file']}"
    text = file.read_text()
    if text.count(entry["find"]) != 1:
        return f"the text stands {text.count(entry['find'])} times in {entry['file']}, not once"
    file.write_text(text.replace(entry["find"], entry["replace"]))
    return None


def meet(who: str, todo: list[dict], judge: Judge, work: Path, parts: tuple[str, ...]) -> int:
    """Breaks each in turn, prints its fate; the number that nothing noticed.

    The copy of one that was not noticed stays below `work`.
    """

    def one(numbered: tuple[int, dict]) -> tuple[dict, str | None, str]:
        number, entry = numbered
        folder = work / f"{os.getpid()}_{number:03d}"
        complaint, seen = broken(entry, folder, parts), ""
        if complaint is None:
            complaint, seen = judge(entry, folder)
        if complaint is None:
            shutil.rmtree(folder, ignore_errors=True)
        return entry, complaint, seen

    started, green = time.monotonic(), 0
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for entry, complaint, seen in pool.map(one, enumerate(todo)):
            green += complaint is not None
            head = "NOT CAUGHT" if complaint else "caught"
            block = Path(entry["file"]).stem
            print(f"{head:10s} {block}: {entry['name']}: {complaint or seen}", flush=True)
    took = time.monotonic() - started
    files = len({e["file"] for e in todo})
    caught = f"{len(todo) - green} of {len(todo)} breakages caught"
    print(f"{who}: {caught}, {files} files, {took:.0f} s")
    return green
