# SPDX-License-Identifier: Apache-2.0
"""What a campaign found and what remedies are worth: writes docs/evidence/campaign.md.

`python -m studies.campaign BASE [--remedies [NAME...]] [--write]`: BASE is the folder of
`mmcs campaign`, done or stopped. --remedies runs its faults again with each remedy: all that did
harm, and some that did none, to see whether the remedy does. --write makes the page and its maps
of what is there.
"""

from __future__ import annotations

import argparse
import json
import random
import statistics
import subprocess
import time
from collections import Counter
from pathlib import Path

from mmcs import ROOT
from mmcs.sweeps.campaign import make_plan, run_fault, twin_of
from mmcs.sweeps.campaign_report import (
    WHEN,
    WHERE,
    cost_of,
    examples,
    good,
    holes,
    per_million,
    tables,
    told,
    write_maps,
)
from mmcs.sweeps.classes import CLASSES, DANGEROUS, LATE, SAFE
from mmcs.sweeps.faults import line_name

PAGE = ROOT / "docs" / "evidence" / "campaign.md"
IMAGES = ROOT / "docs" / "images"
HARMLESS_ONES = 200  # that are run again with each remedy
GOAL, CORES, HOURS = 100_000, 2, 3
GUARD = ("host.guard_jump=50", "host.guard_follow=300", "host.guard_missed=5",
         "host.guard_lock=true", "host.guard_lease=10")  # fmt: skip
WHY = {
    "card.u_axis.u_encoder.count_q": "no parity: the servo takes counts back that never were",
    "card.u_ppi.pb_q": "a mode bit of the card, which the driver wrote once and never looks at",
    "card.u_ppi.mode_q": "a mode bit of the card: ports become inputs",
    "adaptor.u_core.u_pit.g_counter[1].u_counter.cr_q": "another SCLOCK, and nobody measures it",
    "adaptor.u_core.power_timer_q": "RESET DRV: all cards forget their modes",
    "writes_lost": "the driver holds the last setpoint, however old",
    "write_flip": "any 32 bits are a setpoint",
    "MSETENC": "renumbers the axis under a program that goes on in the old numbers",
    "MENABLE": "under power begins the servo's memory anew",
    "MSETINTERVAL": "under power makes all gains wrong",
    "host_stall": "below 50 ms no heartbeat ends, and the D/As keep their torque",
    "irq_lost": "below 50 ms no heartbeat ends, and the D/As keep their torque",
    "axis_enable": "the switch isolates the drive, and no bit tells the host",
    "sclock_open": "the D/As of the card wait for a latch that never comes",
    "encoder_a_cut": "no check of the wires: the axis seems to stand",
    "encoder_b_cut": "no check of the wires: the axis seems to stand",
    "encoder_swap": "the loop pushes away from its goal",
    "encoder_slip": "what the disc says is the truth",
    "amp_dead": "nothing reads the current back",
    "amp_saturated": "nothing reads the current back",
    "motor_jam": "the error grows to the current limit, and that is allowed",
    "load_torque": "the error grows to the current limit, and that is allowed",
    "brake_stuck": "no sensor on a brake",
    "drive_offset": "the loop leans against it, some counts off",
    "pc_control_stuck0 1": "a write that never ends: the card takes what is on the bus",
}
REMEDIES = {
    "PANIC cuts the amplifiers": ("amp_panic_cut=true",),
    "guard: counters that jump": GUARD[:1],
    "guard: axes that do not follow": GUARD[1:2],
    "guard: SCLOCKs that nobody serves": GUARD[2:3],
    "guard: requests under power": GUARD[3:4],
    "guard: setpoints that nobody renews": GUARD[4:],
    "overload is an error (`ilimax`, of the report)": ("axis.all.ilimax=20",),
    "all of them": ("amp_panic_cut=true", *GUARD, "axis.all.ilimax=20"),
}


def why(what: str) -> str:
    if what.startswith("MSETPARAM "):
        return "any number is a gain"
    if what not in WHY:
        raise SystemExit(f"studies.campaign: the hole {what} has no sentence: say in WHY why it is")
    return WHY[what]


def base_rows(folder: Path) -> dict[int, dict]:
    """Rows 0 to N, whatever was done beyond them when the campaign was stopped."""
    lines = (folder / "rows.jsonl").read_text().splitlines()[1:]
    entries = [json.loads(line) for line in lines if line.endswith("}")]
    rows = {entry["n"]: entry["row"] for entry in entries}
    whole = next(n for n in range(len(rows) + 1) if n not in rows)
    return {n: rows[n] for n in range(whole)}


def chosen(rows: dict[int, dict]) -> tuple[list[int], list[int]]:
    """Those that did harm, and some of the others, by number."""
    harm = [n for n, row in rows.items() if row.get("class") in (DANGEROUS, LATE)]
    rest = [n for n, row in rows.items() if row.get("class") in set(CLASSES) - {DANGEROUS, LATE}]
    return sorted(harm), sorted(random.Random(1).sample(rest, min(HARMLESS_ONES, len(rest))))


def remedy(name: str, rows: dict[int, dict], seed: int, seconds: float) -> dict:
    """Rows of the chosen faults with the remedy, as far as the time goes: harm first, in an order
    that favours none."""
    plan = make_plan((), (), seed, REMEDIES[name])
    harm, rest = chosen(rows)
    order = random.Random(2).sample(harm, len(harm))
    found: dict[str, dict] = {"harm": {}, "rest": {}}
    began = time.monotonic()
    for kind, numbers, share in (("harm", order, 0.8), ("rest", rest, 1.0)):
        for n in numbers:
            if time.monotonic() - began > seconds * share:
                break
            fault = plan.fault(n)
            found[kind][str(n)] = run_fault(twin_of(plan.setups[fault.motion]), fault)["class"]
    return found


def after(rows: dict[int, dict], found: dict, name: str) -> str:
    """Faults of a class per million after the remedy, with the interval of what was run again. The
    others are taken for what they were."""
    from mmcs.sweeps.campaign_report import wilson

    count = len(good(rows))
    harm = sum(row.get("class") in (DANGEROUS, LATE) for row in rows.values())
    k, n = Counter(found["harm"].values())[name], len(found["harm"])
    share = [k / n if n else 1.0, *wilson(k, n)]
    most, low, high = (round(1e6 * harm / count * s, -2) for s in share)
    return f"{most:,.0f} ({low:,.0f} to {high:,.0f})"


def remedy_table(rows: dict[int, dict], measured: dict[str, dict]) -> list[str]:
    some = good(rows)
    before = Counter(row["class"] for row in some)
    lines = [
        "| remedy | silent and dangerous, per million | detected too late, per million | run again"
        " | without harm before, run again: stopped now, harmed now |",
        "|---|---:|---:|---:|---:|",
        f"| none | {per_million(before[DANGEROUS], len(some))} | "
        f"{per_million(before[LATE], len(some))} | | |",
    ]
    for name, found in measured.items():
        now = [c for n, c in found["rest"].items() if c != rows[int(n)]["class"]]
        harmed = sum(c in (LATE, DANGEROUS) for c in now)
        stopped = now.count(SAFE)
        lines.append(
            f"| {name} | {after(rows, found, DANGEROUS)} | {after(rows, found, LATE)} | "
            f"{len(found['harm'])} | {len(found['rest'])}: {stopped}, {harmed} |"
        )
    return lines


def hole_table(rows: dict[int, dict], measured: dict[str, dict]) -> list[str]:
    """The ten worst holes: how many of their dangerous faults each remedy leaves so."""
    lines = [
        "| hole | why | silent and dangerous | " + " | ".join(measured) + " |",
        "|---|---|---:|" + "---:|" * len(measured),
    ]
    for (sort, what), count in holes(good(rows))[:10]:
        of_it = [n for n, r in rows.items() if (r.get("sort"), r.get("what")) == (sort, what)]
        own = {str(n) for n in of_it if rows[n]["class"] == DANGEROUS}
        cells = []
        for found in measured.values():
            again = [found["harm"][n] for n in own if n in found["harm"]]
            cells.append(f"{again.count(DANGEROUS)} of {len(again)}")
        name = f"| `{line_name(what)}` | {why(what)} | {count} | "
        lines.append(name + " | ".join(cells) + " |")
    return lines


def cost(folder: Path) -> str:
    """What a fault took of a core, and what the goal did or would."""
    faults, core_s, wall_s = cost_of(folder)
    each = core_s / faults
    hours = GOAL * each / CORES / 3600
    return (
        f"A fault took {1e3 * each:.0f} ms of a core (process time of the workers, {faults:,}"
        f" faults), and all of them {wall_s / 3600:.1f} hours by the clock, on {CORES} cores that"
        f" had other work, too. {GOAL:,} are {hours:.1f} hours on {CORES} quiet cores, of the"
        f" {HOURS} that were wanted."
    )


def commit() -> str:
    command = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(
        command, cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.strip()


def lateness(rows: dict[int, dict]) -> str:
    """How those that were told too late were told, and which joint went the farthest."""
    late = [row for row in rows.values() if row.get("class") == LATE]
    by = Counter("a refused request" if "refused" in r["by"] else r["by"] for r in late)
    ways = ", ".join(f"{count:,} by {name}" for name, count in by.most_common())
    half = statistics.median(row["after_ms"] for row in late)
    joints = Counter(row["joint"] for row in late)
    share = ", ".join(
        f"J{joint} in {100 * n / len(late):.0f} %" for joint, n in sorted(joints.items())
    )
    return (
        f"Of those told too late {ways}; half of them within {half:.1f} ms. The joint that goes the"
        f" farthest beyond is {share}."
    )


def measured_at(measured: dict[str, dict], base: str) -> str:
    """The commits that the figures are of."""
    later = sorted({found.get("at", base) for found in measured.values()} - {base})
    remedies = f"; remedies were measured on {' and '.join(later)}" if later else ""
    return f"Figures, fault numbers and hashes are those of commit {base}{remedies}."


def page(rows: dict[int, dict], measured: dict[str, dict], seed: int, note: str, base: str) -> str:
    plan = make_plan((), (), seed)
    some = good(rows)
    before = Counter(row["class"] for row in some)
    count = len(some)
    lines = [
        "# Faults that the design of 1989 does not detect",
        "",
        f"{count:,} faults, each a run beside its fault-free twin: `mmcs campaign --faults {count} "
        f"--seed {seed}`,",
        "then `python -m studies.campaign`. What is drawn, and what the classes mean, is in",
        "[campaigns](../use/campaign.md).",
        "",
        f"{note} {measured_at(measured, base)}",
        "",
        f"Silent and dangerous, per million: {per_million(before[DANGEROUS], count)}; detected too",
        f"late: {per_million(before[LATE], count)} (95 %). {told(some)}",
        "",
        f"![Shares of the classes by register, input and request](../images/campaign_{WHERE})",
        "",
        f"![Shares of the classes over the motions](../images/campaign_{WHEN})",
        "",
        "## Remedies",
        "",
        "All keep the register map and are off unless asked for. Each ran the same faults again:",
        "those that did harm (as many as are named, drawn at random from those known by then), and",
        "some that did none. The guard is the [driver's](../use/driver.md): jump 50, follow 300,",
        "samples 5, missed 5, lock, lease 10.",
        "",
        *remedy_table(rows, measured),
        "",
        "*Too late* comes about in two ways. After a PANIC that passes by itself, and after each",
        "stop of the driver's own, brakes are open and D/As at zero until the heartbeats end, and",
        "J2 sinks. When the host dies or the cable goes, D/As keep their last torque, and J4 to J6",
        "have no brakes.",
        lateness(rows),
        "A PANIC that keeps the brakes until the next MENABLE would help with the first, and is a",
        "change of the RTL that is not measured here.",
        "",
        "The ten inputs and registers with the most silent and dangerous faults, and how many of "
        "them each remedy leaves:",
        "",
        *hole_table(rows, measured),
        "",
        *tables(plan, some),
        "",
        "## Again",
        "",
        *examples(plan, rows),
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", type=Path)
    parser.add_argument("--seed", type=int, default=1, help="of the campaign")
    parser.add_argument("--remedies", nargs="*", metavar="NAME", choices=list(REMEDIES),
                        help="to run the faults again with; without a name all")  # fmt: skip
    parser.add_argument("--seconds", type=float, default=1e9, help="for each remedy")
    parser.add_argument("--at", metavar="COMMIT", help="of the campaign, if not this one")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    rows, kept = base_rows(options.base), options.base / "remedies.json"
    measured = json.loads(kept.read_text()) if kept.exists() else {}
    if options.remedies is not None:
        for name in options.remedies or REMEDIES:
            measured[name] = remedy(name, rows, options.seed, options.seconds) | {"at": commit()}
            kept.write_text(json.dumps(measured))
    measured = {name: measured[name] for name in REMEDIES if name in measured}
    if options.write:
        note = cost(options.base)
        PAGE.write_text(page(rows, measured, options.seed, note, options.at or commit()))
        for path in write_maps(options.base, make_plan((), (), options.seed), rows):
            (IMAGES / f"campaign_{path.name}").write_bytes(path.read_bytes())


if __name__ == "__main__":
    main()
