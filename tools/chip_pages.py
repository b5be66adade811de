# SPDX-License-Identifier: Apache-2.0
"""Writes "Use it alone" into the chips' pages: ports (from the RTL), tie-offs, a bench."""

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tools.pages import splice  # noqa: E402

PAGES = ROOT / "docs" / "hardware" / "chips"
BENCHES = PAGES.relative_to(ROOT)
TIES = {
    "ad574": "`mode12_i` at 1 gives all bits at once, `span10_i` at 0 is ±10 V; with `cs_ni` at 0,"
    " `ce_i` alone starts and reads.",
    "ad667": "Without a double-buffering host pull `a_ni[3]` low together with the last byte.",
    "i8254": "`clkN_rise_i` and `clkN_fall_i` both at 1 make CLK N the system clock, both at 0 stop"
    " it; `gate_i` at 3'b111 lets all count.",
    "i8255": "Ports that are not inputs may be tied to 0; `p*_oe_o` tells which pins it drives.",
    "oneshot": "`clr_ni` at 1.",
    "thct2000": "`clk_en_i` at 1 counts at the system clock; `latch_i` at 0 if nobody latches,"
    " `other_i` at 0 on a bus of its own; `m_i` at 5 counts every edge.",
}


def ports(name: str) -> list[tuple[str, str, str, str]]:
    """(name, direction, width, comment) of every port, in the order of the module."""
    text = (ROOT / "rtl" / "chips" / f"{name}.sv").read_text()
    body = re.search(rf"^module {name}\b.*?^\);", text, re.M | re.S)[0]
    line = re.compile(
        r"^  (input|output) +(?:wire +)?logic( +signed)? *(\[[^]]+\])? *(\w+) *,? *(?://(.*))?$",
        re.M,
    )
    return [
        (port, kind, re.sub(r"\s", "", width or "") + (signed or ""), (comment or "").strip())
        for kind, signed, width, port, comment in line.findall(body)
    ]


def files(name: str) -> str:
    inner = "rtl/chips/i8254_counter.sv " if name == "i8254" else ""
    return f"{inner}rtl/chips/{name}.sv"


def section(name: str) -> str:
    rows = [f"| `{port}` | {kind} | {width} | {text} |" for port, kind, width, text in ports(name)]
    bench = (PAGES / f"{name}_tb.sv").read_text().split("\n", 1)[1]
    return "\n".join([
        "| port | | width | |", "|---|---|---|---|", *rows, "",
        f"**Tie-offs.** {TIES[name]} Outputs may stay open.", "",
        "```sh",
        f"iverilog -g2012 -Irtl -s {name}_tb {files(name)} {BENCHES}/{name}_tb.sv && vvp a.out",
        "```", "", "```systemverilog", bench.rstrip(), "```", "",
    ])  # fmt: skip


def page(name: str, text: str) -> str:
    return splice(text, "alone", section(name))


def names() -> list[str]:
    return sorted(path.stem.removesuffix("_tb") for path in PAGES.glob("*_tb.sv"))


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for chip in names():
        path = PAGES / f"{chip}.md"
        path.write_text(page(chip, path.read_text()))
