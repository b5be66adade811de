# SPDX-License-Identifier: Apache-2.0
"""Line, branch and toggle coverage of rtl/: `make coverage`.

Runs the cocotb regression on coverage builds, merges what every simulation wrote, and makes
build/coverage/report.txt. Points that cannot be reached stand in
cocotb_tests/coverage_exceptions.toml, each with its reason; one that was reached after all, or
whose line is gone, fails.
`--only TEXT` runs tests whose name, file or folder holds the text, tells what each file reached,
and judges nothing.
"""

import argparse
import fnmatch
import os
import re
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "coverage"
EXCEPTIONS = ROOT / "cocotb_tests" / "coverage_exceptions.toml"
GOALS = {"line": 100.0, "branch": 100.0, "toggle": 95.0}
SHOWN = 60  # complaints on the terminal


def parse(path: Path):
    """Yields (file, line, kind, what, count) from one coverage.dat of Verilator."""
    for raw in path.read_text(errors="replace").splitlines():
        if not raw.startswith("C '"):
            continue
        text, count = raw[3:].rsplit("' ", 1)
        fields = dict(part.split("\x02", 1) for part in text.split("\x01") if "\x02" in part)
        kind = fields.get("page", "").split("/")[0].removeprefix("v_")
        name = fields["f"].removeprefix(f"{ROOT}/")
        if kind in GOALS and name.startswith("rtl/"):
            what = f"{fields.get('n', '')} {fields.get('o', '')}".strip()
            yield name, int(fields["l"]), kind, what, int(count)


def merge(folder: Path) -> Counter:
    total: Counter = Counter()
    for path in folder.rglob("coverage.dat"):
        for *point, count in parse(path):
            total[tuple(point)] += count
    return total


class Exceptions:
    """What need not be reached: `file` and `kind` with wildcards, the line by text or `match`."""

    def __init__(self, path: Path) -> None:
        self.entries = tomllib.loads(path.read_text())["exception"]
        self.used: Counter = Counter()

    def reason(self, name: str, text: str, kind: str, what: str) -> str | None:
        for n, e in enumerate(self.entries):
            if (
                fnmatch.fnmatch(name, e["file"])
                and fnmatch.fnmatch(kind, e.get("kind", "*"))
                and ("line" not in e or e["line"].strip() == text.strip())
                and re.search(e.get("match", ""), text)
                and re.search(e.get("what", ""), what)
            ):
                self.used[n] += 1
                return e["reason"]
        return None

    def idle(self) -> list[str]:
        return [
            f"{e['file']}: exception for what is gone or covered: "
            f"{e.get('line') or e.get('match') or e.get('what') or e['reason']}"
            for n, e in enumerate(self.entries)
            if not self.used[n]
        ]


def structural(points: Counter) -> tuple[list[str], dict, dict, dict, Exceptions]:
    """Complaints; per file the figures and the listing; the sums."""
    allowed = Exceptions(EXCEPTIONS)
    problems, listings, files = [], {}, {}
    sums = {k: [0, 0, 0] for k in GOALS}  # reached, all, excepted
    by_file = defaultdict(lambda: defaultdict(list))
    for (name, line, kind, what), count in points.items():
        by_file[name][line].append((kind, what, count))
    for name in sorted(by_file):
        tally, rows = {k: [0, 0, 0] for k in GOALS}, []
        for n, text in enumerate((ROOT / name).read_text().splitlines(), 1):
            missed, reasons = [], set()
            for kind, what, count in by_file[name][n]:
                reason = None if count else allowed.reason(name, text, kind, what)
                tally[kind][2] += reason is not None
                tally[kind][1] += reason is None
                tally[kind][0] += count > 0
                if reason:
                    reasons.add(reason)
                elif not count:
                    missed.append(f"{kind} {what}")
                    if kind != "toggle":
                        problems.append(f"{name}:{n}: {kind} {what} not reached: {text.strip()}")
            state = "!" if missed else "-" if reasons else "+" if by_file[name][n] else " "
            note = ", ".join(missed[:8]) or "; ".join(reasons)
            rows.append(f"{state}{n:4d} {text}" + (f"  // {note}" if note else ""))
        listings[name] = rows
        files[name] = {k: "{}/{}".format(*tally[k]) for k in GOALS}
        for kind in GOALS:
            sums[kind] = [a + b for a, b in zip(sums[kind], tally[kind], strict=True)]
    return problems + allowed.idle(), files, listings, sums, allowed


def report(points: Counter, some: bool) -> int:
    """Of all tests a judgement, of some what each file reached."""
    problems, files, listings, sums, allowed = structural(points)
    told = {name: f"{name:32s} " + ", ".join(f"{k} {reached[k]}" for k in GOALS)
            for name, reached in files.items()}  # fmt: skip
    parts = ["\n".join([told[name], *rows, ""]) for name, rows in listings.items()]
    (BUILD / "report.txt").write_text("\n".join([*told.values(), "", *parts]))
    if some:
        for line in told.values():
            print(f"coverage: {line}")
        print("coverage: of some tests alone; report in build/coverage/report.txt")
        return 0
    for line in problems[:SHOWN]:
        print(f"coverage: {line}", file=sys.stderr)
    ok = not problems
    for kind, goal in GOALS.items():
        hit, all_, excepted = sums[kind]
        percent = 100 * hit / all_ if all_ else 0.0
        ok &= percent >= goal
        told = f"{percent:6.2f} % ({hit} of {all_}), goal {goal:g} %; {excepted} points excepted"
        print(f"coverage: {kind:6s} {told}")
    print(f"coverage: {len(allowed.entries)} exceptions; report in build/coverage/report.txt")
    return 0 if ok else 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", metavar="TEXT", help="tests that -k TEXT chooses")
    args = parser.parse_args()
    for old in BUILD.rglob("coverage.dat"):
        old.unlink()  # what an earlier run, or an earlier design, has reached
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "loadgroup"]
    command += ["--rtl-coverage", "cocotb_tests", "-k", args.only]
    env = {"MMCS_RANDOM_OPS": "2000"} | os.environ | {"MMCS_BUILD": str(BUILD)}
    if subprocess.run(command, cwd=ROOT, env=env, check=False).returncode:
        print("coverage: the tests fail; coverage of failing tests means nothing", file=sys.stderr)
        return 1
    return report(merge(BUILD), some=bool(args.only))


if __name__ == "__main__":
    raise SystemExit(main())
