# SPDX-License-Identifier: Apache-2.0
"""Names for numbers in a trace: registers by VME address, parts of a servo pass."""

import re
from pathlib import Path

from mmcs import ROOT, regs

PHASES = ("stopped", "program", "enter", "read", "compute", "write", "publish")


def registers() -> dict[int, str]:
    """By A15-A01 of the VMEbus: every register of the adaptor and of 16 cards."""
    own = ("PIT0", "PIT1", "PIT2", "PIT_CONTROL", "PCCSR", "VECTOR")
    found = {(regs.WINDOW_BASE + getattr(regs, name)) >> 1: name for name in own}
    numbers = {n: v for n, v in vars(regs).items() if re.match(r"CARD_[A-Z0-9_]*$", n)}
    fields = re.compile(r"_(BM|BP|GC)$")
    for card in range(regs.CARDS_MAX):
        for name, number in numbers.items():
            if not fields.search(name):
                address = (regs.WINDOW_BASE + regs.card_offset(card, number)) >> 1
                found.setdefault(address, f"{card}:{name.removeprefix('CARD_')}")
    return found


def states(module: str) -> dict[int, str]:
    """Of the state machine that a module of rtl/ is: number and name."""
    text = next((ROOT / "rtl").rglob(f"{module}.sv")).read_text()
    body = re.search(r"typedef enum[^{]*\{(.*?)\} *state_e;", text, flags=re.S)[1]
    names = re.findall(r"\w+", re.sub(r"//.*", "", body))
    return dict(enumerate(name.removeprefix("St").lower() for name in names))


TABLES = {"registers": registers, "phases": lambda: dict(enumerate(PHASES))}


def write_tables(folder: Path) -> None:
    """One file for each table, as GTKWave's translation wants it: number in hex, name."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in TABLES.items():
        digits = 4 if name == "registers" else 1
        lines = [f"{number:0{digits}x} {text}" for number, text in sorted(table().items())]
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n")
