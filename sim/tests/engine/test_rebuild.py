# SPDX-License-Identifier: Apache-2.0
"""A build that goes on: who includes what changed is compiled again, and files come and go."""

import re

import pytest

from mmcs import ROOT, ensure_library, make_env, service
from tools.compiled import ran

pytestmark = pytest.mark.req("API-1")
MAKE = ["make", "-f", "sim/Makefile", "MMCS_SIM_LOCKED=1", "CARDS=3"]
BOARDS = "boards/parts boards/rack wires_c3/wires speed_c3/kind"
# A file, and objects that are compiled of it.
MADE_OF = {
    "sim/abi/mmcs_sim.h": "obj/engine obj/service",
    "sim/model/wires.h": "boards/rack boards/shared wires_c3/wires",
    "sim/model/board.h": "boards/parts boards/rack",
    "sim/model/cache.h": "boards/rack",
    "sim/engine/sim.h": "obj/engine",
    "sim/plant/encoder.h": "obj/engine",
    "firmware/mc/mc.h": "obj/engine obj/mc/hw obj/mc/ioctl obj/mc/timer",
    "rtl/mark1/axis.sv": BOARDS,
    "rtl/mmcs_assert.svh": BOARDS,
    "rtl/mmcs.sv": BOARDS,
}


def made(*options, folder=ROOT):
    return ran(*MAKE, *options, cwd=folder, env=make_env(), check=True).stdout


def test_whatever_a_changed_file_is_in_is_compiled_again():
    ensure_library(3, "speed")
    assert "-o build/" not in made("-n"), "a build that stands is left alone"
    for file, objects in MADE_OF.items():
        again = re.findall(r"-o build/sim/(\S+)\.o\b", made("-n", "-W", file))
        assert set(objects.split()) <= set(again), file


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
