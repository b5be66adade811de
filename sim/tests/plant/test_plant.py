# SPDX-License-Identifier: Apache-2.0
"""Builds the plant's C++ tests and runs each as a test of its own."""

import fcntl
import os
import re
import subprocess
from pathlib import Path

import pytest
from robots_header import ROOT, header

HERE = Path(__file__).resolve().parent
OUT = ROOT / "build" / "plant-tests"
FLAGS = ["-std=c++17", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
INCLUDES = [ROOT / "sim" / "engine", ROOT / "sim" / "plant", HERE, OUT]
TEST = re.compile(r"(?:// req: (?P<ids>[\w\- ]+)\n)?TEST\((?P<name>\w+)\)")


def found():
    for source in sorted(HERE.glob("test_*.cpp")):
        for test in TEST.finditer(source.read_text()):
            marks = [pytest.mark.req(*test["ids"].split())] if test["ids"] else []
            yield pytest.param(source.stem, test["name"], marks=marks, id=test["name"])


def write_if_new(path: Path, text: str):
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)


def compile_new(target: Path, sources: list[Path], headers: list[Path], link: bool):
    newest = max(f.stat().st_mtime_ns for f in [*sources, *headers])
    if target.is_file() and target.stat().st_mtime_ns > newest:
        return
    includes = [f"-I{d}" for d in INCLUDES]
    what = [] if link else ["-c"]
    command = [os.environ.get("CXX", "g++"), *FLAGS, *includes, *what, *sources, "-o", target]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def build(name: str) -> Path:
    """The test program `name`, up to date. Two workers take turns."""
    OUT.mkdir(parents=True, exist_ok=True)
    with (OUT / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        write_if_new(OUT / "robots.h", header())
        plant_headers = [INCLUDES[0] / "mmcs_sim.h", *INCLUDES[1].glob("*.h")]
        headers = [*plant_headers, *HERE.glob("*.h"), OUT / "robots.h"]
        objects = []
        for source in sorted((ROOT / "sim" / "plant").glob("*.cpp")):
            objects.append(OUT / f"{source.stem}.o")
            compile_new(objects[-1], [source], plant_headers, link=False)
        compile_new(OUT / name, [HERE / f"{name}.cpp", *objects], headers, link=True)
    return OUT / name


@pytest.mark.parametrize(("program", "name"), list(found()))
def test_cpp(program, name):
    done = subprocess.run([build(program), name], text=True, capture_output=True, check=False)
    assert done.returncode == 0, f"{name}\n{done.stdout}{done.stderr}"


def test_same_bits_at_every_optimisation():
    """The state path does not depend on what a compiler makes of it."""
    fast = build("digest")
    slow = OUT / f"digest_o0_{os.getpid()}"
    sources = [HERE / "digest.cpp", *(ROOT / "sim" / "plant").glob("*.cpp")]
    flags = ["-std=c++17", "-O0", "-ffp-contract=off", "-fsanitize=undefined"]
    command = [os.environ.get("CXX", "g++"), *flags, *(f"-I{d}" for d in INCLUDES), *sources]
    subprocess.run([*command, "-o", slow], check=True)
    runs = [
        subprocess.run([p], text=True, capture_output=True, check=True) for p in (fast, slow, fast)
    ]
    slow.unlink()
    assert all(run.stderr == "" for run in runs), runs[1].stderr
    assert len({run.stdout for run in runs}) == 1, [run.stdout for run in runs]
