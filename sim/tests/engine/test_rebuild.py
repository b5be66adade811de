# SPDX-License-Identifier: Apache-2.0
"""A build that goes on: who includes what changed is compiled again, and files come and go."""

import io
import os
import re
import time

import pytest

from mmcs import ROOT, RunError, ensure_library, make_env, service
from mmcs.engine import build
from tools.compiled import ran

pytestmark = pytest.mark.req("API-1")
MAKE = ["make", "-f", "sim/Makefile", "MMCS_SIM_LOCKED=1", "CARDS=3"]
BOARDS = "boards/parts boards/rack wires_c3/logic wires_c3/wires speed_c3/kind"
# A file, and objects that are compiled of it.
MADE_OF = {
    "sim/abi/mmcs_sim.h": "obj/engine obj/service",
    "sim/model/wires.h": "boards/rack boards/shared wires_c3/logic wires_c3/wires",
    "sim/model/board.h": "boards/parts boards/rack wires_c3/logic",
    "sim/model/cache.h": "boards/rack",
    "sim/engine/sim.h": "obj/engine",
    "sim/plant/encoder.h": "obj/engine",
    "firmware/mc/mc.h": "obj/engine obj/mc/hw obj/mc/ioctl obj/mc/timer",
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


@pytest.fixture
def small(tmp_path):
    """The Makefile with a plant of two files and a header, and no engine."""
    for name in ("tools", "rtl", "firmware", "mmcs.core"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "sim" / "plant").mkdir(parents=True)
    for name in ("Makefile", "model", "abi"):
        (tmp_path / "sim" / name).symlink_to(ROOT / "sim" / name)
    plant = tmp_path / "sim" / "plant"
    (plant / "a.h").write_text("#define A 1\n")
    (plant / "a.cpp").write_text('#include "a.h"\nextern const int a; const int a = A;\n')
    (plant / "b.cpp").write_text("extern const int b; const int b = 2;\n")

    def compiled():
        made("-s", "build/sim/obj/engine.o", folder=tmp_path)
        told = ran("nm", "build/sim/obj/engine.o", cwd=tmp_path, check=True).stdout
        return set(re.findall(r" [RB] (\w+)", told))

    return plant, compiled


def test_files_come_go_and_change(small):
    plant, compiled = small
    assert compiled() == {"a", "b"}
    (plant / "a.h").write_text("#define A 1\nextern const int c; const int c = 3;\n")
    assert compiled() == {"a", "b", "c"}
    (plant / "b.cpp").unlink()
    (plant / "d.cpp").write_text("extern const int d; const int d = 4;\n")
    assert compiled() == {"a", "c", "d"}
    (plant / "d.cpp").unlink()
    (plant / "a.cpp").write_text('#include "a.h"\nextern const int e; const int e = A;\n')
    assert compiled() == {"c", "e"}


# --- what times of files do not show -------------------------------------------------------------

OLD, AHEAD = -(10**6), 10**6  # seconds from now: tar x, rsync -t; a clock that was set back since


def settled(folder):
    """As sim/Makefile does before it goes by times."""
    ran("python3", "sim/model/digest.py", "build/sim", cwd=folder, check=True)


@pytest.mark.parametrize(("age", "change"), [
    (OLD, "edit"), (OLD, "add"), (OLD, "remove"), (AHEAD, "edit"), (0, "edit"),
])  # fmt: skip
def test_a_changed_source_is_compiled_whatever_its_time(small, age, change):
    plant, compiled = small
    folder = plant.parents[1]
    settled(folder)
    assert compiled() == {"a", "b"}
    file = plant / ("d.cpp" if change == "add" else "b.cpp")
    if change == "remove":
        file.unlink()
    else:
        name = file.stem if change == "add" else "c"
        file.write_text(f"extern const int {name}; const int {name} = 2;\n")
        os.utime(file, (time.time() + age,) * 2)
    settled(folder)
    assert compiled() == {"edit": {"a", "c"}, "add": {"a", "b", "d"}, "remove": {"a"}}[change]


def test_what_stands_is_left_alone_whatever_its_time(small):
    plant, compiled = small
    settled(plant.parents[1])
    compiled()
    made = plant.parents[1] / "build" / "sim" / "obj" / "engine.o"
    before = made.stat().st_mtime_ns
    for age in (OLD, AHEAD):
        os.utime(plant / "a.h", (time.time() + age,) * 2)
        settled(plant.parents[1])
        assert made.stat().st_mtime_ns == before


@pytest.fixture
def making(tmp_path, monkeypatch):
    """ensure_library() with a make that ends so, and what was called; the sources before it."""
    folder = tmp_path / "sim"
    (folder / "speed_c1").mkdir(parents=True)
    (folder / "obj").mkdir()
    (folder / "obj" / "parts.o").touch()  # as a power cut leaves one
    monkeypatch.setattr(build, "BUILD", tmp_path)
    monkeypatch.setattr(build, "WORK", tmp_path)
    monkeypatch.setattr(build, "LOG", folder / "build.log")
    monkeypatch.setattr(build, "_spinner", lambda _: io.StringIO())

    def ensure(statuses, sources="as before", change=""):
        (folder / "sources").write_text(sources)
        calls, left = [], iter(statuses)

        def make(command, env, **_):
            calls.append((folder / "obj" / "parts.o").exists())
            if change:
                (folder / "sources").write_text(change)
            build.LOG.write_text("cc: an error that no list of texts knows\n")
            return next(left)

        monkeypatch.setattr(build, "_run", make)
        try:
            build.ensure_library(1, "speed")
        except RunError as error:
            assert "an error that no list" in str(error)  # and no library comes of this make
        return calls

    return folder, ensure


def test_a_failed_build_is_tried_once_from_nothing(making):
    """Unless its sources have changed: then the error is of the change."""
    folder, ensure = making
    assert ensure([2], change="other sources") == [True]
    assert ensure([2, 2]) == [True, False], "the second time nothing that was compiled is there"
    assert not (folder / "sources").exists(), "nor is it made twice the next time"


@pytest.mark.parametrize("age", [OLD, 0, AHEAD])
def test_a_library_is_of_its_sources_or_made_again(making, age):
    folder, ensure = making
    library = folder / "speed_c1" / "libmmcs_sim.so"
    library.write_bytes(b"a library")
    digest = ran("sha256sum", library, check=True).stdout.split()[0]
    os.utime(library, (time.time() + age,) * 2)
    for made_of, made in ((build.digest(), []), ("0123456789abcdef", [True])):
        library.with_name("libmmcs_sim.so.sum").write_text(f"{digest} {made_of}\n")
        assert ensure([0]) == made


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
