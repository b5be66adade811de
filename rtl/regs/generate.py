# SPDX-License-Identifier: Apache-2.0
"""Writes what follows from rtl/regs/mmcs.rdl: SystemVerilog, C, JavaScript and documentation."""

import argparse
import json
import sys
from pathlib import Path

from systemrdl import RDLCompileError, RDLCompiler
from systemrdl.node import RegNode

ROOT = Path(__file__).resolve().parent.parent.parent
RDL = ROOT / "rtl" / "regs" / "mmcs.rdl"
SPDX = "SPDX-License-Identifier: Apache-2.0"
ORIGIN = "Generated from rtl/regs/mmcs.rdl by rtl/regs/generate.py; do not edit."

# Facts about the window that are no registers: name, value, why.
FACTS = [
    ("WINDOW_BASE", 0x6000, "A16 address of the window as shipped (jumpers A15-A11)"),
    ("WINDOW_SIZE", 0x800, "its length in bytes"),
    ("CARDS_MAX", 16, "cards on one PC bus"),
    ("PCCSR_BASE_CARDS", 0x18, "PCCSR BASE that reaches the cards: PC address 0x300"),
    ("PPI_MODE_BOARD", 0x89, "PPI mode word of the board: A and B out, C in"),
]


class Register:
    """One register: its name and address in the view it belongs to, and its RDL node."""

    def __init__(self, node: RegNode, prefix: str, address: int):
        self.name = prefix + node.inst_name
        self.address = address
        self.node = node
        self.title = node.get_property("name")
        self.desc = node.get_property("desc") or ""
        self.fields = sorted(node.fields(), key=lambda f: (-f.high, f.inst_name))

    def access(self) -> str:
        kinds = {f.get_property("sw").name for f in self.fields}
        return "rw" if "rw" in kinds or {"r", "w"} <= kinds else kinds.pop()

    def reset(self) -> str:
        values = [(f.get_property("reset"), f.low) for f in self.fields]
        if any(value is None for value, _ in values):
            return "undefined"
        total = 0
        for value, low in values:
            total |= value << low
        return f"0x{total:02X}"


def masks(reg: Register) -> list[tuple[str, int, str]]:
    """All constants of the fields of a register: name, value, comment."""
    out = []
    for field in reversed(reg.fields):
        stem = f"{reg.name}_{field.inst_name}"
        note = (field.get_property("desc") or "").rstrip(".")
        out.append((f"{stem}_bm", ((1 << field.width) - 1) << field.low, note))
        out.append((f"{stem}_bp", field.low, ""))
        encode = field.get_property("encode")
        for member in encode or ():
            text = (member.rdl_desc or "").rstrip(".")
            out.append((f"{stem}_{member.name}_gc", member.value << field.low, text))
    return out


def load() -> tuple[list[Register], list[Register], list[Register]]:
    """The registers of a card (PC offsets), of the adaptor (window offsets), and the formats."""
    compiler = RDLCompiler()
    compiler.compile_file(str(RDL))
    top = compiler.elaborate("mmcs").top
    card, adaptor = [], []
    for child in top.children(unroll=False):
        if isinstance(child, RegNode):
            adaptor.append(Register(child, "", child.address_offset))
        else:
            for reg in child.registers(unroll=False):
                card.append(Register(reg, "CARD_", (reg.address_offset - 1) // 2))
    compiler = RDLCompiler()
    compiler.compile_file(str(RDL))
    words = [Register(r, "", r.address_offset) for r in compiler.elaborate("words").top.registers()]
    return card, adaptor, words


def to_c(card, adaptor, words) -> str:
    def line(name, value, digits, note=""):
        text = f"#define MMCS_{name} 0x{value:0{digits}X}u"
        return f"{text} /* {note} */" if note else text

    out = [
        f"/* {SPDX} */",
        "/* The registers of the MMCS, §4.3 and §5.3. */",
        f"/* {ORIGIN} */",
        "#ifndef MMCS_REGS_H",
        "#define MMCS_REGS_H",
        "",
        "#include <stdint.h>",
        "",
        "/* The window. */",
    ]
    out += [line(name, value, 2, note) for name, value, note in FACTS]
    out += [
        "",
        "/* Window offset of register `reg` (MMCS_CARD_...) of card 0-15. */",
        "#define MMCS_CARD_OFFSET(card, reg) \\",
        "  ((uint16_t)((((unsigned)(card)) << 6) | (((unsigned)(reg)) << 1) | 1u))",
        "",
        "/* Adaptor registers: window offsets. */",
    ]
    for group, digits in ((adaptor, 3), (card, 2)):
        if group is card:
            out.append("/* Card registers: offsets on the PC bus, for MMCS_CARD_OFFSET. */")
        out += [line(r.name, r.address, digits, r.title) for r in group]
        out.append("")
    out.append("/* Bits: _bm mask, _bp lowest bit, _gc value in place. */")
    for reg in [*adaptor, *card, *words]:
        found = masks(reg)
        if len(reg.fields) == 1 and reg.fields[0].width == 8:
            continue
        for name, value, note in found:
            out.append(
                f"#define MMCS_{name} {value}u"
                if name.endswith("_bp")
                else line(name, value, 2, note)
            )
        out.append("")
    out += ["#endif", ""]
    return "\n".join(out)


def to_sv(card, adaptor, words) -> str:
    out = [
        f"// {SPDX}",
        "// The registers of the MMCS as constants. §4.3, §5.3",
        f"// {ORIGIN}",
        "`default_nettype none",
        "",
        "/* verilator lint_off UNUSEDPARAM */  // each user needs a few of them",
        "package mmcs_regs_pkg;",
        "",
        "  // Adaptor registers: offsets in the VME window.",
    ]
    out += [f"  localparam logic [10:0] {r.name} = 11'h{r.address:03X};" for r in adaptor]
    for reg in adaptor:
        if reg.reset() != "undefined":
            value = int(reg.reset(), 16)
            out.append(f"  localparam logic [7:0] {reg.name}_RESET = 8'h{value:02X};")
    out += ["", "  // Card registers: A4-A0 on the PC bus."]
    out += [f"  localparam logic [4:0] {r.name} = 5'h{r.address:02X};" for r in card]
    out += ["", "  // Lowest bit of each field."]
    for reg in [*adaptor, *card, *words]:
        if len(reg.fields) == 1 and reg.fields[0].width == 8:
            continue
        for field in reversed(reg.fields):
            out.append(f"  localparam int {reg.name}_{field.inst_name} = {field.low};")
    out += [
        "",
        "  // PCCSR BASE that reaches the cards: PC A9-A5 of address 0x300.",
        "  localparam logic [4:0] CARD_SELECT = 5'h18;",
        "",
        "endpackage",
        "/* verilator lint_on UNUSEDPARAM */",
        "",
        "`default_nettype wire",
        "",
    ]
    return "\n".join(out)


def field_table(reg: Register) -> list[str]:
    out = ["", "| bits | name | access | meaning |", "|---|---|---|---|"]
    for f in reg.fields:
        bits = f"{f.high}" if f.width == 1 else f"{f.high}–{f.low}"
        out.append(
            f"| {bits} | `{f.inst_name}` | {f.get_property('sw').name} "
            f"| {f.get_property('desc') or ''} |"
        )
    return [*out, ""]


def describe(reg: Register) -> str:
    return f"{reg.title}. {reg.desc}".strip()


def to_docs(card, adaptor, words) -> str:
    out = [
        "# Registers",
        "",
        f"*{ORIGIN}*",
        "",
        "Offsets count bytes in the adaptor's 2 KiB window (A16 address 0x6000 as shipped). Only",
        "odd bytes answer. SYSRESET\\* clears `PCCSR` and no other register of the adaptor.",
        "",
        "## Adaptor (§4.3.3)",
        "",
        "| offset | name | access | power on | what |",
        "|---|---|---|---|---|",
    ]
    out += [
        f"| 0x{r.address:03X} | `{r.name}` | {r.access()} | {r.reset()} | {describe(r)} |"
        for r in adaptor
    ]
    out += [
        "",
        "## Mark I card (§5.3.1)",
        "",
        "A card's register `reg` is at window offset `(card << 6) | (reg << 1) | 1`, and at PC",
        "address `0x300 | (card << 10) | reg`. Offsets not listed read 0xFF and ignore writes.",
        "",
        "| register | card 0 in the window | name | access | what |",
        "|---|---|---|---|---|",
    ]
    out += [
        f"| 0x{r.address:02X} | 0x{(r.address << 1) | 1:03X} | `{r.name}` | {r.access()} "
        f"| {describe(r)} |"
        for r in card
    ]
    out += ["", "## Bits", ""]
    for reg in [*adaptor, *card, *words]:
        if len(reg.fields) == 1 and reg.fields[0].width == 8:
            continue
        out += [f"### {reg.name}: {reg.title}"]
        if reg.desc:
            out += ["", reg.desc]
        out += field_table(reg)
    return "\n".join(out).rstrip() + "\n"


def to_js(card, adaptor, words) -> str:
    """A table for the page's register view; fields with more than one meaning by their first."""

    def row(reg: Register, of_card: bool) -> str:
        ways = {f.get_property("sw").name for f in reg.fields}
        fields = [
            {"name": f.inst_name, "low": f.low, "width": f.width,
             "readable": f.get_property("sw").name != "w"}
            for f in reg.fields
        ]  # fmt: skip
        entry = {
            "name": reg.name, "offset": reg.address, "card": of_card, "text": reg.title,
            "readable": bool(ways & {"r", "rw"}), "writable": bool(ways & {"w", "rw"}),
            "fields": fields,
        }  # fmt: skip
        return f"  {json.dumps(entry)},"

    out = [f"// {SPDX}", "// The registers of the MMCS for the page.", f"// {ORIGIN}", ""]
    out += ["export const REGISTERS = ["]
    out += [row(reg, False) for reg in adaptor] + [row(reg, True) for reg in card] + ["];", ""]
    return "\n".join(out)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; name a stale file")
    check = parser.parse_args().check
    try:
        views = load()
    except RDLCompileError:
        print(f"generate: {RDL} is not valid SystemRDL; see the lines above", file=sys.stderr)
        return 2
    files = {
        ROOT / "rtl/regs/mmcs_regs_pkg.sv": to_sv(*views),
        ROOT / "firmware/include/mmcs_regs.h": to_c(*views),
        ROOT / "docs/hardware/registers.md": to_docs(*views),
        ROOT / "web/registers_table.js": to_js(*views),
    }
    for path, text in files.items():
        if check and (not path.is_file() or path.read_text() != text):
            name = path.relative_to(ROOT)
            print(f"generate: {name} is stale; run `make generate`", file=sys.stderr)
            return 1
        if not check:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
