# SPDX-License-Identifier: Apache-2.0
"""The fault table: `python -m studies.faults` runs every fault and writes docs/evidence/faults.md.

Each entry of sim/scenarios/faults/faults.toml runs twice: as built in 1989, and with the enable
of the amplifiers taken away by PANIC (amp_panic_cut). Its first event is the fault.
"""

import argparse
import errno
from typing import NamedTuple

from mmcs import FAULTS, ROOT, load, mcdef, read_toml, simulate
from mmcs import expect_plant as plant
from studies import run as finish
from tools.pages import fill

DOCUMENT = ROOT / "docs" / "evidence" / "faults.md"
OPEN_LOOP = ("estop", "cable", "pc_power")  # open the PANIC line themselves


class Row(NamedTuple):
    name: str
    detected: str  # by what
    after_ms: float | None
    moved: list[float]  # degrees per joint, farthest from where it was at the fault
    cut: list[float]  # the same with amp_panic_cut
    state: str  # what it ends in


def measure(name: str, fault: str) -> Row:
    """The row of a fault scenario. fault: what the table calls it."""
    result = simulate(load(name, "skip=true"))
    panics = any(n["kind"] == "panic" and "high" in n["text"] for n in result.notes)
    cut = moved(simulate(load(name, "skip=true", "amp_panic_cut=true"))) if panics else []
    return Row(fault, *detection(result), moved(result), cut, final_state(result))


def fault_time(result) -> float:
    """Seconds after the start of motion."""
    events = result.setup.scenario.event
    faults = [n["t"] for n in result.notes if n["kind"] == "fault"]
    if not events or not faults:
        return 0.0
    # Where the first event only prepares (a jumper set wrong), the last one is the fault.
    late = [t for t in faults if t > result.motion_start_s]
    return max(0.0, (late[-1] if late and not events[-1].until else faults[0])
               - result.motion_start_s)  # fmt: skip


def detection(result) -> tuple[str, float | None]:
    began = result.motion_start_s + fault_time(result)
    inputs = [event.input for event in result.setup.scenario.event]
    reason = ""
    for note in result.notes:
        if note["t"] < began:
            continue
        after = (note["t"] - began) * 1e3
        if note["kind"] == "log" and "PANIC: " in note["text"]:
            reason = reason or note["text"].partition("PANIC: ")[2]
        if note["kind"] == "panic" and "high" in note["text"]:
            own = any(name in OPEN_LOOP for name in inputs)
            return ("PANIC line" if own else "heartbeats, PANIC line"), after
        if note["kind"] == "error":
            flags = int(note["text"].split()[1], 16) & 0xFF
            if flags & (mcdef.MERR_PLO | mcdef.MERR_PHI):
                return "driver: position limit", after
            if flags & mcdef.MERR_ILIM:
                return "driver: current overload", after
            if flags & mcdef.MERR_PANIC:
                lost = "button" in reason  # says no more than that no cause shows on the cards
                return "driver: " + ("a read failed" if lost else reason), after
    if result.refused:
        name, number = result.refused[0]
        return f"driver: {name} says {errno.errorcode[number]}", None
    stats = result.stats
    if stats["missed"] or stats["overruns"]:
        return f"statistics: {stats['missed']} missed, {stats['overruns']} overruns", None
    return "nothing", None


def moved(result) -> list[float]:
    if not len(result.truth):
        return []
    began = fault_time(result)
    return [round(plant.moved_deg(result, n, began), 1) for n in range(result.setup.axes)]


def final_state(result) -> str:
    if result.refused:
        return "yes: nothing has moved"
    began = fault_time(result)
    rests = [plant.rest_ms(result, n, began) for n in range(result.setup.axes)]
    names = [result.setup.robot.axis_name(n) for n, rest in enumerate(rests) if rest is None]
    moving = f"; {', '.join(names)} still moving" if names else ""
    resting = [rest for rest in rests if rest is not None]
    if result.truth[-1, 1]:
        high = [n["t"] for n in result.notes if n["kind"] == "panic" and "high" in n["text"]]
        after = (high[-1] - result.motion_start_s - began) * 1e3
        braked = all(rest is not None for rest in rests[:3])
        good = "yes" if not names else "J1 to J3" if braked else "no"
        rest = f", at rest after {max(resting):.0f} ms" if resting else ""
        return f"{good}: brakes after {after:.0f} ms{rest}{moving}"
    if any(n["kind"] == "error" and int(n["text"].split()[1], 16) & ~mcdef.MERR_ZINDEX & 0xFF
           for n in result.notes):  # fmt: skip
        return f"no: zero current, brakes open{moving}"
    return "no: the servo goes on"


def table() -> str:
    """The text of the page with every row measured again."""
    rows = [measure(name, entry["name"]) for name, entry in read_toml(FAULTS).items()]
    return document(rows, healthy())


def write_document() -> None:
    DOCUMENT.write_text(table())


def healthy() -> list[float]:
    """What the joints move after 0.1 s when nothing is wrong."""
    # An event that changes nothing, so that the physics is watched.
    nothing = 'event=[{at=0.1, input="estop", value=0}]'
    return moved(simulate(load("fault_estop", "skip=true", "duration=0.4", nothing)))


def document(rows: list[Row], sound: list[float]) -> str:
    lines = [
        "| fault | detected by | after, ms | moved | amplifiers cut | safe state |",
        "|---|---|---|---|---|---|",
        f"| *none* | - | - | {_degrees(sound)} | - | - |",
    ]
    for row in rows:
        after = "-" if row.after_ms is None else f"{row.after_ms:.1f}"
        cells = (row.name, row.detected, after, _degrees(row.moved), _degrees(row.cut), row.state)
        lines.append("| " + " | ".join(cells) + " |")
    return fill(DOCUMENT, {"faults": lines})


def _degrees(values: list[float]) -> str:
    return " ".join(f"{v:.1f}" for v in values) if values else "-"


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    finish(write_document)
