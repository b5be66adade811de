# SPDX-License-Identifier: Apache-2.0
"""The campaign of docs/evidence/campaign.md: the machine of 1989 and three remedies, one at a time.

`python -m studies.campaign` runs or goes on with what is missing under build/campaign2026, and
then writes the page's tables and rows.parquet, the rows of all of them, which go with a release.
Ctrl-C stops it; the same command goes on. All rows are of one build: another one begins anew.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np

from mmcs import BUILD, ROOT
from mmcs.sweeps.campaign import MOTIONS, Plan, make_plan
from mmcs.sweeps.campaign_report import per_million, wilson
from mmcs.sweeps.classes import DANGEROUS, LATE
from mmcs.sweeps.store import ROWS
from studies import run as finish
from tools.pages import committed, rewrite

FOLDER = BUILD / "campaign2026"
PAGE = ROOT / "docs" / "evidence" / "campaign.md"
MEASURED = "rtl sim firmware mmcs"  # what the tables depend on
REMEDIES = {
    "`ilimax` 60": "axis.all.ilimax=60",
    "heartbeats of 10 ms": "heartbeat_us=10000",
    "amplifiers cut by PANIC": "amp_panic_cut=true",
}
VARIANTS = {
    "as in 1989": (),
    **{name: (key,) for name, key in REMEDIES.items()},
    "all three": tuple(REMEDIES.values()),
}
FAULTS, HEALTHY = 30_000, 1000  # of each variant
CLK_HZ = 8_000_000


def folder_of(variant: str) -> Path:
    return FOLDER / "".join(c if c.isalnum() else "_" for c in variant).strip("_")


def mmcs(*words: object) -> None:
    """A command of mmcs, which goes on where an earlier one was stopped. Raises SystemExit."""
    folder = Path(words[words.index("--out") + 1])
    resume = ["--resume"] if (folder / ROWS).is_file() else []
    command = [sys.executable, "-m", "mmcs", *map(str, words), *resume]
    status = subprocess.run(command, cwd=ROOT, check=False).returncode
    if status:
        raise SystemExit(status)


def run(faults: int, healthy: int) -> None:
    """All that is missing of the campaigns and of the healthy runs."""
    for variant, sets in VARIANTS.items():
        place, typed = folder_of(variant), [w for text in sets for w in ("--set", text)]
        print(f"{variant}: {faults} faults, {healthy} healthy runs", flush=True)
        mmcs("campaign", "--faults", faults, "--out", place, *typed)
        for motion in MOTIONS:
            mmcs("sweep", motion, "--random", "seed=1..1000000", "--random",
                 "host.latency_max_us=1.0..400.0", "--samples",
                 max(1, healthy // len(MOTIONS)), "--set", "expect=[]", *typed,
                 "--out", place / motion)  # fmt: skip


def rows_of(variant: str) -> list[dict]:
    """Those that ran, in the order of their numbers."""
    lines = (folder_of(variant) / ROWS).read_text().splitlines()[1:]
    found = {entry["n"]: entry["row"] for entry in map(json.loads, lines)}
    return [{"n": n, **found[n]} for n in sorted(found) if found[n]["status"] == "ok"]


def stopped(variant: str) -> tuple[int, int]:
    """Of the healthy runs those that PANIC, or an error of the driver, stopped; and all."""
    bad = count = 0
    for motion in MOTIONS:
        with (folder_of(variant) / motion / "table.csv").open() as file:
            runs = list(csv.DictReader(file))
        most = max(float(run["interrupts"] or 0) for run in runs)
        bad += sum(float(run["panics"] or 1) > 0 or float(run["interrupts"]) < 0.99 * most
                   for run in runs)  # fmt: skip
        count += len(runs)
    return bad, count


def extrapolated(plan: Plan, rows: list[dict], name: str) -> str:
    """Failures if every flip-flop flipped at every clock of the motions, one at a time: the share
    of each motion's flips times its bits and clocks; with the 95 % interval of the shares."""
    parts = []
    for motion in plan.motions:
        own = [r["class"] == name for r in rows
               if r["motion"] == motion.name and r["sort"] == "register"]  # fmt: skip
        bits = sum(width for _, width in motion.registers)
        space = bits * motion.until * CLK_HZ
        parts.append([space * share for share in (sum(own) / max(1, len(own)),
                                                  *wilson(sum(own), len(own)))])  # fmt: skip
    total, low, high = np.sum(parts, axis=0)
    off = math.sqrt(sum((p[0] - p[1]) ** 2 for p in parts))
    up = math.sqrt(sum((p[2] - p[0]) ** 2 for p in parts))
    return f"{total / 1e9:.2f} ({max(low, total - off) / 1e9:.2f} to {(total + up) / 1e9:.2f})"


def table(found: dict[str, list[dict]], plans: dict[str, Plan]) -> list[str]:
    lines = [
        "| variant | faults | silent, per million | beyond 5° | too late, per million | beyond 5° "
        "| silent, 10⁹ flips | too late, 10⁹ flips | healthy runs stopped |",
        "|---|" + "---:|" * 8,
    ]
    for variant, rows in found.items():
        cells = [f"{len(rows):,}"]
        for name in (DANGEROUS, LATE):
            own = [row for row in rows if row["class"] == name]
            far = sum(row["deg"] > 5 for row in own)
            cells += [per_million(len(own), len(rows)), per_million(far, len(rows))]
        cells += [extrapolated(plans[variant], rows, name) for name in (DANGEROUS, LATE)]
        bad, count = stopped(variant)
        lines.append(f"| {variant} | {' | '.join(cells)} | {bad} of {count:,} |")
    return lines


def times(found: dict[str, list[dict]]) -> list[str]:
    """How long after the fault it was told, of those faults that were."""
    shares = (10, 25, 50, 75, 90, 99, 100)
    lines = [f"| variant | told of | {' | '.join(f'{share} %' for share in shares)} |",
             "|---|" + "---:|" * (len(shares) + 1)]  # fmt: skip
    for variant, rows in found.items():
        after = [row["after_ms"] for row in rows if row["after_ms"] is not None]
        cells = [f"{ms:.3g}" for ms in np.percentile(after, shares)] if after else ["–"] * 7
        lines.append(f"| {variant} | {len(after):,} | {' | '.join(cells)} |")
    return lines


def write(command: str) -> None:
    """The page's tables, and the rows as one table of Parquet."""
    import pandas

    found = {variant: rows_of(variant) for variant in VARIANTS}
    plans = {variant: make_plan((), (), 1, sets) for variant, sets in VARIANTS.items()}
    whole = [{"variant": name, **row} for name, rows in found.items() for row in rows]
    pandas.DataFrame(whole).to_parquet(FOLDER / "rows.parquet")
    rewrite(PAGE, "variants", "\n".join(table(found, plans)), command, MEASURED)
    rewrite(PAGE, "times", "\n".join(times(found)), command, MEASURED)
    rewrite(PAGE, "stops", (FOLDER / "stops" / "report.md").read_text(), command, MEASURED)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=FAULTS, help=f"of each variant; {FAULTS}")
    parser.add_argument("--healthy", type=int, default=HEALTHY, help=f"runs of each; {HEALTHY}")
    given = parser.parse_args()
    committed(MEASURED)
    run(given.faults, given.healthy)
    if not (FOLDER / "stops" / "report.md").is_file():
        mmcs("campaign", "puma560", "--stops", "--out", FOLDER / "stops")
    many = "" if given.faults == FAULTS else f" --faults {given.faults}"
    write(f"python -m studies.campaign{many}")


if __name__ == "__main__":
    finish(main)
