# SPDX-License-Identifier: Apache-2.0
"""What campaigns found in the machine of 1989, and what remedies are worth.

`python -m studies.campaign FOLDER` writes docs/evidence/campaign.md and its maps of the campaigns
in FOLDER, one for each of MACHINES. `--run NAME N` runs N faults of one, `--healthy N` so many
healthy motions of the safe machine.
"""

import argparse
import json
import random
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from mmcs import ROOT, InputError, load
from mmcs.errors import toml
from mmcs.inputs import find
from mmcs.sweeps.campaign import MOTIONS, make_plan
from mmcs.sweeps.campaign_report import (
    cost_of,
    good,
    holes,
    how_far,
    per_million,
    tables,
    told,
    write_maps,
)
from mmcs.sweeps.classes import CLASSES, DANGEROUS, LATE, NEAR, STEPS
from mmcs.sweeps.faults import line_name
from mmcs.sweeps.twin import LOOK_S, Twin
from tools.pages import fill

PAGE = ROOT / "docs" / "evidence" / "campaign.md"
IMAGES = ROOT / "docs" / "images"
WORST = 10  # holes that are shown
SEED = 1
SAMPLE = 20  # faults of each machine that a test runs again
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
HEALTHY, COMMIT = "healthy.jsonl", "commit"  # in a machine's folder


def meaning(sort: str, what: str) -> str:
    """What the table of inputs, or that of requests, says of it."""
    if sort == "register":
        return "one flip-flop of it flips"
    if known := find(what.partition(" ")[0]):
        return known.meaning
    return "a request that nobody meant, or with a wrong bit"


def rows_of(folder: Path) -> dict[int, dict]:
    """Rows 0 to N, whatever was done beyond them when the campaign was stopped."""
    lines = (folder / "rows.jsonl").read_text().splitlines()[1:]
    entries = [json.loads(line) for line in lines if line.endswith("}")]
    rows = {entry["n"]: entry["row"] for entry in entries}
    whole = next(n for n in range(len(rows) + 1) if n not in rows)
    return {n: rows[n] for n in range(whole)}


def healthy_of(folder: Path) -> list[dict]:
    path = folder / HEALTHY
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def machine_table(folder: Path, found: dict[str, list[dict]]) -> list[str]:
    far = f"beyond {STEPS[-1]:g}°"
    lines = [
        f"| machine | commit | faults | silent and dangerous, per million | {far} "
        f"| told too late, per million | {far} | healthy runs: stopped, harmed |",
        "|---|---|" + "---:|" * 6,
    ]
    for name, rows in found.items():
        cells = [TITLES[name], (folder / name / COMMIT).read_text().strip(), f"{len(rows):,}"]
        for kind in (DANGEROUS, LATE):
            own = [row["deg"] for row in rows if row["class"] == kind]
            beyond = sum(deg > STEPS[-1] for deg in own)
            cells.append(per_million(len(own), len(rows)))
            cells.append(f"{per_million(beyond, len(rows))}: {beyond}")
        runs = healthy_of(folder / name)
        stopped, harmed = (sum(bool(run[key]) for run in runs) for key in ("stopped", "harmed"))
        cells.append(f"{len(runs):,}: {stopped}, {harmed}" if runs else "")
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def hole_table(found: dict[str, list[dict]]) -> list[str]:
    """The worst holes of the first machine, and how much of each the others leave."""
    lines = [
        "| hole | what it is | " + " | ".join(found) + " |",
        "|---|---|" + "---:|" * len(found),
    ]
    for (sort, what), _ in holes(next(iter(found.values())))[:WORST]:
        cells = []
        for rows in found.values():
            own = [r["class"] for r in rows if (r["sort"], r["what"]) == (sort, what)]
            cells.append(f"{own.count(DANGEROUS)} of {len(own)}")
        lines.append(f"| `{line_name(what)}` | {meaning(sort, what)} | {' | '.join(cells)} |")
    return lines


def sample_line(found: dict[str, list[dict]]) -> str:
    """The classes of each machine's first faults, by which a test tells a page that is stale.

    Not those of registers: which one is drawn depends on how many there are.
    """
    each = []
    for name, rows in found.items():
        first = [row for row in rows if row["sort"] != "register"][:SAMPLE]
        classes = Counter(row["class"] for row in first)
        each.append(f"{name} " + ", ".join(f"{classes[kind]} {kind}" for kind in CLASSES))
    what = f"Of the first {SAMPLE} faults but those of registers, which a test runs again"
    return f"{what}: {'; '.join(each)}."


def left(rows: list[dict]) -> str:
    """What still goes far without a word."""
    far = [r for r in rows if r["deg"] > STEPS[-1]]
    silent, late = ([r for r in far if r["class"] == kind] for kind in (DANGEROUS, LATE))

    def text(some: list[dict]) -> str:
        found = Counter(r["what"] for r in some).most_common(8)
        return ", ".join(f"`{line_name(what)}` {n}" for what, n in found) or "nothing"

    motions = " and ".join(f"`{motion}`" for motion in sorted({r["motion"] for r in silent}))
    where = f", in {motions} alone" if motions else ""
    return f"Beyond {STEPS[-1]:g}° in silence: {text(silent)}{where}. Told too late: {text(late)}."


def commit() -> str:
    command = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(
        command, cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.strip()


def page(folder: Path, found: dict[str, list[dict]], costs: str) -> str:
    first, last = next(iter(found)), list(found)[-1]
    again = sum(run["again"] for name in found for run in healthy_of(folder / name))
    far = []
    for name, rows in found.items():
        far += [line.replace("## How far", f"## How far: {name}") for line in how_far(rows)[:-1]]
    far += [how_far(found[first])[-1], "", f"The tables that follow are of `{first}`.", ""]
    parts = {
        "machines": [costs, "", *machine_table(folder, found), "", sample_line(found)],
        "left": [f"Healthy motions drawn again: {again}.", "",
                 f"{told(found[first])} Of the safe machine: {left(found[last])}"],
        "holes": hole_table(found),
        "tables": [*far, *tables(make_plan((), (), 1), found[first])],
    }  # fmt: skip
    return fill(PAGE, parts)


def run_healthy(folder: Path, count: int) -> None:
    """Of the safe machine without a fault, the four motions with other ends and seeds: whether it
    stops, and how many counts it is off the way of the machine of 1989. Goes on where it ended."""
    folder.mkdir(parents=True, exist_ok=True)
    done = len(healthy_of(folder))
    with (folder / HEALTHY).open("a") as out:
        for n in range(done, count):
            motion = MOTIONS[n % len(MOTIONS)]
            out.write(json.dumps({"n": n, "motion": motion, **_beside(motion, n)}) + "\n")
            out.flush()


def _beside(motion: str, n: int) -> dict:
    off, stopped, again = 0.0, "", 0
    dice = random.Random(f"healthy/{n}")
    sets = variation(motion, dice)
    try:
        old = _twin(motion, (ILIMAX, *sets))
        while not within_limits(old):
            again += 1
            sets = variation(motion, dice)
            old = _twin(motion, (ILIMAX, *sets))
        off = float(abs(old.angles - _twin(motion, (*MACHINES["2026"], *sets)).angles).max())
    except InputError as error:
        stopped = str(error)
    return {"again": again, "stopped": stopped, "off": off, "harmed": off > NEAR}


def _twin(motion: str, sets: tuple[str, ...]) -> Twin:
    """One that has run, and whose machine is gone. Raises InputError for one that stops."""
    twin = Twin(make_plan((motion,), (), 1, sets).setups[motion], snapshots=False)
    twin.close()
    return twin


def within_limits(twin: Twin) -> bool:
    """Whether its joints stayed off their stops and below the top speed of their motors: what
    leaves these is no healthy motion, on whatever machine."""
    angles = twin.angles / twin.scale
    speeds = abs(np.diff(angles, axis=0)).max(axis=0) / LOOK_S
    for motor, way, speed in zip(twin.setup.robot.axis, angles.T, speeds, strict=True):
        low, high = motor.stop_lo, motor.stop_hi
        if low < high and not low < way.min() <= way.max() < high:
            return False
        if motor.v_supply > 0 and speed >= motor.v_supply / motor.km / abs(motor.gear):
            return False
    return True


def variation(motion: str, dice: random.Random) -> tuple[str, ...]:
    """A healthy motion like this one: ends at -100 to 100 % of its own, another seed."""
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
    parser.add_argument("--healthy", type=int, metavar="N", help="healthy runs of the safe one")
    options = parser.parse_args()
    if options.run:
        name, count = options.run
        sets = [word for text in MACHINES[name] for word in ("--set", text)]
        command = [
            sys.executable,
            "-m",
            "mmcs",
            "campaign",
            "--faults",
            count,
            "--seed",
            str(SEED),
            *sets,
        ]
        at = commit()
        subprocess.run([*command, "--out", str(options.folder / name)], check=True)
        (options.folder / name / COMMIT).write_text(at)
        return
    if options.healthy:
        run_healthy(options.folder / "2026", options.healthy)
        return
    folders = {name: options.folder / name for name in MACHINES}
    rows = {name: rows_of(folder) for name, folder in folders.items() if folder.exists()}
    faults, core_s, _ = map(sum, zip(*(cost_of(folders[name]) for name in rows), strict=True))
    costs = f"A fault took {1e3 * core_s / faults:.0f} ms of a core." if faults else ""
    found = {name: good(some) for name, some in rows.items()}
    PAGE.write_text(page(options.folder, found, costs))
    first = next(iter(rows))
    for path in write_maps(folders[first], make_plan((), (), 1), rows[first]):
        (IMAGES / f"campaign_{path.name}").write_bytes(path.read_bytes())


if __name__ == "__main__":
    main()
