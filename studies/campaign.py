# SPDX-License-Identifier: Apache-2.0
"""What campaigns found in the machine of 1989, and what remedies are worth.

`python -m studies.campaign FOLDER` writes docs/evidence/campaign.md and its maps of the campaigns
in FOLDER, one for each of MACHINES. `--run NAME N` runs N faults of one, `--healthy N` so many
healthy motions of the safe machine.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
from collections import Counter
from pathlib import Path

from mmcs import ROOT, InputError, load
from mmcs.sweeps.campaign import MOTIONS, make_plan
from mmcs.sweeps.campaign_report import (
    WHEN,
    WHERE,
    cost_of,
    good,
    holes,
    how_far,
    per_million,
    tables,
    told,
    write_maps,
)
from mmcs.sweeps.classes import DANGEROUS, LATE, STEPS
from mmcs.sweeps.faults import line_name

PAGE = ROOT / "docs" / "evidence" / "campaign.md"
IMAGES = ROOT / "docs" / "images"
WORST = 10  # holes that are shown
ILIMAX = "axis.all.ilimax=60"  # of the report; with 40 the healthy arm_calibrate stops itself
MACHINES = {
    "1989": (),
    "remedies": ("amp_panic_cut=true", "host.guard_jump=50", "host.guard_follow=300",
                 "host.guard_missed=5", "host.guard_lock=true", "host.guard_lease=10", ILIMAX),
    "2026": ('safety="2026"', ILIMAX),
}  # fmt: skip
TITLES = {
    "1989": "as built in 1989",
    "remedies": "PANIC cuts the amplifiers at once; guard: jump 50, follow 300, missed 5, lock,"
    " lease 10; `ilimax` 60",
    "2026": "the [safe machine](../hardware/safety.md), `ilimax` 60",
}
HEALTHY = "healthy.json"
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


def why(what: str) -> str:
    if what.startswith("MSETPARAM "):
        return "any number is a gain"
    if what not in WHY:
        raise SystemExit(f"studies.campaign: the hole {what} has no sentence: say in WHY why it is")
    return WHY[what]


def rows_of(folder: Path) -> dict[int, dict]:
    """Rows 0 to N, whatever was done beyond them when the campaign was stopped."""
    lines = (folder / "rows.jsonl").read_text().splitlines()[1:]
    entries = [json.loads(line) for line in lines if line.endswith("}")]
    rows = {entry["n"]: entry["row"] for entry in entries}
    whole = next(n for n in range(len(rows) + 1) if n not in rows)
    return {n: rows[n] for n in range(whole)}


def machine_table(found: dict[str, list[dict]], healthy: dict[str, list]) -> list[str]:
    far = STEPS[-1]
    lines = [
        f"| machine | faults | silent and dangerous, per million | beyond {far:g}° | told too "
        f"late, per million | beyond {far:g}° | healthy runs: stopped, harmed |",
        "|---|" + "---:|" * 6,
    ]
    for name, rows in found.items():
        cells = []
        for kind in (DANGEROUS, LATE):
            own = [row["deg"] for row in rows if row["class"] == kind]
            cells.append(per_million(len(own), len(rows)))
            cells.append(per_million(sum(deg > far for deg in own), len(rows)))
        runs, stopped, harmed = healthy.get(name, ("", "", ""))
        good_ones = f"{runs:,}: {stopped}, {harmed}" if runs else ""
        lines.append(f"| {TITLES[name]} | {len(rows):,} | {' | '.join(cells)} | {good_ones} |")
    return lines


def hole_table(found: dict[str, list[dict]]) -> list[str]:
    """The worst holes of the first machine, and how much of each the others leave."""
    names = list(found)
    lines = [
        "| hole | why | " + " | ".join(names) + " |",
        "|---|---|" + "---:|" * len(names),
    ]
    for (sort, what), _ in holes(found[names[0]])[:WORST]:
        cells = []
        for rows in found.values():
            own = [r["class"] for r in rows if (r["sort"], r["what"]) == (sort, what)]
            cells.append(f"{own.count(DANGEROUS)} of {len(own)}")
        lines.append(f"| `{line_name(what)}` | {why(what)} | {' | '.join(cells)} |")
    return lines


def left(rows: list[dict]) -> str:
    """What still goes far without a word."""
    far = Counter(r["what"] for r in rows if r["class"] == DANGEROUS and r["deg"] > STEPS[-1])
    late = Counter(r["what"] for r in rows if r["class"] == LATE and r["deg"] > STEPS[-1])
    text = lambda c: ", ".join(f"`{line_name(w)}` {n}" for w, n in c.most_common(8)) or "nothing"  # noqa: E731
    return f"Beyond {STEPS[-1]:g}° in silence: {text(far)}. Told too late: {text(late)}."


def commit() -> str:
    command = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(
        command, cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.strip()


def page(found: dict[str, list[dict]], healthy: dict, costs: str, at: str) -> str:
    first, last = next(iter(found.values())), list(found)[-1]
    lines = [
        "# Where the design of 1989 is deaf",
        "",
        "Faults drawn by one seed, each a run beside its fault-free twin. What is drawn, and what",
        "the classes mean, is in [campaigns](../use/campaign.md). To make it again:",
        "`python -m studies.campaign build/campaigns/study --run 1989 3000` (and `remedies`,",
        "`2026`), `--healthy 1000`, then without an option.",
        "",
        f"{costs} Commit {at}. Shares are of faults drawn evenly, in per million with their 95 %",
        "intervals; 100,000 faults of 3155977 gave 136,800 (134,700 to 139,000) silent and",
        "dangerous, 173,200 (170,800 to 175,500) told too late, as built in 1989.",
        "",
        *machine_table(found, healthy),
        "",
        f"{told(first)} Of the safe machine: {left(found[last])}",
        "",
        f"![Shares of the classes by register, input and request](../images/campaign_{WHERE})",
        "",
        f"![Shares of the classes over the motions](../images/campaign_{WHEN})",
        "",
        "## The worst holes, and what is left of them",
        "",
        *hole_table(found),
        "",
    ]
    for name, rows in found.items():
        lines += [line.replace("## How far", f"## How far: {name}") for line in how_far(rows)[:-2]]
        lines.append("")
    plan = make_plan((), (), 1)
    lines += tables(plan, first)[: tables(plan, first).index("## Where it is deaf") - 1]
    return "\n".join(lines).rstrip() + "\n"


def run_healthy(count: int) -> dict[str, list]:
    """Of the safe machine without a fault, the four motions with other ends and seeds: [runs,
    stopped, more than 10 counts off the way of the machine of 1989]."""
    from mmcs.sweeps.classes import NEAR
    from mmcs.sweeps.twin import Twin

    stopped = harmed = 0
    for n in range(count):
        motion = MOTIONS[n % len(MOTIONS)]
        sets = variation(motion, random.Random(f"healthy/{n}"))
        twins = []
        try:
            for more in (MACHINES["1989"], MACHINES["2026"]):
                setup = make_plan((motion,), (), 1, (*more, *sets)).setups[motion]
                twins.append(Twin(setup, snapshots=False))
            harmed += bool(abs(twins[0].angles - twins[1].angles).max() > NEAR)
        except InputError as error:
            stopped += 1
            print(f"healthy run {n}: {error}")
        for twin in twins:
            twin.close()
    return {"2026": [count, stopped, harmed]}


def variation(motion: str, dice: random.Random) -> tuple[str, ...]:
    """A healthy motion like this one: ends at -100 to 100 % of its own, another seed."""
    from mmcs.errors import toml

    sets = [f"seed={dice.randrange(1, 1 << 30)}"]
    entries = []
    for entry in load(motion).data.get("motion", []):
        to = entry["to"]
        scale = lambda: dice.choice((-1, 1)) * dice.uniform(0.2, 1.0)  # noqa: E731
        if isinstance(to, list):
            entries.append(entry | {"to": [round(v * scale()) for v in to]})
        else:
            entries.append(entry | {"to": round(to * scale())})
    if entries:
        sets.append("motion=" + toml(entries))
    return tuple(sets)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--run", nargs=2, metavar=("NAME", "N"), help="faults of one machine")
    parser.add_argument("--healthy", type=int, metavar="N", help="healthy runs")
    parser.add_argument("--at", metavar="COMMIT", help="of the campaigns, if not this one")
    options = parser.parse_args()
    kept = options.folder / HEALTHY
    if options.run:
        name, count = options.run
        sets = [word for text in MACHINES[name] for word in ("--set", text)]
        command = ["mmcs", "campaign", "--faults", count, "--seed", "1", *sets]
        subprocess.run([*command, "--out", str(options.folder / name)], check=True)
        return
    if options.healthy:
        options.folder.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(run_healthy(options.healthy)))
        return
    folders = {name: options.folder / name for name in MACHINES}
    rows = {name: rows_of(folder) for name, folder in folders.items()}
    faults, core_s, _ = map(sum, zip(*(cost_of(f) for f in folders.values()), strict=True))
    costs = f"A fault took {1e3 * core_s / faults:.0f} ms of a core."
    healthy = json.loads(kept.read_text()) if kept.exists() else {}
    found = {name: good(some) for name, some in rows.items()}
    PAGE.write_text(page(found, healthy, costs, options.at or commit()))
    for path in write_maps(folders["1989"], make_plan((), (), 1), rows["1989"]):
        (IMAGES / f"campaign_{path.name}").write_bytes(path.read_bytes())


if __name__ == "__main__":
    main()
