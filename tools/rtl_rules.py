# SPDX-License-Identifier: Apache-2.0
"""rtl/ and fpga/ hold hardware only: no name and no comment there serves a simulator.

What is read, proved, covered, mutated and put on an FPGA is what runs; speed and faults come from
outside. rtl/checkers watches buses in simulation and may say so. `always_ff` holds reset and
`q <= d`: what decides stands before it. A flip-flop that a pin clocks has an initial value: a reset
that is low from time 0 has no edge, and the pin may have none for ever.
"""

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLACES = ("rtl/**/*.sv", "rtl/*.svh", "fpga/**/*.sv")
BENCHES = "tests"  # a folder of fpga/ that is no hardware
CHECKERS = "rtl/checkers/"
MAY_SAY = ("rtl/mmcs_assert.svh", "rtl/mmcs_require.svh")  # where a check of the hardware runs
NOT_OURS = {"double_fault_seen_o"}  # a pin of the processor core

# Parts of a name, between its underscores or capitals. `gate` alone is a pin of the 8254.
SPEED = {"skip", "skips", "skipping", "sleep", "sleeps", "sleeping", "asleep", "awake", "horizon",
         "extra", "stirs", "shakes", "settled", "due"}  # fmt: skip
FAULT = {"fault", "faults", "stuck", "absent", "lost", "inject", "injected"}
WHOLE = {"Gate": "clock gating", "clk_free": "a second clock", "clk_free_i": "a second clock",
         "dip_xor_i": "a fault", "dip_xor": "a fault"}  # fmt: skip
WORDS = re.compile(
    r"\b(simulat\w*|verilator|icarus|skipping|horizons?|asleep|gating|speed builds?)\b", re.I
)
LINT = re.compile(r"verilator lint_o\w+ \w+|__ICARUS__|verilator coverage_\w+")
NAME = re.compile(r"[A-Za-z_]\w*")
PART = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")

CLOCKS = {"clk_i", "clk", "pclk"}
FLIP_FLOPS = re.compile(r"always_ff @\(\w+ (\w+)(.*?)\n\n", re.S)  # clock, the rest of the block
DECIDES = re.compile(r"\b(case|for)\b|else if|<=.*([?&|^~+!=<>]|[\w)] - )")


def of_name(name: str) -> str | None:
    """Why a name may not stand in the hardware."""
    if name in NOT_OURS:
        return None
    if name in WHOLE:
        return WHOLE[name]
    parts = {part.lower() for part in PART.findall(name)}
    if parts & SPEED:
        return "speed of a simulator"
    if parts & FAULT or re.search(r"(sclock|panic|irq)_open", name):
        return "a fault"
    return None


def deciding(text: str) -> list[int]:
    """Lines within always_ff that hold more than reset and `q <= d`."""
    found, depth, resets = [], None, 0
    for number, line in enumerate(text.splitlines(), 1):
        code = line.partition("//")[0]
        indent = len(code) - len(code.lstrip())
        if "always_ff" in code:
            depth, resets = indent, 0
        elif depth is not None and code.strip():
            if indent < depth or (indent == depth and code.strip() != "end"):
                depth = None
                continue
            resets += len(re.findall(r"\bif\b", code))
            if resets > 1 or DECIDES.search(code):
                found.append(number)
    return found


def without_value(text: str) -> list[str]:
    """Flip-flops clocked by a pin that are declared without an initial value."""
    found = []
    for clock, block in FLIP_FLOPS.findall(text):
        nets = re.findall(r"\w+_q\b(?=[\w, }]*<=)", block) if clock not in CLOCKS else []
        found += [n for n in dict.fromkeys(nets) if not re.search(rf"\b{n} = ", text)]
    return found


def complaints(root: Path) -> list[str]:
    found = []
    for file in sorted({f for place in PLACES for f in root.glob(place)}):
        name, text = str(file.relative_to(root)), file.read_text()
        if BENCHES in file.relative_to(root).parts:
            continue
        for number in () if name.startswith(CHECKERS) else deciding(text):
            found.append(f"{name}:{number}: next state within always_ff: a net of its own decides")
        for net in () if name.startswith(CHECKERS) else without_value(text):
            found.append(f"{name}: {net}: a pin clocks it: give it an initial value as well")
        for number, line in enumerate(text.splitlines(), 1):
            code, _, comment = LINT.sub("", line).partition("//")
            code = re.sub(r'"[^"]*"', "", code)
            where = f"{name}:{number}"
            for word in NAME.findall(code):
                why = of_name(word)
                if why:
                    found.append(f"{where}: {word}: a name for {why}; make it outside of rtl/")
            said = WORDS.search(comment)
            if said and not name.startswith(CHECKERS) and name not in MAY_SAY:
                found.append(f"{where}: {said[0]}: hardware knows no simulator; say it elsewhere")
    return found


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    found = complaints(ROOT)
    for line in found:
        print(f"rtl rules: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
