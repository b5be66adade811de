# SPDX-License-Identifier: Apache-2.0
"""What can be switched, or go wrong, during a run: the inputs that `event` entries name.

The one table of them is sim/abi/inputs.def, which the engine includes and this reads. After its
rows the engine has an upset of each register of the hardware.
"""

import csv
import re
from typing import NamedTuple

from mmcs.place import ROOT

TABLE = ROOT / "sim" / "abi" / "inputs.def"


class Input(NamedTuple):
    scope: str  # "machine", "card" or "axis": what `index` counts
    healthy: float  # its value when nothing is wrong
    low: float
    high: float
    meaning: str
    lasting: bool  # a state; else an act, which happens once
    draw: str  # what a campaign draws: "each", "bit", "1..100 whole", "none"
    sort: str  # the sort of fault that it is in a campaign
    made_by: str  # PIN, HOST, UPSET or PLANT
    code: str  # a Pin, an Action, the register, an Input of the plant

    def drawn(self) -> tuple[float, ...]:
        """The values that a campaign chooses from; none where it draws from a range."""
        if self.draw == "bit":
            return tuple(1 << n for n in range(int(self.high).bit_length()))
        values = range(int(self.low), int(self.high) + 1) if self.draw == "each" else ()
        return tuple(value for value in values if value != self.healthy)


def _number(text: str) -> float:
    return int(text) if re.fullmatch(r"-?\d+", text) else float(text)


def read_table(text: str) -> dict[str, Input]:
    """The rows of inputs.def by name, in order."""
    found = {}
    for made_by, row in re.findall(r"^(PIN|HOST|UPSET|PLANT)\((.*?)\)$", text, re.M | re.S):
        cells = next(csv.reader([" ".join(row.split())], skipinitialspace=True))
        code, name, scope, low, high, healthy, draw, sort, meaning = cells
        found[name] = Input(
            scope[1:].lower(), _number(healthy), _number(low), _number(high), meaning,
            made_by in ("PIN", "PLANT"), draw, sort, made_by, code,
        )  # fmt: skip
    return found


INPUTS = read_table(TABLE.read_text())
UPSET = "seu."  # then the name of any register, as `mmcs faults` lists them


def find(name: str) -> Input | None:
    """The input of this name; the engine knows which registers there are, and how wide."""
    if name.startswith(UPSET) and name not in INPUTS:
        meaning = "a particle flips these bits, once"
        high = 2**32 - 1
        return Input(
            "machine", 0, 0, high, meaning, False, "bit", "register", "UPSET", name[len(UPSET) :]
        )
    return INPUTS.get(name)


def table() -> str:
    """For the manual: docs/use/scenarios.md."""
    rows = [
        f"| `{name}` | {'' if i.scope == 'machine' else i.scope} | {i.low:g} to {i.high:g} "
        f"| {i.healthy:g} | {'state' if i.lasting else 'once'} | {i.meaning} |"
        for name, i in INPUTS.items()
    ]
    head = ["| input | index | values | healthy | effect | meaning |", "|---|---|---|---|---|---|"]
    return "\n".join(head + rows)
