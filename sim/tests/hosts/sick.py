# SPDX-License-Identifier: Apache-2.0
"""Firmware that goes wrong in the middle of a run, for the 68020."""

import contextlib
from pathlib import Path

from mmcs import ROOT, RunError, Session, hosts, machine
from tools.compiled import compiled, ran, written

PASSES = 150  # the firmware goes wrong in this one
FIRMWARE = ROOT / "firmware"
COMMON = ["-O2", "-ffreestanding", "-fno-tree-loop-distribute-patterns", "-nostdlib", "-static",
          "-w", *(f"-I{FIRMWARE / d}" for d in ("mc", "include", "ports"))]  # fmt: skip
PORT, PREFIX = "m68020", "m68k-linux-gnu"
GCC = [f"{PREFIX}-gcc", "-m68020", "-msoft-float", "-fno-pic", "-Wl,--build-id=none", *COMMON]


def sick_firmware(statement: str, folder: Path) -> Path:
    """The firmware whose servo interrupt executes the statement once, in pass PASSES."""
    renamed = FIRMWARE / "mc" / "interrupt.c"
    inner = compiled(f"{PORT}_inner.o", [*GCC, "-Dmc_interrupt=sane", "-c"], [renamed])
    wrong = written(
        "wrong.c",
        f"int sane(void *);\nint mc_interrupt(void *mc);\nint mc_interrupt(void *mc) {{\n"
        f"  static int n;\n  if (++n == {PASSES}) {{ {statement} }}\n  return sane(mc);\n}}\n",
    )
    sources = sorted(f for f in (FIRMWARE / "mc").glob("*.c") if f != renamed)
    sources += [FIRMWARE / "ports" / name for name in ("port.c", "memory.c", f"{PORT}/start.S")]
    gcc = [*GCC, "-DIMAGE_mc", "-DENTRY=port_main", "-DFATAL=port_dead"]
    after = [inner, "-lgcc", "-T", FIRMWARE / "ports" / PORT / "link.ld"]
    elf, image = compiled(f"{PORT}_sick.elf", gcc, [*sources, wrong], after), folder / "mc.bin"
    ran(f"{PREFIX}-objcopy", "-O", "binary", elf, image, check=True)
    return image


def notes_of_sick(statement: str, setup, folder: Path, monkeypatch) -> list[dict]:
    """The events of a run on this firmware; its last requests may get no answer."""
    image = str(sick_firmware(statement, folder))
    config = hosts.config(PORT) | {"firmware": image}
    monkeypatch.setattr(hosts, "config", lambda host: config)
    with machine(setup, host=PORT) as sim:
        with contextlib.suppress(RunError, OSError):
            Session(sim, setup).run(lambda *_: None)
        return sim.notes()
