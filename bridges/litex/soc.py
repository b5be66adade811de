# SPDX-License-Identifier: Apache-2.0
"""A LiteX SoC with one card and our driver in ROM. As a program: to be simulated, all its files.

.venv/bin/python bridges/litex/soc.py build/litex
"""

import contextlib
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

try:
    from litex.build.generic_platform import GenericPlatform, Pins
except ImportError:
    sys.exit(
        "mmcs: LiteX is missing; `make litex-test` installs it, or pip install './bridges[litex]'"
    )
from litex.build.io import CRG
from litex.soc.integration import export
from litex.soc.integration.common import get_mem_data
from litex.soc.integration.soc import SoCRegion
from litex.soc.integration.soc_core import SoCCore
from migen import Constant
from mmcs_litex import MMCS, ROOT

CLK_HZ = 24_000_000
GCC = "riscv64-unknown-elf-gcc"
HERE = Path(__file__).resolve().parent
SAFETY = ("estop_closed", "pc_power")
INPUTS = ("enc_a", "enc_b", "enc_i", "axis_enable")
OUTPUTS = ("drive_v", "card_leds", "sclock", "brake_release", "alive")
PINS = {"enc_a": 2, "enc_b": 2, "enc_i": 2, "axis_enable": 2, "drive_v": 32, "card_leds": 11,
        "sclock": 1, "brake_release": 1, "alive": 1, "clk": 1, "rst": 1}  # fmt: skip


class Soc(SoCCore):
    """A VexRiscv, 48 KiB of ROM, 32 KiB of SRAM, one card. crg: makes the clock domain "sys";
    safety: the pins of mmcs_litex.MMCS."""

    def __init__(self, platform, crg, image: list | None = None, **safety):
        super().__init__(
            platform, CLK_HZ, cpu_type="vexriscv", cpu_variant="standard", with_uart=False,
            with_timer=False, integrated_rom_size=0xC000, integrated_rom_init=image or [],
            integrated_sram_size=0x8000, ident="MMCS", ident_version=False,
        )  # fmt: skip
        self.crg = crg
        self.mmcs = MMCS(platform, CLK_HZ, **safety)
        self.bus.add_slave("mmcs", self.mmcs.bus, SoCRegion(size=MMCS.SIZE, cached=False))
        self.irq.add("mmcs")


def simulated(image: list | None = None) -> Soc:
    """All of the card's pins are the top's; the cards are inside, so that no cable is needed."""
    wanted = PINS | dict.fromkeys(SAFETY, 1)
    platform = GenericPlatform("sim", [(n, 0, Pins(w)) for n, w in wanted.items()], name="soc")
    crg = CRG(platform.request("clk"), platform.request("rst"))
    pins = {name: platform.request(name) for name in SAFETY}
    soc = Soc(platform, crg, image, cable_ok=Constant(1), **pins)
    soc.comb += [getattr(soc.mmcs, name).eq(platform.request(name)) for name in INPUTS]
    soc.comb += [platform.request(name).eq(getattr(soc.mmcs, name)) for name in OUTPUTS]
    return soc


def compile_firmware(soc: Soc, folder: Path) -> Path:
    """Our driver and main.c, with the headers that LiteX writes."""
    generated = folder / "generated"
    generated.mkdir(parents=True, exist_ok=True)
    (generated / "mem.h").write_text(export.get_mem_header(soc.mem_regions))
    (generated / "soc.h").write_text(export.get_soc_header(soc.constants))
    (generated / "csr.h").write_text(
        export.get_csr_header(soc.csr_regions, soc.constants, with_access_functions=False)
    )
    firmware = ROOT / "firmware"
    files = [HERE / "start.S", HERE / "main.c", firmware / "ports/window.c"]
    files += [firmware / "ports/memory.c", *sorted((firmware / "mc").glob("*.c"))]
    include = [f"-I{d}" for d in (folder, *(firmware / d for d in ("include", "mc", "ports")))]
    gcc = [GCC, "-march=rv32im", "-mabi=ilp32", "-Os", "-std=gnu11",
           "-ffreestanding", "-nostdlib", "-static", "-fno-builtin", "-ffunction-sections",
           "-fno-tree-loop-distribute-patterns", "-Wl,--gc-sections,--build-id=none",
           "-DSERVO_NARROW", "-T", str(HERE / "link.ld")]  # fmt: skip
    elf, image = folder / "main.elf", folder / "main.bin"
    subprocess.run([*gcc, *include, "-o", str(elf), *map(str, files), "-lgcc"], check=True)
    subprocess.run(
        ["riscv64-unknown-elf-objcopy", "-O", "binary", str(elf), str(image)], check=True
    )
    return image


def with_firmware(make: Callable[..., Soc], folder: Path) -> Soc:
    """The SoC with its program: made for LiteX's headers, then again with what they compile."""
    if not shutil.which(GCC):
        sys.exit(f"mmcs: {GCC} is missing; sudo apt-get install gcc-riscv64-unknown-elf")
    folder.mkdir(parents=True, exist_ok=True)
    first = make()
    first.finalize()
    image = compile_firmware(first, folder)
    return make(get_mem_data(str(image), data_width=32, endianness="little"))


def main(folder: Path) -> list[Path]:
    """Everything into the folder; the sources to simulate, top module soc."""
    soc = with_firmware(simulated, folder)
    text = soc.platform.get_verilog(soc, name="soc")
    with contextlib.chdir(folder):  # memories are written where one is
        text.write("soc.v")
    return [folder / "soc.v", *(Path(s[0]) for s in soc.platform.sources)]


if __name__ == "__main__":
    print("\n".join(map(str, main(Path(sys.argv[1] if len(sys.argv) > 1 else "build/litex")))))
