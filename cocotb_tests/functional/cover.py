# SPDX-License-Identifier: Apache-2.0
"""Functional coverage: which combinations the tests have really driven and seen answered right.

A group is a cross of axes. `hit` marks one combination, after its check has passed, at the price of
a set insertion. `save` leaves functional.json in the directory of the simulation, where
tools/coverage.py finds it; the tool imports GROUPS too, so that a test that never ran is seen.
Report §4.3.1, §4.3.3, §4.3.4, §5.3.1.
"""

import json
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path

from mmcs import regs

FILE = "functional.json"
GROUPS: dict[str, "Group"] = {}


class Group:
    """Bins are tuples of strings, one of each axis; `never` names what cannot happen, and why."""

    def __init__(self, name: str, never: dict[str, Callable[..., bool]] | None = None, **axes):
        self.name = name
        self.never = never or {}
        self.axes = {key: tuple(str(v) for v in values) for key, values in axes.items()}
        self.hits: set[tuple[str, ...]] = set()
        GROUPS[name] = self

    def reason(self, combination: tuple[str, ...]) -> str | None:
        """Why a combination is no bin; None if it is one."""
        return next((why for why, test in self.never.items() if test(*combination)), None)

    def bins(self) -> Iterator[tuple[str, ...]]:
        return (c for c in product(*self.axes.values()) if not self.reason(c))

    def hit(self, *values) -> None:
        self.hits.add(tuple(map(str, values)))

    def strays(self) -> list[tuple[str, ...]]:
        """Hits that are no bins: the definition or the sampling is wrong."""
        legal = [set(values) for values in self.axes.values()]
        return [
            h
            for h in self.hits
            if len(h) != len(legal)
            or not all(v in ok for v, ok in zip(h, legal, strict=True))
            or self.reason(h)
        ]


def save() -> None:
    for group in GROUPS.values():
        assert not group.strays(), f"{group.name}: {group.strays()[:5]} are no bins"
    hits = {g.name: sorted("|".join(h) for h in g.hits) for g in GROUPS.values() if g.hits}
    Path(FILE).write_text(json.dumps(hits))


def load(folder: Path) -> None:
    """Adds what the simulations below a folder have left."""
    for path in folder.rglob(FILE):
        for name, hits in json.loads(path.read_text()).items():
            GROUPS[name].hits |= {tuple(h.split("|")) for h in hits}


# --- VME: §4.3.1-4.3.3 ----------------------------------------------------------------------------

SIZES = ("even", "odd", "word", "long")
KINDS = ("read", "write")
MODIFIERS = ("29", "2D")

# Every address of the window with every size of access, by both modifiers that are answered.
VME_ADDRESS = Group(
    "vme_address",
    word=[f"{a:03X}" for a in range(0, 0x800, 2)],
    size=SIZES,
    modifier=MODIFIERS,
    kind=KINDS,
)

# Every modifier, and who would be addressed.
TARGETS = {
    "card": regs.card_offset(0, regs.CARD_PPI_A),
    "other base": regs.card_offset(15, regs.CARD_PPI_A),
    "counter 0": regs.PIT0,
    "counter 1": regs.PIT1,
    "counter 2": regs.PIT2,
    "control": regs.PIT_CONTROL,
    "pccsr": regs.PCCSR,
    "hole": 0x411,
    "vector": regs.VECTOR,
    "mirror": 0x789,
}
VME_MODIFIER = Group(
    "vme_modifier",
    modifier=[f"{am:02X}" for am in range(64)],
    size=SIZES,
    target=TARGETS,
    kind=KINDS,
)

# Every 2 KiB of A16.
VME_SEGMENT = Group(
    "vme_segment", segment=[f"{s:02d}" for s in range(32)], size=SIZES, modifier=MODIFIERS
)

# --- the 8254: §4.3.4 -----------------------------------------------------------------------------

FORMATS = ("low", "low bcd", "high", "high bcd", "both", "both bcd")
PIT_EVENTS = (
    "control",  # a control word brings the counter here
    "control while counting",  # and takes it away, at every stage
    "control between the bytes of a count",
    "control between the bytes of a read",
    "control with the count latched",
    "count",  # the first whole count
    "count again before it is loaded",
    "count again while counting",
    "first byte while counting",
    "load",
    "latch",
    "latch again",
    "read-back count",
    "read-back status",
    "read-back both",
    "read live",
    "read latched",
    "read status, null count 1",
    "read status, null count 0",
    "read between the bytes of a count",
    "count between the bytes of a read",
    "gate falls",
    "gate rises",
    "out rises",
    "out falls",
    "counts through zero",
)


def _one_byte(code, form, event) -> bool:
    return not form.startswith("both") and (
        "between the bytes" in event or event.startswith("first byte")
    )


PIT = Group(
    "pit",
    never={
        "a count of one byte has no first": _one_byte,
        "mode 0 lowers OUT by the bus alone": lambda c, f, e: c == "0" and e == "out falls",
        "modes 2 and 3 reload before zero": lambda c, f, e: (
            c in "2367" and e == "counts through zero"
        ),
    },
    mode=range(8),  # as written: 6 and 7 are 2 and 3
    format=FORMATS,
    event=PIT_EVENTS,
)
PIT_COUNTER = Group("pit_counter", counter=range(3), event=PIT_EVENTS)

# --- PCCSR: §4.3.3, §4.3.6 ------------------------------------------------------------------------

# A state is bit 7, the enables 6 and 5, the latches of PANIC and SCLOCK.
PCCSR_EVENTS = (*[f"write {n:03b}" for n in range(8)], "sclock rises", "panic rises")
PCCSR = Group(
    "pccsr",
    never={"bit 7 = 0 holds the latches clear": lambda s, e: s[0] == "0" and s[3:] != "00"},
    state=[f"{n:05b}" for n in range(32)],
    event=PCCSR_EVENTS,
)
PCCSR_BASE = Group("pccsr_base", old=range(32), new=range(32))

# --- cards: §5.3.1 --------------------------------------------------------------------------------

CARD = Group("card", switches=range(16), addressed=range(16), kind=KINDS)
CARD_REGISTER = Group(
    "card_register", switches=range(16), register=[f"{r:02X}" for r in range(32)], kind=KINDS
)
