# SPDX-License-Identifier: Apache-2.0
"""A LiteX SoC with one card, to be simulated: writes its Verilog, its headers and its firmware.

.venv/bin/python bridges/litex/soc.py build/litex
"""

import contextlib
import shutil
import subprocess
import sys
from pathlib import Path

try:
    from litex.build.generic_platform import GenericPlatform, Pins
except ImportError:
    sys.exit(
        "mmcs: LiteX is not installed; `make litex-test` installs it, or pip install -e .[litex]"
    )
from litex.build.io import CRG
from litex.soc.integration import export
from litex.soc.integration.common import get_mem_data
from litex.soc.integration.soc import SoCRegion
from litex.soc.integration.soc_core import SoCCore
from migen import Constant
from mmcs_litex import MMCS, ROOT

CLK_HZ = 8_000_000
GCC = "riscv64-unknown-elf-gcc"
HERE = Path(__file__).resolve().parent
SAFETY = ("estop_closed", "pc_power")
PINS = {"enc_a": 2, "enc_b": 2, "enc_i": 2, "axis_enable": 2, "drive_v": 32, "card_leds": 11,
        "sclock": 1, "brake_release": 1, "alive": 1, "clk": 1, "rst": 1}  # fmt: skip


class Platform(GenericPlatform):
    def __init__(self):
        super().__init__(
            "sim",
            [(n, 0, Pins(w)) for n, w in (PINS | dict.fromkeys(SAFETY, 1)).items()],
            name="soc",
        )


class Soc(SoCCore):
    def __init__(self, image: list | None = None):
        platform = Platform()
        super().__init__(
            platform, CLK_HZ, cpu_type="vexriscv", cpu_variant="standard", with_uart=False,
            with_timer=False, integrated_rom_size=0xC000, integrated_rom_init=image or [],
            integrated_sram_size=0x8000, ident="MMCS", ident_version=False,
        )  # fmt: skip
        self.crg = CRG(platform.request("clk"), platform.request("rst"))
        pins = {name: platform.request(name) for name in SAFETY}
        self.mmcs = MMCS(platform, CLK_HZ, cable_ok=Constant(1), **pins)  # the cards are inside
        self.bus.add_slave("mmcs", self.mmcs.bus, SoCRegion(size=MMCS.SIZE, cached=False))
        self.irq.add("mmcs")
        for name in ("enc_a", "enc_b", "enc_i", "axis_enable"):
            self.comb += getattr(self.mmcs, name).eq(platform.request(name))
        for name in ("drive_v", "card_leds", "sclock", "brake_release", "alive"):
            self.comb += platform.request(name).eq(getattr(self.mmcs, name))


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


def make(folder: Path) -> list[Path]:
    """Everything into the folder; the sources to simulate, top module soc."""
    folder.mkdir(parents=True, exist_ok=True)
    first = Soc()
    first.finalize()
    image = compile_firmware(first, folder)
    soc = Soc(get_mem_data(str(image), data_width=32, endianness="little"))
    text = soc.platform.get_verilog(soc, name="soc")
    with contextlib.chdir(folder):  # memories are written where one is
        text.write("soc.v")
    return [folder / "soc.v", *(Path(s[0]) for s in soc.platform.sources)]


if __name__ == "__main__":
    if not shutil.which(GCC):
        sys.exit(f"mmcs: {GCC} is missing; sudo apt-get install gcc-riscv64-unknown-elf")
    print("\n".join(map(str, make(Path(sys.argv[1] if len(sys.argv) > 1 else "build/litex")))))
