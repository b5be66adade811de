# SPDX-License-Identifier: Apache-2.0
"""What the two tables of the machine say, in its other places: `make generate`.

sim/abi/inputs.def: inputs of [[event]], in the manual. firmware/include/requests.def: requests, in
mcdef.h and the manual. mcdef.h: the names of its fields, in sim/service; those of mc_param, modes,
flags and errors, in the page. bfm: the rows of the data sheets, in their page.
"""

import argparse
import json
import re
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from cocotbext.conformance import CHIPS  # noqa: E402

from mmcs import inputs, mcdef  # noqa: E402
from tools.pages import between, splice  # noqa: E402

HEADER = ROOT / "firmware" / "include" / "mcdef.h"
DRIVER = ROOT / "docs" / "use" / "driver.md"
NAMES = ROOT / "sim" / "service" / "asked.h"
PAGE = ROOT / "web" / "params.js"
SCENARIOS = ROOT / "docs" / "use" / "scenarios.md"
SHEETS = ROOT / "docs" / "hardware" / "conformance.md"
SIZES = {"int": "MC_INT", "unsigned int": "MC_INT", "struct mc_param": "MC_PARAM",
         "struct mc_stats": "MC_STATS", "-": ""}  # fmt: skip
WAYS = {"none": (), "in": ("MC_ARG_IN",), "out": ("MC_ARG_OUT",),
        "both": ("MC_ARG_IN", "MC_ARG_OUT")}  # fmt: skip


def requests() -> list[mcdef.Request]:
    return sorted(mcdef.requests().values(), key=lambda request: request.number)


def defines() -> str:
    """Those of mcdef.h, as clang-format lays them out."""
    rows = []
    for r in (r for r in requests() if r.number < 64):
        parts = [*WAYS[r.way], *filter(None, [SIZES[r.argument]]), "MC_GROUP", str(r.number)]
        told = "none" if r.argument == "-" else r.argument
        rows.append((f"#define {r.name} ({' | '.join(parts)})", f"/* {told} */"))
    width = max(len(code) for code, _ in rows)
    return "\n".join(f"{code:{width}} {told}" for code, told in rows)


def names() -> str:
    """Those of the fields of mcdef.h, for the messages."""
    lines = []
    for structure in ("state", "param", "stats"):
        name = f"constexpr const char *k{structure.title()}[] = {{"
        words = ", ".join(f'"{field}"' for field in mcdef.fields(f"mc_{structure}"))
        lines += textwrap.wrap(f"{name}{words}}};", 100, subsequent_indent="    ")
    return "\n".join(lines)


def page_numbers() -> str:
    """What the page needs of mcdef.h."""
    known = mcdef.constants()
    modes = {name.removeprefix("MD_").lower(): known[name] for name in mcdef.MODES.values()}
    flags = {name.upper(): known[name.upper()] for name in mcdef.FLAGS}
    errors = {name: known[f"MERR_{name}"] for name in ("PLO", "PHI", "ILIM", "PANIC", "ZINDEX")}
    fields = [name for name in mcdef.fields("mc_param") if name != "which"]
    values = {"MODES": modes, "MODE_MASK": known["MD_MASK"], "FLAGS": flags, "ERRORS": errors,
              "FIELDS": fields, "MC_FSCALE": known["MC_FSCALE"]}  # fmt: skip
    lines = []
    for name, value in values.items():
        code = re.sub(r"^{(.*)}$", r"{ \1 }", json.dumps(value))
        lines += textwrap.wrap(f"export const {name} = {code};", 100, subsequent_indent="  ")
    return "\n".join(lines)


def driver_table() -> str:
    lines = ["| request | argument | | what it does, and errors |", "|---|---|---|---|"]
    for r in requests():
        kind = "called" if r.called else "" if r.changes else "get"
        lines.append(f"| {r.name} | {r.argument} | {kind} | {r.meaning} |")
    return "\n".join(lines)


def sheets() -> str:
    """Ports and rows of each chip of the conformance kit."""
    lines = []
    for chip, kind in CHIPS.items():
        both = kind(kind.VARIANTS[-1]).ports()
        inputs, outputs = ([f"`{name}`" + f" [{width}]" * (width > 1) for name, width in p.values()]
                           for p in both)  # fmt: skip
        variants = ", ".join(f"`{name}`" for name in kind.VARIANTS if name)
        sheet = kind.SHEET + f". Variants: {variants}" * bool(variants) + "."
        lines += [f"## {chip}", "", sheet, ""]
        lines += [f"Inputs: {', '.join(inputs)}. Outputs: {', '.join(outputs)}.", ""]
        lines += ["| section | rows |", "|---|---|"]
        for section in dict.fromkeys(row.section for row in kind.ROWS):
            rows = [row.words + f" ({', '.join(row.only)})" * bool(row.only)
                    for row in kind.ROWS if row.section == section]  # fmt: skip
            lines.append(f"| {section} | {'; '.join(rows)} |")
        lines.append("")
    return "\n".join(lines)


def pages() -> dict[Path, str]:
    """Each file as it should be."""
    begin, end = "/* generated: requests of requests.def */\n", "/* end of requests */"
    fields = "// generated: fields of mcdef.h\n", "// end of fields"
    numbers = "// generated: numbers of mcdef.h\n", "// end of numbers"
    return {
        HEADER: between(HEADER.read_text(), begin, end, defines()),
        DRIVER: splice(DRIVER.read_text(), "requests", driver_table()),
        NAMES: between(NAMES.read_text(), *fields, names()),
        PAGE: between(PAGE.read_text(), *numbers, page_numbers()),
        SHEETS: splice(SHEETS.read_text(), "rows", sheets()),
        SCENARIOS: splice(SCENARIOS.read_text(), "inputs", inputs.table()),
    }


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for path, whole in pages().items():
        path.write_text(whole)
