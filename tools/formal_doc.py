# SPDX-License-Identifier: Apache-2.0
"""The tables and the picture of docs/formal.md, from the proofs and what they came to."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOC = ROOT / "docs" / "formal.md"
BEGIN, END = "<!-- tools/formal.py --doc -->", "<!-- end -->"
PROVE = re.compile(r"`MMCS_PROVE\s*\(\s*(\w+)\s*,\s*\"([^\"]*)\"\s*,")
TEXT = re.compile(r"\"([^\"]*)\"\s*\)\s*$", re.M)


def property_files(sby: Path) -> list[Path]:
    found = re.findall(r"(formal/\w+_props\.svh?)\s*$", sby.read_text(), re.M)
    return [ROOT / f for f in found]


def properties(sby: Path) -> list[tuple[str, str, str]]:
    """(name, section, sentence) of every property that a .sby file proves."""
    out = []
    for file in property_files(sby):
        text = re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.M)
        for begin in PROVE.finditer(text):
            end = TEXT.search(text, begin.end())
            out.append((begin[1], begin[2], end[1] if end else ""))
    return out


def status(results: list, name: str) -> tuple[str, str]:
    """How a property stands, and the clock in which its cover was reached."""
    prove = [r for r in results if r.mode == "prove"]
    bmc = [r for r in results if r.mode == "bmc"]
    covers = [r.reached[c] for r in results for c in r.reached if c == f"{name}_when"]
    how = "open"
    if prove and all(r.verdict == "PASS" for r in prove):
        how = "proved unbounded"
    elif bmc and all(r.verdict == "PASS" for r in bmc):
        how = f"bounded to {min(r.depth for r in bmc)} clocks"
    return how, f"clock {min(covers)}" if covers else "-"


def table(files: list[Path], results: list, took: float) -> str:
    lines = []
    total = 0
    for file in files:
        mine = [r for r in results if r.group == file.stem]
        title = re.search(r"^# (?!SPDX|slow)(.*)$", file.read_text(), re.M)
        seconds = sum(r.seconds for r in mine)
        lines += [f"### {file.stem}", "", f"{title[1] if title else ''} ({seconds:.0f} s)", ""]
        lines += ["| property | § | says | status | cover |", "|---|---|---|---|---|"]
        for name, section, text in properties(file):
            how, cover = status(mine, name)
            lines.append(f"| {name} | {section} | {text} | {how} | {cover} |")
            total += 1
        lines.append("")
    head = f"{total} properties in {len(files)} groups; the whole run took {took:.0f} s."
    return "\n".join([head, "", *lines])


def write_doc(files: list[Path], results: list, took: float) -> None:
    text = DOC.read_text()
    if BEGIN not in text or END not in text:
        print(f"formal: {DOC.name} has no {BEGIN} ... {END}", file=sys.stderr)
        raise SystemExit(2)
    head, rest = text.split(BEGIN, 1)
    tail = rest.split(END, 1)[1]
    DOC.write_text(f"{head}{BEGIN}\n\n{table(files, results, took)}{END}{tail}")


def picture(_run) -> int:
    print("formal: not drawn yet", file=sys.stderr)
    return 2
