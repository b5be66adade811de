# SPDX-License-Identifier: Apache-2.0
"""Builds the plant's C++ tests and runs each as a test of its own."""

import fcntl
import os
import re
import subprocess
from pathlib import Path

import pytest
from robots_header import ROOT, header

from tools.compiled import compiled

HERE = Path(__file__).resolve().parent
PLANT = sorted((ROOT / "sim" / "plant").glob("*.cpp"))
OUT = ROOT / "build" / "plant-tests"
FLAGS = ["-std=c++17", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
INCLUDES = [ROOT / "sim" / "abi", ROOT / "sim" / "plant", HERE, OUT]
TEST = re.compile(r"^TEST\((\w+)\)", re.M)


def found():
    for source in sorted(HERE.glob("test_*.cpp")):
        for name in TEST.findall(source.read_text()):
            yield pytest.param(source.stem, name, id=name)


def write_if_new(path: Path, text: str):
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)


def build(name: str) -> Path:
    """The test program `name`; the plant is compiled once for all. Two workers take turns."""
    OUT.mkdir(parents=True, exist_ok=True)
    with (OUT / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        write_if_new(OUT / "robots.h", header())
    command = [os.environ.get("CXX", "g++"), *FLAGS, *(f"-I{d}" for d in INCLUDES)]
    plant = compiled("plant.o", [*command, "-r"], PLANT)
    return compiled(name, command, [HERE / f"{name}.cpp", plant])


@pytest.mark.parametrize(("program", "name"), list(found()))
def test_cpp(program, name):
    done = subprocess.run([build(program), name], text=True, capture_output=True, check=False)
    assert done.returncode == 0, f"{name}\n{done.stdout}{done.stderr}"


def test_same_bits_at_every_optimisation():
    """The state path does not depend on what a compiler makes of it."""
    fast = build("digest")
    flags = ["-std=c++17", "-O0", "-ffp-contract=off", "-fsanitize=undefined"]
    command = [os.environ.get("CXX", "g++"), *flags, *(f"-I{d}" for d in INCLUDES)]
    read = [HERE / "bench.h", OUT / "robots.h"]  # of the first source: of many the last's are told
    slow = compiled("digest_o0", command, [HERE / "digest.cpp", *PLANT], reads=read)
    runs = [
        subprocess.run([p], text=True, capture_output=True, check=True) for p in (fast, slow, fast)
    ]
    assert all(run.stderr == "" for run in runs), runs[1].stderr
    assert len({run.stdout for run in runs}) == 1, [run.stdout for run in runs]
