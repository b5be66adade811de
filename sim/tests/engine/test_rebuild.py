# SPDX-License-Identifier: Apache-2.0
"""A build that goes on: who includes what changed is compiled again, and files come and go."""

import os
import re
from pathlib import Path

import pytest

from mmcs import ROOT, ensure_library, make_env, service
from tools.compiled import ran

pytestmark = pytest.mark.req("API-1")
MAKE = ["make", "-f", "sim/Makefile", "MMCS_SIM_LOCKED=1", "CARDS=3"]
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
HEADERS = ["sim/abi/mmcs_sim.h", "sim/model/wires.h", "sim/model/board.h", "sim/model/cache.h",
           "sim/engine/sim.h", "sim/plant/encoder.h", "firmware/mc/mc.h"]  # fmt: skip


def made(*options, folder=ROOT):
    return ran(*MAKE, *options, cwd=folder, env=make_env(), check=True).stdout


@pytest.fixture(scope="module")
def reads():
    """Of each object of the library: the files that it is compiled of, as #include names them."""
    ensure_library(3, "speed")
    objects = [Path(o) for o in made("parts").split() if "runtime" not in o]
    own = [
        f"firmware/mc/{o.stem}.c" if o.parent.name == "mc" else o.with_suffix(".cpp")
        for o in objects
    ]
    folders = [*dict.fromkeys(o.parent for o in objects)]
    folders += [f / "v" for f in folders]
    sim = [Path("sim", name) for name in ("abi", "engine", "model", "plant", "service")]
    folders += [Path(), *sim, Path("firmware/mc"), Path("firmware/include")]

    def closure(first):
        found, todo = set(), [Path(first)]
        while todo:
            file = todo.pop()
            if file in found or not (ROOT / file).is_file():
                continue
            found.add(file)
            for name in INCLUDE.findall((ROOT / file).read_text(errors="replace")):
                todo += [f / name for f in (file.parent, *folders)]
        return {os.path.normpath(f) for f in found}

    return {str(o): closure(f) for o, f in zip(objects, own, strict=True)}


def again(file):
    """The objects that are compiled anew once this file is newer."""
    return set(re.findall(r"-o (build/\S+\.o)\b", made("-n", "-W", file)))


@pytest.mark.parametrize("header", HEADERS)
def test_whoever_includes_a_header_is_compiled_again(reads, header):
    wanted = {o for o, files in reads.items() if header in files}
    assert wanted
    assert wanted - again(header) == set()


def test_a_build_that_stands_is_left_alone(reads):
    assert "-o build/" not in made("-n")


@pytest.mark.parametrize("file", ["rtl/mark1/axis.sv", "rtl/mmcs_assert.svh", "rtl/mmcs.sv"])
def test_hardware_that_changed_is_made_anew_with_all_that_knows_it(reads, file):
    hardware = {o for o in reads if "/boards" in o or "/wires" in o or "/speed_c3" in o}
    assert hardware
    assert hardware - again(file) == set()


def test_the_service_is_not_compiled_again(tmp_path, monkeypatch):
    """A simulator that is built has it, unless a file of it is newer."""
    ensure_library(3, "speed")
    monkeypatch.delattr(service, "compiled")
    ffi, library = service.load.__wrapped__()
    assert ffi.string(library.mmcs_log_lines(1, ffi.NULL, 0))
    (tmp_path / "newer.cpp").touch()
    assert service._simulator([tmp_path / "newer.cpp"]) is None


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
