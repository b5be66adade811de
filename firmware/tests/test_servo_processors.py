# SPDX-License-Identifier: Apache-2.0
"""The servo compiled for the 68020 and for RV32 equals native, its arithmetic to the bit, and takes
no longer than its page tells. §1.3.1, §5.

The images run on Musashi and on the processor models of unicorn, which share nothing. Each hash
covers the results and the state of six axes after every tick.
"""

import functools
import importlib.util
import os
import re
import tomllib

import pytest
from test_processors import missing

from mmcs import ROOT
from studies.processors import cycles as bench

pytestmark = pytest.mark.skipif(
    missing or not importlib.util.find_spec("machine68k"),
    reason="a cross compiler or a processor model is missing; install them with: make test",
)

TICKS = 10_000 if os.environ.get("MMCS_FAMILY") == "all" else 2_000
RAM_BYTES = 0x20000
STOP = {"m68020": bytes.fromhex("4E722700"), "rv32": (0x10500073).to_bytes(4, "little")}  # or WFI


def on_m68020(image: bytes):
    """The processor after reset, its byte order and the address at which it starts."""
    from unicorn import UC_ARCH_M68K, UC_MODE_BIG_ENDIAN, Uc
    from unicorn.m68k_const import UC_CPU_M68K_M68020, UC_M68K_REG_A7, UC_M68K_REG_SR

    cpu = Uc(UC_ARCH_M68K, UC_MODE_BIG_ENDIAN)
    cpu.ctl_set_cpu_model(UC_CPU_M68K_M68020)
    cpu.reg_write(UC_M68K_REG_SR, 0x2700)
    cpu.reg_write(UC_M68K_REG_A7, int.from_bytes(image[:4], "big"))
    return cpu, "big", int.from_bytes(image[4:8], "big")


def on_rv32(_):
    from unicorn import UC_ARCH_RISCV, UC_MODE_RISCV32, Uc

    return Uc(UC_ARCH_RISCV, UC_MODE_RISCV32), "little", 0x80


MODELS = {"m68020": on_m68020, "rv32": on_rv32}


def on_unicorn(port: str, profile: int, ticks: int) -> int:
    """Runs the image from reset to the instruction that stops the processor; the hash."""
    image = (bench.FIRMWARE / port / "bench.bin").read_bytes()
    cpu, order, start = MODELS[port](image)
    cpu.mem_map(0, RAM_BYTES)
    cpu.mem_write(0, image)
    cpu.mem_write(bench.BLOCK, profile.to_bytes(4, order) + ticks.to_bytes(4, order))
    cpu.emu_start(start, image.index(STOP[port], start))
    assert int.from_bytes(cpu.mem_read(bench.DONE, 4), order) == 1, "the image did not end"
    return int.from_bytes(cpu.mem_read(bench.BLOCK + 8, 4), order)


def on_musashi(profile: int, ticks: int) -> int:
    return bench.on_68020(profile, ticks)[0]


PROCESSORS = {
    "Musashi": on_musashi,
    **{f"{port} of unicorn": functools.partial(on_unicorn, port) for port in MODELS},
}


@pytest.fixture(scope="module")
def native():
    bench.build()
    return bench.native()


@pytest.mark.req("SRV-7", "FW-1")
@pytest.mark.parametrize("processor", PROCESSORS)
@pytest.mark.parametrize("profile", range(len(bench.PROFILES)))
def test_arithmetic_equals_native(native, processor, profile):
    for ticks in (1, 2, TICKS):
        assert PROCESSORS[processor](profile, ticks) == native(profile, ticks)


@pytest.mark.req("FW-1")
def test_pd_of_six_axes_takes_0_26_ms_at_most(native):
    """Ideal cache; with the gains that ship, which the image has a copy of."""
    source = (ROOT / "firmware" / "ports" / "bench.c").read_text()
    table = source[source.index("puma[AXES][4] = {") :].split(";")[0].split("=")[1]
    robot = tomllib.loads((ROOT / "sim" / "robots" / "puma560.toml").read_text())
    shipped = [(axis["servo"]["pd_1000us"] + [0])[:4] for axis in robot["axis"]]
    assert [int(n) for n in re.findall(r"-?\d+", table)] == sum(shipped, [])
    for profile, name in enumerate(bench.PROFILES):
        if name.startswith("PD") and "32 bits" not in name:
            _, cycles, _ = bench.on_68020(profile, 100)
            assert cycles / bench.MHZ <= 260, name
