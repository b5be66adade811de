# SPDX-License-Identifier: Apache-2.0
"""Builds of the simulator: those that go on, those by another compiler, and damaged ones."""

import os
import re
import shutil
import sys
import time

import pytest

from mmcs import ROOT, RunError, ensure_library, make_env, service
from mmcs.engine import build
from tools.compiled import ran

pytestmark = pytest.mark.req("API-1")
MAKE = ["make", "-f", "sim/Makefile", "MMCS_SIM_LOCKED=1", "CARDS=3"]
BOARDS = "boards/parts boards/tables wires_c3/logic wires_c3/wires"
# A file, and objects that are compiled of it.
MADE_OF = {
    "sim/abi/mmcs_sim.h": "objects/engine objects/service",
    "sim/model/wires.h": "objects/rack objects/learn boards/tables wires_c3/logic wires_c3/wires",
    "sim/model/board.h": "boards/parts objects/rack objects/learn wires_c3/logic",
    "sim/model/cache.h": "objects/rack objects/learn",
    "sim/engine/sim.h": "objects/engine",
    "sim/plant/encoder.h": "objects/engine",
    "firmware/mc/mc.h": "objects/engine objects/mc/hw objects/mc/ioctl objects/mc/timer",
    "rtl/mark1/mark1_axis.sv": BOARDS,
    "rtl/mmcs_assert.svh": BOARDS,
    "rtl/mmcs.sv": BOARDS,
}


def made(*options, folder=ROOT):
    return ran(*MAKE, *options, cwd=folder, env=make_env(), check=True).stdout


def test_whatever_a_changed_file_is_in_is_compiled_again():
    ran("make", "-s", "-f", "sim/Makefile", "CARDS=3", env=make_env(), check=True)
    assert "-o build/" not in made("-n"), "a build that stands is left alone"
    for file, objects in MADE_OF.items():
        again = re.findall(r"-o build/sim/(\S+)\.o\b", made("-n", "-W", file))
        assert set(objects.split()) <= set(again), file


def test_the_service_is_not_compiled_again(monkeypatch):
    """A simulator that is built has it, unless it is of other sources."""
    ensure_library(3, "speed")
    monkeypatch.delattr(service, "compiled")
    ffi, library = service.load.__wrapped__()
    assert ffi.string(library.mmcs_log_lines(1, ffi.NULL, 0))
    monkeypatch.setattr(service, "digest", lambda: "0123456789abcdef")
    assert service._simulator() is None


def define(file, constant):
    """The file's text: a constant, beside that of a.h in a.cpp."""
    include = '#include "a.h"\n' if file.name == "a.cpp" else ""
    file.write_text(f"{include}extern const int {constant}; const int {constant} = 1;\n")


@pytest.fixture
def small(tmp_path):
    """The Makefile with a plant of two files and a header, and no engine."""
    for name in ("tools", "rtl", "firmware", "mmcs.core"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "sim" / "plant").mkdir(parents=True)
    for name in ("Makefile", "model", "abi", "card"):
        (tmp_path / "sim" / name).symlink_to(ROOT / "sim" / name)
    plant = tmp_path / "sim" / "plant"
    for name, text in {"a.h": "h", "a.cpp": "a", "b.cpp": "b"}.items():
        define(plant / name, text)

    def compiled():
        made("-s", "build/sim/objects/engine.o", folder=tmp_path)
        told = ran("nm", "build/sim/objects/engine.o", cwd=tmp_path, check=True).stdout
        return set(re.findall(r" [RB] (\w+)", told))

    return plant, compiled


OLD, AHEAD = -(10**6), 10**6  # seconds from now: tar x, rsync -t; a clock that was set back since
CHANGES = [("b.cpp", "c"), ("d.cpp", "d"), ("a.h", "e"), ("d.cpp", ""), ("a.cpp", "f")]


def settled(folder):
    """As sim/Makefile does before it goes by times."""
    ran("python3", "sim/model/digest.py", "build/sim", cwd=folder, check=True)


@pytest.mark.parametrize("age", [None, OLD, 0, AHEAD])
def test_a_changed_source_is_compiled_whatever_its_time(small, age):
    """Files come, go and change; None: by their times alone. What stands is left alone."""
    plant, compiled = small
    folder, held = plant.parents[1], {"a.h": "h", "a.cpp": "a", "b.cpp": "b"}
    if age is not None:
        settled(folder)
    assert compiled() == set(held.values())
    for name, constant in CHANGES:
        held[name] = constant
        if constant:
            define(plant / name, constant)
        else:
            (plant / name).unlink()
        if age is not None:
            if constant:
                os.utime(plant / name, (time.time() + age,) * 2)
            settled(folder)
        assert compiled() == set(held.values()) - {""}
    if age is not None:
        before = (folder / "build/sim/objects/engine.o").stat().st_mtime_ns
        os.utime(plant / "b.cpp", (time.time() + age,) * 2)
        settled(folder)
        assert (folder / "build/sim/objects/engine.o").stat().st_mtime_ns == before


def test_what_is_compiled_while_packages_come_stays(small):
    """The first digest knows of no Verilator, which nothing early is compiled of."""
    plant, compiled = small
    folder = plant.parents[1]
    settled(folder)
    compiled()
    sources = folder / "build/sim/sources"
    before = sources.read_text().splitlines(keepends=True)
    for name in ("verilator", "rtl/mmcs.sv"):
        sources.write_text("".join(line for line in before if not line.endswith(f"  {name}\n")))
        settled(folder)
        assert (folder / "build/sim/objects/engine.o").is_file() == (name == "verilator")
        assert sources.read_text() == "".join(before)


def test_what_no_object_defines_ends_the_link(tmp_path):
    """An empty object file is one to the linker: without this it makes a library."""
    link = next(
        x for x in made("-n", "KIND=speed", "-W", "sim/Makefile").splitlines() if " -shared " in x
    )
    (tmp_path / "a.c").write_text("int b(void);\nint a(void) { return b(); }\n")
    ran("cc", "-fPIC", "-c", "a.c", cwd=tmp_path, check=True)
    flags = [word for word in link.split() if word.startswith("-") and word != "-o"]
    done = ran("c++", *flags, "-o", "a.so", "a.o", cwd=tmp_path)
    assert done.returncode and "undefined" in done.stderr


# --- by another compiler, damaged -----------------------------------------------------------------

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
$(shell echo >>made)
O := build/sim/objects
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
def library(tmp_path, monkeypatch):
    """A folder in which a small library is built in place of the simulator. `made` in it has a line
    for each make."""
    (tmp_path / "sim").mkdir()
    (tmp_path / "sim" / "Makefile").write_text(SMALL)
    (tmp_path / "sim" / "x.cpp").write_text("int x() { return 1; }\n")
    monkeypatch.setattr(build, "BUILD", tmp_path / "build")
    monkeypatch.setattr(build, "WORK", tmp_path)
    monkeypatch.setattr(build, "LOG", tmp_path / "build" / "sim" / "build.log")
    monkeypatch.setattr(build, "workshop", lambda: tmp_path)
    return tmp_path


@pytest.mark.parametrize("damage", ["object", "rules", "half", "byte", "empty", "no sum"])
def test_a_damaged_build_is_made_again(library, damage):
    """As a full disk or a kill leaves it; make, compiler and linker are real. A library that is not
    the one that was built is never loaded."""
    path = build.ensure_library(1, "speed")
    whole, objects = path.read_bytes(), library / "build" / "sim" / "objects"
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


def test_a_build_of_which_files_are_gone_is_made_again(library):
    """Stamps alone tell make that all is there."""
    build.ensure_library(1, "speed").unlink()
    (library / "build" / "sim" / "objects" / "x.o").unlink()
    stamp = library / "build" / "sim" / "boards" / "boards.stamp"
    rule = "$(O)/x.o: sim/x.cpp\n"
    gone = f"\t@! test -e {stamp} || {{ echo fatal error: x.h: No such file; exit 1; }}\n"
    (library / "sim" / "Makefile").write_text(SMALL.replace(rule, rule + gone))
    stamp.parent.mkdir(parents=True)
    stamp.touch()
    assert build.ensure_library(1, "speed").exists() and not stamp.exists()


def makes(folder) -> int:
    return len((folder / "made").read_text())


def test_an_error_of_the_source_is_told(library):
    """At once if it came with a change of the sources; else whatever was compiled is made again,
    once."""
    (library / "sim" / "x.cpp").write_text("int x() { return y; }\n")
    for tries in (1, 3, 4):  # the third finds no sources that a build was of
        with pytest.raises(RunError, match="error: .y. was not declared"):
            build.ensure_library(1, "speed")
        assert makes(library) == tries


@pytest.mark.parametrize("age", [OLD, 0, AHEAD])
def test_a_library_is_of_its_sources_or_made_again(library, age):
    path = build.ensure_library(1, "speed")
    sum_ = path.with_name(f"{path.name}.sum")
    digest = sum_.read_text().split()[0]
    os.utime(path, (time.time() + age,) * 2)
    for made_of, made in ((build.digest(), 1), ("0123456789abcdef", 2)):
        sum_.write_text(f"{digest} {made_of}\n")
        build.ensure_library(1, "speed")
        assert makes(library) == made
