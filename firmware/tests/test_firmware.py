# SPDX-License-Identifier: Apache-2.0
"""Runs every test function of the C test programs as an item of its own.

`// req: ID ID` above a function names the requirements that it covers."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from fwbuild import ROOT, SANITIZE, WARN, compile_c

HERE = Path(__file__).parent

DRIVER = sorted((ROOT / "firmware" / "mc").glob("*.c"))
FUNCTION = re.compile(r"((?:^//.*\n)*)^static void (test_\w+)\(void\)", re.M)


def cases():
    for source in sorted(HERE.glob("test_*.c")):
        for comment, name in FUNCTION.findall(source.read_text()):
            ids = " ".join(re.findall(r"req: *(.*)", comment)).split()
            marks = [pytest.mark.req(*ids)] if ids else []
            yield pytest.param(source, name, id=f"{source.stem}-{name}", marks=marks)


def program_of(source: Path) -> Path:
    """The test program of a file; the driver is compiled once for all of them."""
    driver = compile_c("driver_and_mock.o", [HERE / "mock.c", *DRIVER], [*SANITIZE, "-r"])
    return compile_c(source.stem, [source, driver], SANITIZE)


@pytest.mark.parametrize("source,name", list(cases()))
def test_c(source, name):
    program = program_of(source)
    done = subprocess.run([program, name], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_function_is_in_its_table():
    for source in sorted(HERE.glob("test_*.c")):
        program = program_of(source)
        listed = subprocess.run([program], capture_output=True, text=True, check=True).stdout
        assert sorted(listed.split()) == sorted(n for _, n in FUNCTION.findall(source.read_text()))


@pytest.mark.req("FW-1")
@pytest.mark.parametrize("compiler,package,flags", [
    ("m68k-linux-gnu-gcc", "gcc-m68k-linux-gnu", ["-m68020", "-msoft-float"]),
    ("riscv64-unknown-elf-gcc", "gcc-riscv64-unknown-elf", ["-march=rv32im", "-mabi=ilp32"]),
])  # fmt: skip
def test_compiles_freestanding(compiler, package, flags, tmp_path):
    for source in DRIVER:
        out = tmp_path / f"{source.stem}.o"
        command = [compiler, *WARN, *flags, "-ffreestanding", "-O2",
                   f"-I{ROOT}/firmware/include", f"-I{ROOT}/firmware/mc", "-c", str(source),
                   "-o", str(out)]  # fmt: skip
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            pytest.skip(f"{compiler} is missing; install it with: sudo apt-get install {package}")
        assert done.returncode == 0, done.stderr


@pytest.mark.req("DRV-1")
def test_header_is_old_style_c_too(tmp_path):
    program = tmp_path / "old.c"
    program.write_text(
        '#include "mcdef.h"\nint r;\nmain() { struct mc_param p; '
        "r = MSETPARAM; p.which = MD_POS | COULCOMP; return sizeof(p) != 72; }\n"
    )
    old = tmp_path / "old"
    subprocess.run(["cc", "-std=gnu89", "-w", f"-I{ROOT}/firmware/include", str(program), "-o",
                    str(old)], check=True)  # fmt: skip
    assert subprocess.run([old], check=False).returncode == 0
