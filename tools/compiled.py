# SPDX-License-Identifier: Apache-2.0
"""What a compiler makes for a test, made anew only where something that it reads has changed.

build/compiled/NAME-KEY holds the result and what it was made of: KEY stands for the command and the
compiler; the sources and every header that they include are looked at by their content.
"""

import fcntl
import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STORE = ROOT / "build" / "compiled"


class CompileError(Exception):
    """The compiler's words."""


def compiled(
    name: str, command: list, sources: list, after: Sequence = (), reads: Sequence[Path] = ()
) -> Path:
    """The file that `command sources after -o FILE` makes; what `after` names by path counts too.

    reads: what the compiler reads without telling. What it refuses is a CompileError, each time.
    """
    words = [str(w) for w in (*command, *sources, *after)]
    tool = Path(shutil.which(words[0]) or words[0]).resolve()
    if not tool.is_file():
        raise FileNotFoundError(words[0])
    stat = tool.stat()
    told = json.dumps([words, "-M", str(tool), stat.st_size, stat.st_mtime_ns])
    folder = STORE / f"{name}-{hashlib.sha256(told.encode()).hexdigest()[:12]}"
    with locked(folder.with_suffix(".lock")):
        if not _is_fresh(folder):
            _make(folder, name, words, reads)
    return folder / name


@contextmanager
def locked(path: Path):
    """One process at a time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def written(name: str, text: str) -> Path:
    """A source that a test makes up, at a place that is the same in every run."""
    path = STORE / hashlib.sha256(text.encode()).hexdigest()[:12] / name
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh = path.with_suffix(f".{os.getpid()}")
        fresh.write_text(text)
        fresh.rename(path)
    return path


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _is_fresh(folder: Path) -> bool:
    try:
        made_of = json.loads((folder / "made_of.json").read_text())
        return all(_digest(Path(path)) == before for path, before in made_of.items())
    except (OSError, ValueError):
        return False


def ran(*command, check=False, **options) -> subprocess.CompletedProcess:
    """How a command of a test has ended, and what it said."""
    how = {"cwd": ROOT, "text": True, "capture_output": True} | options
    return subprocess.run([str(word) for word in command], check=check, **how)


def _run(words: list[str]) -> str:
    done = ran(*words)
    if done.returncode:
        raise CompileError(done.stderr)
    return done.stdout


def _make(folder: Path, name: str, words: list[str], reads: Sequence[Path]) -> None:
    made = Path(tempfile.mkdtemp(dir=STORE))
    try:
        _run([*words, "-o", str(made / name)])
        read = {*words[1:], *map(str, reads)}
        # -MD while compiling keeps the headers of the last of several sources only
        for rule in _run([*words, "-M"]).replace("\\\n", " ").splitlines():
            found = re.split(r"(?<!\\)\s+", rule.partition(": ")[2])
            read.update(word.replace("\\ ", " ") for word in found if word)
        paths = sorted({os.path.abspath(ROOT / p) for p in read if os.path.isfile(ROOT / p)})
        made_of = {path: _digest(Path(path)) for path in paths}
        (made / "made_of.json").write_text(json.dumps(made_of, indent=1))
        shutil.rmtree(folder, ignore_errors=True)
        made.rename(folder)
    finally:
        shutil.rmtree(made, ignore_errors=True)
