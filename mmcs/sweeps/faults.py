# SPDX-License-Identifier: Apache-2.0
"""What a campaign injects: a seed and a number make one fault, whatever ran before it.

A fault is an entry for the scenario's [[event]] or [[call]], so that `mmcs run` makes it, too.
"""

import random
import re
import shlex
from dataclasses import dataclass, field

from mmcs import mcdef
from mmcs.errors import toml
from mmcs.inputs import INPUTS, UPSET, find

SORTS = ("register", "line", "pin", "message", "kill")
SHORTEST_S, LONGEST_S = 50e-6, 50e-3  # of what passes by itself
DIGITS = 7  # of a time: less than a clock

CONTROL = {
    "vme_control": ("AS*", "DS0*", "DS1*", "WRITE*", "LWORD*", "IACK*", "IACKIN*"),
    "pc_control": ("IOR#", "IOW#"),
}
PINS, LINES, KILLS, MESSAGES = (
    tuple(name for name, i in INPUTS.items() if i.sort == sort and i.draw != "none")
    for sort in ("pin", "line", "kill", "message")
)
STUCK = tuple(name for name in LINES if INPUTS[name].draw == "bit")  # one line of a bus
PARAMETERS = ("a0", "a1", "b0", "b1", "ic_pos", "ic_neg", "ilim", "clkdivisor")
REQUESTS = tuple(request.name for request in mcdef.requests().values() if request.called)


@dataclass(frozen=True)
class Fault:
    """One fault in one motion: entries for the scenario, and what it is to be counted as."""

    n: int
    motion: str
    sort: str
    what: str  # register, input or request, without the number of card and axis
    at: float
    event: dict | None = None
    call: dict | None = None

    @property
    def lasts(self) -> bool:
        """It does not pass by itself."""
        return bool(self.event) and "until" not in self.event and find(self.event["input"]).lasting

    def sets(self, calls: list[dict]) -> list[str]:
        """For --set, beside the scenario's own calls."""
        if self.event:
            return ["event=" + toml([self.event])]
        return ["call=" + toml([*calls, self.call])]

    def command(self, calls: list[dict], typed: tuple[str, ...] = ()) -> str:
        words = [w for text in (*typed, *self.sets(calls)) for w in ("--set", text)]
        return shlex.join(["mmcs", "run", self.motion, *words])


@dataclass(frozen=True)
class Motion:
    """What faults can hit in a scenario: its registers, axes, cards, parameters."""

    name: str
    until: float  # faults begin before this, seconds of motion
    registers: tuple[tuple[str, int], ...]  # and their bits
    axes: int
    cards: int
    interval_us: int = 1000
    parameters: tuple[dict, ...] = field(default=())  # of the servo, per axis


def draw(seed: int, n: int, sorts: tuple[str, ...], motions: tuple[Motion, ...]) -> Fault:
    """Fault number n. Motions take turns, everything else is drawn."""
    dice = random.Random(f"{seed}/{n}")
    motion = motions[n % len(motions)]
    sort = dice.choice(sorts)
    at = round(dice.random() * motion.until, DIGITS)
    if sort == "message" and dice.random() < 0.75:
        return _request(dice, n, motion, at)
    if sort == "register":
        name, bit = _bit(dice, motion.registers)
        event = {"at": at, "input": UPSET + name, "value": 1 << bit}
        return Fault(n, motion.name, sort, plain(name), at, event=event)
    name = dice.choice({"pin": PINS, "line": LINES, "kill": KILLS, "message": MESSAGES}[sort])
    event = {"at": at, "input": name, "value": _value(dice, name)}
    count = {"machine": 1, "card": motion.cards, "axis": motion.axes}[find(name).scope]
    if count > 1:
        event["index"] = dice.randrange(count)
    if find(name).lasting and dice.random() < 0.5:
        event["until"] = round(at + _log(dice, SHORTEST_S, LONGEST_S), DIGITS)
    what = f"{name} {event['value'].bit_length() - 1}" if name in STUCK else name
    return Fault(n, motion.name, sort, what, at, event=event)


def plain(register: str) -> str:
    """The same name for every card and axis."""
    return re.sub(r"g_(card|axis)\[\d+\]\.", "", register).removeprefix("u_")


def line_name(what: str) -> str:
    """A line that is held, as it is called on its bus; other names as they are."""
    head, _, number = what.partition(" ")
    if head not in STUCK:
        return what
    bus, level = head.removesuffix("_stuck0").removesuffix("_stuck1"), head[-1]
    names = CONTROL.get(bus)
    kind = bus.partition("_")[2].upper()
    line = names[int(number)] if names else f"{kind}{int(number) + (bus == 'vme_a')}"  # no A0
    return f"{'ribbon' if bus.startswith('pc_') else 'VME'} {line} at {level}"


def _bit(dice: random.Random, registers) -> tuple[str, int]:
    """Every flip-flop is as likely as any other."""
    place = dice.randrange(sum(width for _, width in registers))
    for name, width in registers:
        if place < width:
            return name, place
        place -= width
    raise AssertionError("a bit beyond the last register")


def _log(dice: random.Random, low: float, high: float) -> float:
    return low * (high / low) ** dice.random()


def _value(dice: random.Random, name: str) -> float:
    known = INPUTS[name]
    if values := known.drawn():
        return dice.choice(values)
    span, _, whole = known.draw.partition(" ")
    value = float(f"{_log(dice, *map(float, span.split('..'))):.3g}")
    if whole:
        value = round(value)
    return -value if known.low < 0 and dice.random() < 0.5 else value


def _request(dice: random.Random, n: int, motion: Motion, at: float) -> Fault:
    """A request that nobody meant: of the right form, at the wrong time or with a wrong bit."""
    request = dice.choice(REQUESTS)
    call: dict = {"at": at, "request": request}
    axis = dice.randrange(motion.axes)
    what = request
    if request in ("MCALIB", "MSETENC", "MSETPARAM"):
        call["axis"] = axis
    if request == "MDACMODE":
        call["value"] = dice.randrange(2)
    elif request == "MSETENC":
        call["value"] = dice.randrange(1 << 16)
    elif request == "MSETINTERVAL":
        call["value"] = motion.interval_us ^ 1 << dice.randrange(17)
    elif request == "MSETPARAM":
        name = dice.choice(PARAMETERS)
        flipped = (motion.parameters[axis][name] & 0xFFFFFFFF) ^ 1 << dice.randrange(32)
        call["set"] = {name: flipped - (flipped >> 31 << 32)}
        if name in ("ilim", "clkdivisor"):  # a scenario takes no negative one, and no divisor 0
            call["set"][name] = (flipped & 0x7FFFFFFF) or 2
        what = f"MSETPARAM {name}"
    return Fault(n, motion.name, "message", what, at, call=call)
