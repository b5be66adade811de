# SPDX-License-Identifier: Apache-2.0
"""What a campaign found: counts by class, where and when, with 95 % confidence intervals."""

import bisect
import math
from collections import Counter
from pathlib import Path

from mmcs.folder import whole_file
from mmcs.sweeps.classes import CLASSES, DANGEROUS, LATE, STEPS
from mmcs.sweeps.faults import line_name

Z = 1.959964  # 95 %
HOLES = 25
REPORT = "report.md"


def wilson(k: int, n: int) -> tuple[float, float]:
    """The 95 % interval of a share, k of n seen."""
    if n == 0:
        return 0.0, 1.0
    p, z2 = k / n, Z * Z
    middle = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = Z * math.sqrt(p * (1 - p) / n + z2 / (4 * n * n)) / (1 + z2 / n)
    return max(0.0, middle - half), min(1.0, middle + half)


def per_million(k: int, n: int) -> str:
    """Of a million faults: what was seen, and between what it lies."""
    low, high = (round(1e6 * share, -2) for share in wilson(k, n))
    return f"{round(1e6 * k / n, -2) if n else 0:,.0f} ({low:,.0f} to {high:,.0f})"


class Counts:
    """Rows by some key, each with its classes."""

    def __init__(self, rows, key):
        self.by: dict[object, Counter] = {}
        for row in rows:
            self.by.setdefault(key(row), Counter())[row["class"]] += 1

    def total(self, name) -> int:
        return sum(self.by[name].values())

    def table(self, heading: str, names, shown=str) -> list[str]:
        lines = [
            f"| {heading} | faults | " + " | ".join(CLASSES) + " | dangerous per million |",
            "|---|" + "---:|" * (len(CLASSES) + 2),
        ]
        for name in names:
            own, total = self.by[name], self.total(name)
            cells = [f"{own[c]:,}" for c in CLASSES]
            lines.append(
                f"| {shown(name)} | {total:,} | {' | '.join(cells)} | "
                f"{per_million(own[DANGEROUS], total)} |"
            )
        return lines


def good(rows: dict[int, dict]) -> list[dict]:
    """Those that ran, in the order of their numbers."""
    return [rows[n] for n in sorted(rows) if rows[n]["status"] == "ok"]


def holes(rows: list[dict]) -> list[tuple[tuple[str, str], int]]:
    """(sort, what) and how many silent and dangerous ones, the most first."""
    found = Counter((r["sort"], r["what"]) for r in rows if r["class"] == DANGEROUS)
    return sorted(found.items(), key=lambda item: (-item[1], item[0]))


def tables(plan, rows: list[dict]) -> list[str]:
    """Markdown, the same for the same rows."""
    everything = Counts(rows, lambda _: "all")
    sorts = Counts(rows, lambda r: r["sort"])
    lines = ["## By sort", ""]
    lines += sorts.table("sort", [s for s in plan.sorts if s in sorts.by])
    lines += everything.table("sort", everything.by)[2:]
    lines += ["", "## What stays undetected", ""]
    lines += [
        "The registers (one name for all cards and axes), inputs and requests with the most silent",
        "and dangerous faults. Every flip-flop is as likely as any other; inputs and requests are",
        "drawn evenly.",
        "",
    ]
    where = Counts(rows, lambda r: (r["sort"], r["what"]))
    names = [name for name, _ in holes(rows)[:HOLES]]
    lines += where.table("what", names, lambda name: f"`{line_name(name[1])}`")
    return lines


def how_far(rows: list[dict]) -> list[str]:
    """By how far the farthest joint went: from the twin's place if nothing was told, else beyond
    its corridor."""
    names = [f"to {deg:g}°" for deg in STEPS] + [f"beyond {STEPS[-1]:g}°"]
    lines = ["## How far", "", f"| | faults | {' | '.join(names)} |", "|---|" + "---:|" * 5]
    for name in (LATE, DANGEROUS):
        far = [row["deg"] for row in rows if row["class"] == name]
        counts = Counter(bisect.bisect_left(STEPS, deg) for deg in far)
        cells = [per_million(counts[n], len(rows)) for n in range(len(names))]
        lines.append(f"| {name}, per million | {len(far):,} | {' | '.join(cells)} |")
    lines += ["", "*Per million* is a share of faults that were drawn as evenly as the tables say, "
              "not a rate: it does not tell how often a fault comes."]  # fmt: skip
    return lines


def told(rows: list[dict]) -> str:
    """How many of the silent and dangerous ones a look at the statistics would have shown."""
    own = [r for r in rows if r["class"] == DANGEROUS]
    seen = sum(bool(r["told"]) for r in own)
    return (
        f"{seen:,} of the {len(own):,} silent and dangerous faults leave a trace in the driver's"
        " statistics (missed, overruns, spurious, bus errors) for a program that looks there."
    )


def examples(plan, rows: dict[int, dict]) -> list[str]:
    """Commands that make faults of each class again, and the hash that they must find."""
    from mmcs.sweeps.campaign import run_fault, twin_of

    lines = []
    for name in CLASSES:
        own = [n for n in sorted(rows) if rows[n].get("class") == name]
        for n in own[:2]:
            fault, what = plan.fault(n), line_name(plan.fault(n).what)
            row = run_fault(twin_of(plan.setups[fault.motion]), fault, whole=True)
            after = "" if row["after_ms"] is None else f", {row['by']} after {row['after_ms']:g} ms"
            found = f"off by {row['off']:g} counts{after}; hash {row['hash']}"
            lines += [f"* **{name}**: fault {n}, `{what}`, {found}", "", f"  `{plan.command(n)}`"]
    return lines


def write_report(folder: Path, plan, rows: dict[int, dict], command: str) -> Path:
    some = good(rows)
    lost = len(rows) - len(some)
    lines = [f"# {len(some):,} faults", "", f"`{command}`", ""]
    if lost:
        lines += [f"{lost} faults could not be run: their rows tell why.", ""]
    lines += [
        *how_far(some),
        "",
        *tables(plan, some),
        "",
        told(some),
        "",
        "## Again",
        "",
        *examples(plan, rows),
    ]
    path = folder / REPORT
    with whole_file(path) as part:
        part.write_text("\n".join(lines) + "\n")
    return path


def print_summary(plan, rows: dict[int, dict]) -> None:
    from mmcs.screen import echo, table

    counts = Counts(good(rows), lambda r: r["sort"])
    title, found = f"{len(rows)} faults in {', '.join(plan.names)}", []
    for sort in plan.sorts:
        if sort in counts.by:
            found.append((sort, *(str(counts.by[sort][name]) for name in CLASSES)))
    echo(table(title, ("sort", *CLASSES), found, left=1))
