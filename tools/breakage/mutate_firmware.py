# SPDX-License-Identifier: Apache-2.0
"""Mutation score of the servo and the driver: `make mutation-firmware`.

Mutants of every file of firmware/mc come from the universalmutator package, fetched at a fixed
version into uv's cache. A mutant that does not compile, or whose optimised object code equals the
original's or an earlier mutant's, does not count, nor does one of the reviewed list of equivalents
in excuses_firmware.toml. The others meet, until one notices:

  unit      the C test programs of firmware/tests, every test function; later once more with
            address and undefined-behaviour sanitizers
  servo     firmware/tests/test_servo*.py, with 100,000 of the random samples
  scenario  closed loops on the simulated machine, judged by their own expectations

Score = noticed / (relevant - equivalent). `--sample N` takes N relevant mutants of every file (seed
printed), `--all` every one; `--only TEXT` the files so named; `--quick` leaves out sanitizers and
scenarios: a lower bound. Verdicts stay in build/mutation_firmware/results.json: what noticed a
mutant last time is tried first, and `--resume` takes a verdict as it is if nothing it hangs on has
changed. Survivors are listed in build/mutation_firmware/survivors.txt; `--write` puts the table
into docs/evidence/mutation_firmware.md.
"""

import argparse
import datetime
import json
import os
import random
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tools.breakage import firmware_mutants as fm
from tools.breakage.firmware_mutants import Mutant
from tools.pages import fill

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "evidence" / "mutation_firmware.md"
RESULTS = fm.WORK / "results.json"
AIM = 90


def told(m: Mutant) -> str:
    number, function, line, to = m.change()
    return f"{m.source.name}:{number}: {function}: {line}  ->  {to or '(nothing)'}"


def page(rows: list[tuple], survivors: list[Mutant], head: str) -> str:
    lines = [
        head,
        "",
        "| file | mutants | equivalent | noticed by unit tests | by the servo's reference "
        "| by scenarios | survive | score |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, total, same, by_unit, by_servo, by_loop, left in rows:
        score = f"{100 * (total - same - left) / (total - same):.1f} %" if total > same else "-"
        lines.append(
            f"| `{name}` | {total} | {same} | {by_unit} | {by_servo} | {by_loop} | {left} "
            f"| {score} |"
        )
    listed = ["```", *(map(told, survivors) if survivors else ["nothing"]), "```"]
    return fill(PAGE, {"score": lines, "survivors": listed})


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--sample", type=int, default=40, metavar="N", help="mutants of each file")
    parser.add_argument("--all", action="store_true", help="every mutant")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="files whose name holds the text"
    )
    parser.add_argument("--quick", action="store_true", help="no sanitizers, no scenarios")
    parser.add_argument("--resume", action="store_true", help="take verdicts that still hold")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.relative_to(ROOT)}")
    return parser.parse_args()


class Verdicts:
    """What earlier runs found, on disk."""

    def __init__(self, quick: bool):
        self.digest = fm.digest()
        self.quick = quick
        self.known = json.loads(RESULTS.read_text()) if RESULTS.is_file() else {}

    def recall(self, m: Mutant, resume: bool) -> bool:
        """Gives the mutant its hint; true if the verdict holds as it is."""
        last = self.known.get(m.key())
        if last is None:
            return False
        m.hint = last["noticed"]
        m.noticed = m.hint
        held = resume and last["digest"] == self.digest
        return held and bool(m.noticed or not last["quick"] or self.quick)

    def keep(self, m: Mutant) -> None:
        self.known[m.key()] = {"noticed": m.noticed, "digest": self.digest, "quick": self.quick}
        part = RESULTS.with_suffix(".part")
        part.write_text(json.dumps(self.known, indent=0))
        part.replace(RESULTS)


def run_file(source: Path, args, table: dict[str, str], verdicts: Verdicts) -> list[Mutant]:
    """The judged sample of one file."""
    mutants = fm.generate(source)
    random.Random(f"{args.seed}{source.name}").shuffle(mutants)
    kept = fm.relevant(mutants, 0 if args.all else args.sample)
    fm.mark_equivalent(kept)
    due = [m for m in kept if not m.why and not verdicts.recall(m, args.resume)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for m in pool.map(lambda m: fm.judge(m, table, args.quick), due):
            verdicts.keep(m)
    return [m for m in kept if m.noticed != "does not link"]


def main() -> int:
    args = arguments()
    files = [p for p in sorted(fm.MC.glob("*.c")) if args.only in p.name]
    if not files:
        print(f"mutation: no file of firmware/mc is called {args.only!r}", file=sys.stderr)
        return 2
    if args.quick and args.write:
        print("mutation: --quick finds a lower bound; leave it out to --write", file=sys.stderr)
        return 2
    if not args.quick:
        import mmcs.runs.report
        import mmcs.runs.runner  # noqa: F401  before the first fork: a child inherits what is loaded

        fm.keep_simulator()
    started = time.monotonic()
    print(f"mutation: seed {args.seed}, {'every mutant' if args.all else f'{args.sample} a file'}")
    table = fm.programs()
    verdicts = Verdicts(args.quick)
    source = fm.MC / "servo.c"  # meets every stage; unchanged it must pass them all
    whole = Mutant(source, source.read_text(), -1, fm.FIXED / "servo.o")
    if fm.judge(whole, table, args.quick).noticed:
        print(f"mutation: the firmware as it is fails: {whole.noticed}", file=sys.stderr)
        return 1
    print(f"mutation: passes unchanged, {time.monotonic() - started:.0f} s", flush=True)
    rows, survivors = [], []
    for source in files:
        judged = run_file(source, args, table, verdicts)
        counted = [m for m in judged if not m.why]
        left = [m for m in counted if not m.noticed]
        of = [sum(m.noticed.startswith(s) for m in counted) for s in ("unit", "servo", "sanit")]
        loops = len(counted) - sum(of) - len(left)
        for how, n in Counter(m.noticed for m in counted).most_common():
            print(f"  {n:4} {how or 'survive'}")
        same = len(judged) - len(counted)
        rows.append((source.name, len(judged), same, of[0] + of[2], of[1], loops, len(left)))
        survivors += left
        for m in left:
            print("survives", told(m))
        print(f"{source.name}: {len(counted) - len(left)} of {len(counted)} noticed", flush=True)
    totals = [sum(r[i] for r in rows) for i in range(1, 7)]
    rows.append(("all", *totals))
    (fm.WORK / "survivors.txt").write_text("\n".join(map(told, survivors)) + "\n")
    how = "--all" if args.all else f"--sample {args.sample} --seed {args.seed}"
    seconds = time.monotonic() - started
    if args.write:
        command = f"python tools/breakage/run.py driver-mutants {how} --write"
        head = f"{datetime.date.today()}, `{command}`,"
        head += f" {seconds / 60:.0f} minutes on {os.cpu_count()} cores."
        PAGE.write_text(page(rows, survivors, head))
    counted = totals[0] - totals[1]
    score = 100 * (counted - totals[5]) / max(1, counted)
    print(f"mutation: {counted - totals[5]} of {counted} noticed, {score:.1f} %, {seconds:.0f} s")
    return 0 if score >= AIM else 1


if __name__ == "__main__":
    raise SystemExit(main())
