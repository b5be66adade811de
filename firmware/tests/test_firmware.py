# SPDX-License-Identifier: Apache-2.0
"""Runs every TEST(name, "ID ID") of the C test program as an item of its own, which covers the
requirements of these ids."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from fwbuild import ROOT, SANITIZE, WARN, compile_c
from hypothesis import given, settings
from hypothesis import strategies as st

from tools.compiled import compiled, ran, written

HERE = Path(__file__).parent

DRIVER = sorted((ROOT / "firmware" / "mc").glob("*.c"))
TESTS = [*sorted(HERE.glob("test_*.c")), HERE / "harness.c", HERE / "mock.c"]
FUNCTION = re.compile(r'^TEST\((test_\w+)(?:, "([^"]*)")?\)', re.M)


def cases():
    for source in TESTS:
        for name, ids in FUNCTION.findall(source.read_text()):
            marks = [pytest.mark.req(*ids.split())] if ids else []
            yield pytest.param(name, id=f"{source.stem}-{name}", marks=marks)


def program() -> Path:
    return compile_c("driver_tests", [*TESTS, *DRIVER], SANITIZE)


@pytest.mark.parametrize("name", list(cases()))
def test_c(name):
    done = ran(program(), name)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.req("DRV-2", "DRV-3", "DRV-4", "DRV-5", "DRV-6", "DRV-12")
@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(st.binary(min_size=300, max_size=1500))
def test_chosen_calls(choices):
    """Chosen by hypothesis, and shortened where the driver does not what the model of test_random.c
    says."""
    done = ran(program(), "test_calls_that_a_model_judges", choices.hex().rstrip("0"))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.req("FW-1")
@pytest.mark.parametrize("compiler,package,flags", [
    ("m68k-linux-gnu-gcc", "gcc-m68k-linux-gnu", ["-m68020", "-msoft-float"]),
    ("riscv64-unknown-elf-gcc", "gcc-riscv64-unknown-elf", ["-march=rv32im", "-mabi=ilp32"]),
])  # fmt: skip
def test_compiles_freestanding(compiler, package, flags):
    if not shutil.which(compiler):
        pytest.skip(f"{compiler} is missing; install it with: sudo apt-get install {package}")
    for source in DRIVER:
        command = [compiler, *WARN, *flags, "-ffreestanding", "-O2",
                   f"-I{ROOT}/firmware/include", f"-I{ROOT}/firmware/mc", "-c"]  # fmt: skip
        compiled(f"{source.stem}.o", command, [source])


@pytest.mark.req("DRV-1")
def test_header_is_old_style_c_too():
    program = written(
        "old.c",
        '#include "mcdef.h"\nint r;\nmain() { struct mc_param p; '
        "r = MSETPARAM; p.which = MD_POS | COULCOMP; return sizeof(p) != 72; }\n",
    )
    old = compiled("old", ["cc", "-std=gnu89", "-w", f"-I{ROOT}/firmware/include"], [program])
    assert subprocess.run([old], check=False).returncode == 0
