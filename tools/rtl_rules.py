# SPDX-License-Identifier: Apache-2.0
"""Rules for rtl/ and fpga/ but their checkers and benches. No name serves a simulator: speed and
faults come from outside. `always_ff` holds reset and `q <= d`: what decides stands before it. A
flip-flop that a pin clocks has an initial value: a reset that is low from time 0 has no edge, and
the pin may have none for ever.
"""

import re
from pathlib import Path

PLACES = ("rtl/**/*.sv", "rtl/*.svh", "fpga/**/*.sv")
BENCHES = "tests"  # a folder of fpga/ that is no hardware
CHECKERS = "rtl/checkers/"

# A whole part of a name, between its underscores or capitals.
FOREIGN = re.compile(
    r"(?<![a-z])([Ss]kip|[Ss]leep|asleep|awake|horizon|fault|stuck|absent|lost|inject)s?(?![a-z])"
)
CLOCKS = {"clk_i", "clk", "pclk"}
FLIP_FLOPS = re.compile(r"always_ff @\(\w+ (\w+)(.*?)\n\n", re.S)  # clock, the rest of the block
DECIDES = re.compile(r"\b(case|for)\b|else if|<=.*([?&|^~+!=<>]|[\w)] - )")


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
        if name.startswith(CHECKERS) or BENCHES in file.relative_to(root).parts:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            code = re.sub(r'"[^"]*"', "", line.partition("//")[0])
            if word := FOREIGN.search(code):
                found.append(f"{name}:{number}: {word[0]}: of a simulator: make it outside of rtl/")
        for number in deciding(text):
            found.append(f"{name}:{number}: next state within always_ff: a net of its own decides")
        for net in without_value(text):
            found.append(f"{name}: {net}: a pin clocks it: give it an initial value as well")
    return found
