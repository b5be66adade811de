# SPDX-License-Identifier: Apache-2.0
"""The simulator by another compiler, and from damaged builds: the same run, to the hash."""

import os
import shutil
import sys

import pytest

from mmcs import ROOT, RunError
from mmcs.engine import build
from tools.compiled import ran

HASH = """
import sys
from pathlib import Path
from mmcs.engine import build
if len(sys.argv) > 1:
    build.ensure_library = lambda *a, **k: Path(sys.argv[1])
from mmcs.runs.runner import simulate
from mmcs.scenario.load import load
print(simulate(load("lab500")).hash)
"""
CLANG = pytest.mark.skipif(
    not shutil.which("clang++"), reason="clang is missing: sudo apt-get install clang"
)


def hash_of(*library):
    return ran(sys.executable, "-c", HASH, *library, check=True).stdout


@CLANG
@pytest.mark.slow
@pytest.mark.req("API-1")
def test_clang_builds_the_same_machine():
    env = build.make_env() | {"CI": "true", "CXX": "clang++", "CC": "clang"}
    done = ran("make", "-s", "-f", "sim/Makefile", "CARDS=1", "B=build/sim-clang", env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    assert hash_of(ROOT / "build/sim-clang/speed_c1/libmmcs_sim.so") == hash_of()


def test_the_python_that_installed_is_not_the_one_that_builds(monkeypatch):
    monkeypatch.setenv("PYTHON", "/usr/bin/false")  # as `make sim PYTHON=...` exports it
    make = ("make", "-n", "-f", "sim/Makefile", "MMCS_SIM_LOCKED=1", "flags")
    done = ran(*make, env=build.make_env(), check=True)
    assert sys.prefix in done.stdout


def test_make_is_told_nothing_of_the_users_own_work(monkeypatch, tmp_path):
    """Nor does it build a model of no boards, as of a list that cannot be read."""
    make = ["make", "-n", "-s", "-f", "sim/Makefile", f"B={tmp_path}"]
    bad = {"PYTHONIOENCODING": "utf-16", "RTL_DIR": "/nonexistent", "MAKEFILES": "/etc/passwd",
           "PYTHON": "/nonexistent"}  # fmt: skip
    for name, value in bad.items():
        monkeypatch.setenv(name, value)
    for env, wrong in (({**os.environ, "MAKEFILES": ""}, True), (build.make_env(), False)):
        done = ran(*make, env=env)
        assert (done.returncode != 0) == wrong == ("lists no boards" in done.stderr)


@pytest.mark.parametrize("tool", ["make", "g++"])
def test_a_tool_that_is_missing_is_named(monkeypatch, tmp_path, tool):
    """As a wheel on a machine without a compiler has it."""
    for other in {"make", "g++"} - {tool}:
        (tmp_path / other).symlink_to("/usr/bin/true")
    monkeypatch.delenv("CXX", raising=False)
    with pytest.raises(
        RunError, match=f"no '{tool}' found.*apt-get install {tool}".replace("+", r"\+")
    ):
        build.check_tools({"PATH": str(tmp_path)})


SMALL = """
O := build/sim/obj
$(shell mkdir -p build/sim && sha256sum sim/x.cpp >build/sim/sources)
LIB := build/sim/speed_c1/libmmcs_sim.so
$(LIB): $(O)/x.o
\t@mkdir -p $(@D)
\t@g++ -shared -o $@ $^
\t@sha256sum <$@ >$@.sum
$(O)/x.o: sim/x.cpp
\t@mkdir -p $(@D)
\t@g++ -fPIC -MMD -MP -c -o $@ $<
-include $(O)/x.d
"""


@pytest.fixture
def small(tmp_path, monkeypatch):
    """A folder in which a small library is built in place of the simulator."""
    (tmp_path / "sim").mkdir()
    (tmp_path / "sim" / "Makefile").write_text(SMALL)
    (tmp_path / "sim" / "x.cpp").write_text("int x() { return 1; }\n")
    monkeypatch.setattr(build, "BUILD", tmp_path / "build")
    monkeypatch.setattr(build, "WORK", tmp_path)
    monkeypatch.setattr(build, "LOG", tmp_path / "build" / "sim" / "build.log")
    monkeypatch.setattr(build, "workshop", lambda: tmp_path)
    return tmp_path


@pytest.mark.parametrize("damage", ["object", "rules", "half", "byte", "empty", "no sum"])
def test_a_damaged_build_is_made_again(small, damage):
    """As a full disk or a kill leaves it; make, compiler and linker are real. A library that is not
    the one that was built is never loaded."""
    path = build.ensure_library(1, "speed")
    whole, objects = path.read_bytes(), small / "build" / "sim" / "obj"
    sum_ = path.with_name(f"{path.name}.sum")
    if damage == "object":
        os.truncate(objects / "x.o", 100)
        path.unlink()
    elif damage == "rules":
        (objects / "x.d").write_bytes(b"\x00\xff garbage : : :\n\tx")
    elif damage == "no sum":
        sum_.unlink()
    else:
        changed = {"half": whole[:100], "byte": whole[:-1] + bytes([whole[-1] ^ 1]), "empty": b""}
        path.write_bytes(changed[damage])
    assert build.ensure_library(1, "speed").read_bytes() == whole and sum_.exists()
    made = path.stat().st_mtime_ns
    assert build.ensure_library(1, "speed").stat().st_mtime_ns == made


def test_a_build_of_which_files_are_gone_is_made_again(small):
    """Stamps alone tell make that all is there."""
    build.ensure_library(1, "speed").unlink()
    (small / "build" / "sim" / "obj" / "x.o").unlink()
    stamp = small / "build" / "sim" / "boards" / "boards.stamp"
    rule = "$(O)/x.o: sim/x.cpp\n"
    gone = f"\t@! test -e {stamp} || {{ echo fatal error: x.h: No such file; exit 1; }}\n"
    (small / "sim" / "Makefile").write_text(SMALL.replace(rule, rule + gone))
    stamp.parent.mkdir(parents=True)
    stamp.touch()
    assert build.ensure_library(1, "speed").exists() and not stamp.exists()


def test_an_error_of_the_source_is_told(small):
    (small / "sim" / "x.cpp").write_text("int x() { return y; }\n")
    with pytest.raises(RunError, match="error: .y. was not declared"):
        build.ensure_library(1, "speed")
