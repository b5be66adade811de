# SPDX-License-Identifier: Apache-2.0
"""Breaks the RTL one line at a time and sees that the named test turns red: `make sabotage`.

cocotb_tests/sabotage.toml lists the breakages: a file, the text of one line, what replaces it, and
the tests that must notice. First all named tests must pass on the RTL as it is. Then each breakage
runs on a copy of the RTL below build/sabotage (tools/breakage.py). `--sample N` with `--seed S`
takes a random N, `--only TEXT` those whose name or file holds the text, `--table` writes the
list into the manual. A breakage that does not apply or compile, or whose test stays green, fails.
"""

import argparse
import os
import random
import re
import subprocess
import sys
from pathlib import Path

import breakage
from pages import rewrite

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "evidence" / "verification.md"
LIST = ROOT / "cocotb_tests" / "sabotage.toml"
WORK = ROOT / "build" / "sabotage"
CPU_S = 900  # of processor time for a process of a broken design: it hangs, and that is noticed
WALL_S = 4 * 3600  # a guard against what hangs without computing: that says nothing


def nodes(entry: dict, sim: str) -> list[str]:
    """The pytest ids of an entry's tests on a simulator; the list names Icarus."""
    return [re.sub(r"icarus\]$", f"{sim}]", test) for test in entry["test"].split()]


def pytest(tests: list[str], sim: str, build: Path, rtl: Path | None = None, workers: int = 0):
    env = dict(os.environ, MMCS_BUILD=str(build), MMCS_RANDOM_OPS="2000")
    env |= {"MMCS_RTL": str(rtl)} if rtl else {}
    many = ["-n", str(workers), "--dist", "loadgroup"] if workers else ["-x"]
    limit = ["prlimit", f"--cpu={CPU_S}"] if rtl else []
    return subprocess.run(
        [*limit, sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--sim", sim, *many,
         *tests],
        cwd=ROOT,
        env=env,
        text=True,
        capture_output=True,
        check=False,
        timeout=WALL_S,
    )  # fmt: skip


def verdict(done: subprocess.CompletedProcess) -> str | None:
    """None if a test turned red by what it saw, else what happened instead."""
    out = done.stdout + done.stderr
    if "the design does not build" in out:
        return "the broken design does not compile"
    if re.search(r"\b[1-9]\d* failed\b", out):
        return None
    if done.returncode == 0:
        return "the test stays green"
    return "the test did not run: " + (out.strip().splitlines() or ["no output"])[-1]


def judge(sim: str) -> breakage.Judge:
    """Runs the named tests on the broken copy; one that computes for ever is noticed too."""

    def look(entry: dict, folder: Path) -> tuple[str | None, str]:
        try:
            complaint = verdict(pytest(nodes(entry, sim), sim, folder / "build", folder / "rtl"))
        except subprocess.TimeoutExpired:
            complaint = f"not done after {WALL_S} s"
        return complaint, entry["test"].partition("::")[2]

    return look


def table(entries: list[dict]) -> str:
    lines = ["| block | breakage | red test |", "|---|---|---|"]
    for e in entries:
        block = Path(e["file"]).stem
        tests = ", ".join(
            f"`{Path(t.partition('::')[0]).stem.removeprefix('cocotb_')}::"
            f"{t.partition('::')[2].partition('[')[0]}`"
            for t in e["test"].split()
        )
        lines.append(f"| {block} | {e['name']} | {tests} |")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sim", default="icarus", choices=["icarus", "verilator"])
    parser.add_argument("--sample", type=int, default=0, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="names or files that contain this text")
    parser.add_argument(
        "--table", action="store_true", help="write the list into the manual; run nothing"
    )
    args = parser.parse_args()
    entries = breakage.entries(LIST, args.only)
    if not entries:
        print(f"sabotage: no breakage is called {args.only!r}; see {LIST.name}", file=sys.stderr)
        return 2
    if args.table:
        rewrite(PAGE, "breakages", table(entries))
        return 0
    if args.sample:
        entries = random.Random(args.seed).sample(entries, min(args.sample, len(entries)))
        print(f"sabotage: seed {args.seed}")
    tests = sorted({t for e in entries for t in nodes(e, args.sim)})
    whole = pytest(tests, args.sim, WORK / "whole", workers=os.cpu_count() or 1)
    if whole.returncode:
        print(whole.stdout[-3000:] + whole.stderr, file=sys.stderr)
        print("sabotage: the tests must pass on the RTL as it is, and do not", file=sys.stderr)
        return 1
    print(f"sabotage: {len(tests)} tests pass on the RTL as it is", flush=True)
    return int(breakage.meet("sabotage", entries, judge(args.sim), WORK, ("rtl",)) > 0)


if __name__ == "__main__":
    raise SystemExit(main())
