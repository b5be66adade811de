# SPDX-License-Identifier: Apache-2.0
"""Builds the plant's C++ tests and runs each as a test of its own."""

import os
import re
from pathlib import Path

import pytest
from robots_header import ROOT, header

from tools.compiled import compiled, ran, written

HERE = Path(__file__).resolve().parent
PLANT = sorted((ROOT / "sim" / "plant").glob("*.cpp"))
TEST = re.compile(r"^TEST\((\w+)\)", re.M)


def found():
    for source in sorted(HERE.glob("test_*.cpp")):
        for name in TEST.findall(source.read_text()):
            yield pytest.param(source.stem, name, id=name)


def command(*flags: str) -> list[str]:
    robots = written("robots.h", header()).parent
    folders = (ROOT / "sim" / "abi", ROOT / "sim" / "plant", HERE, robots)
    compiler = os.environ.get("CXX", "g++")
    return [compiler, "-std=c++17", "-ffp-contract=off", *flags, *(f"-I{d}" for d in folders)]


def build(name: str) -> Path:
    """The test program `name`; the plant is compiled once for all."""
    fast = command("-O2", "-Wall", "-Wextra", "-Werror")
    plant = compiled("plant.o", [*fast, "-r"], PLANT)
    return compiled(name, fast, [HERE / f"{name}.cpp", plant])


@pytest.mark.parametrize(("program", "name"), list(found()))
def test_cpp(program, name):
    done = ran(build(program), name)
    assert done.returncode == 0, f"{name}\n{done.stdout}{done.stderr}"


DIGEST = "1406be12965f156e\n72b43cea4e2991d0\na4efa896b823bf4f\n"


def test_same_bits_as_ever_and_at_every_optimisation():
    """The state path does not depend on what a compiler makes of it. Who means to change what the
    plant calculates puts the new digest here."""
    fast = build("digest")
    plain = command("-O0", "-fsanitize=address,undefined")
    slow = compiled("digest_o0", plain, [HERE / "digest.cpp", *PLANT])
    runs = [ran(program, check=True) for program in (fast, slow, fast)]
    assert all(run.stderr == "" for run in runs), runs[1].stderr
    assert [run.stdout for run in runs] == 3 * [DIGEST]
