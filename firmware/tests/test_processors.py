# SPDX-License-Identifier: Apache-2.0
"""All C tests of the driver on a 68020 and on RV32: driver and mock compiled for them, with the law
in 32 bits, on unicorn's models."""

import functools
import importlib.util
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from fwbuild import INCLUDE, ROOT, WARN
from test_firmware import DRIVER, HERE, TESTS, cases

from tools.compiled import compiled, ran

PORTS = {
    "m68020": ("m68k-linux-gnu-", ["-m68020", "-msoft-float"], "big"),
    "rv32": ("riscv64-unknown-elf-", ["-march=rv32im", "-mabi=ilp32"], "little"),
}
missing = not importlib.util.find_spec("unicorn") or any(
    not shutil.which(f"{prefix}gcc") for prefix, *_ in PORTS.values()
)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        missing,
        reason="a cross compiler or a processor model is missing; install them with: make test",
    ),
]

BASE, BYTES = 0x10000, 1 << 23
FREE = HERE / "free"
FLAGS = ["-O2", "-ffreestanding", "-fno-pic", "-fno-stack-protector", "-DSERVO_NARROW",
         "-fno-tree-loop-distribute-patterns"]  # fmt: skip
LINK = ["-nostdlib", "-static", "-Wl,-N", f"-Wl,-Ttext={BASE:#x}", "-Wl,-e,free_start",
        "-Wl,--build-id=none", "-Wl,--no-relax", "-Wl,--no-warn-rwx-segments"]  # fmt: skip


@functools.cache
def image_of(port: str) -> tuple[bytes, dict[str, int]]:
    """What its memory holds, and where its symbols are."""
    prefix, cpu, _ = PORTS[port]
    sources = [*TESTS, FREE / "free.c", ROOT / "firmware" / "ports" / "memory.c", *DRIVER]
    command = [f"{prefix}gcc", *WARN, *INCLUDE, *cpu, *FLAGS, *LINK]
    program = compiled(f"driver_tests.{port}", command, sources, ["-lgcc"])
    listed = ran(f"{prefix}nm", program, check=True).stdout
    rows = [line.split() for line in listed.splitlines()]
    with tempfile.NamedTemporaryFile() as binary:
        subprocess.run([f"{prefix}objcopy", "-O", "binary", program, binary.name], check=True)
        return Path(binary.name).read_bytes(), {r[2]: int(r[0], 16) for r in rows if len(r) == 3}


def processor(port: str):
    """With empty memory, and its stack at the end of that."""
    import unicorn
    from unicorn import m68k_const, riscv_const

    if port == "m68020":
        cpu = unicorn.Uc(unicorn.UC_ARCH_M68K, unicorn.UC_MODE_BIG_ENDIAN)
        cpu.ctl_set_cpu_model(m68k_const.UC_CPU_M68K_M68020)
        stack = m68k_const.UC_M68K_REG_A7
    else:
        cpu = unicorn.Uc(unicorn.UC_ARCH_RISCV, unicorn.UC_MODE_RISCV32)
        stack = riscv_const.UC_RISCV_REG_SP
    cpu.mem_map(0, BYTES)
    cpu.reg_write(stack, BYTES - 16)
    return cpu


def run(port: str, name: str) -> tuple[int, str]:
    """Exit status and output of a test."""
    image, at = image_of(port)
    cpu = processor(port)
    cpu.mem_write(BASE, image)
    cpu.mem_write(at["wanted"], name.encode())
    cpu.mem_write(at["status"], b"\xff\xff\xff\xff")
    cpu.emu_start(at["free_start"], at["free_end"])
    told = bytes(cpu.mem_read(at["told"], 1024)).split(b"\0")[0].decode()
    return int.from_bytes(cpu.mem_read(at["status"], 4), PORTS[port][2]), told


@pytest.mark.parametrize("port", PORTS)
@pytest.mark.parametrize("name", list(cases()))
def test_c(port, name):
    assert run(port, name) == (0, "")
