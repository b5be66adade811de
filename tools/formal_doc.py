# SPDX-License-Identifier: Apache-2.0
"""The tables and the picture of docs/evidence/formal.md, from the proofs and what they came to."""

import re
from datetime import date
from pathlib import Path

from pywellen import Waveform

from tools.pages import rewrite
from tools.wavedraw import Line, svg
from tools.wavegen import number

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "counterexample.svg"
STEP, CLOCK_PS = 10, 125_000  # of the trace; of a clock at 8 MHz
DOC = ROOT / "docs" / "evidence" / "formal.md"
PROVE = re.compile(r"`MMCS_PROVE\s*\(\s*(\w+)\s*,\s*\"([^\"]*)\"\s*,")
RULE = re.compile(r"`MMCS_RULE\(\d+, (\w+),[^`]*?\"([^\"]*)\"\)", re.S)
TEXT = re.compile(r"\"([^\"]*)\"\s*\)\s*$", re.M)


def property_files(sby: Path) -> list[Path]:
    found = re.findall(r"\b(\w+_props\.sv)\b", sby.read_text())
    return [ROOT / "formal" / f for f in found]


def properties(sby: Path) -> list[tuple[str, str, str]]:
    """(name, section, sentence) of every property that a .sby file proves.

    `# rules:` in the .sby file names the bus checkers whose rules are proved as well, `# wires:`
    those of them that a wire of the design fulfils by itself: they are no properties.
    """
    out = []
    for file in property_files(sby):
        text = re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.M)
        for begin in PROVE.finditer(text):
            end = TEXT.search(text, begin.end())
            out.append((begin[1], begin[2], end[1] if end else ""))
    wires = re.findall(r"\w+", "".join(re.findall(r"^# wires: (.*)$", sby.read_text(), re.M)))
    named = re.search(r"^# rules: (.*)$", sby.read_text(), re.M)
    for checker in named[1].split() if named else []:
        text = (ROOT / "rtl" / "checkers" / f"{checker}.sv").read_text()
        section = re.search(r"§([\d.]+)", text)
        told = [(n, t) for n, t in RULE.findall(text) if n not in wires]
        out += [(f"{checker}: {n}", section[1], t) for n, t in told]
    return out


def status(results: list, name: str) -> tuple[str, str]:
    """How a property stands, and the clock in which its cover was reached."""
    prove = [r for r in results if r.mode == "prove"]
    bmc = [r for r in results if r.mode == "bmc"]
    covers = [r.reached[c] for r in results for c in r.reached if c == f"{name}_when"]
    how = ", ".join(sorted({r.verdict for r in prove + bmc if r.verdict != "PASS"})) or "open"
    if prove and all(r.verdict == "PASS" for r in prove):
        how = "proved unbounded"
    elif bmc and all(r.verdict == "PASS" for r in bmc):
        how = f"bounded to {min(r.depth for r in bmc)} clocks"
    return how, f"clock {min(covers)}" if covers else "-"


def sections(files: list[Path], results: list) -> dict[str, str]:
    """What the page says of each group."""
    out = {}
    for file in files:
        mine = [r for r in results if r.group == file.stem]
        title = re.search(r"^# (?!SPDX|slow|rules|wires)(.*)$", file.read_text(), re.M)
        seconds = sum(r.seconds for r in mine)
        lines = [f"### {file.stem}", "", f"{title[1] if title else ''} ({seconds:.0f} s)", ""]
        lines += ["| property | § | says | status | cover |", "|---|---|---|---|---|"]
        for name, section, text in properties(file):
            how, cover = status(mine, name)
            lines.append(f"| {name} | {section} | {text} | {how} | {cover} |")
        out[file.stem] = "\n".join([*lines, "", *(f"* Given: {x}." for x in givens(file)), ""])
    return out


def write_doc(files: list[Path], results: list, took: float, cpu: float, whole: bool) -> None:
    """The sections of these groups; those of others stay as they were written."""
    page = DOC.read_text().partition("<!-- generated: proofs -->\n")[2]
    groups = sorted((ROOT / "formal").glob("*.sby"))
    head, *old = page.partition("<!-- end of proofs")[0].split("\n### ")
    every = {x.partition("\n")[0]: "### " + x for x in old} | sections(files, results)
    told = [every[g.stem].rstrip("\n") + "\n" for g in groups if g.stem in every]
    if whole:
        head = (
            f"The whole run of {date.today()} took {took:.0f} s on a machine that had other work,"
        )
        head += f" {cpu:.0f} s of processor time."
    said = head[head.index("The whole run") :].rstrip("\n")
    total = sum(len(properties(g)) for g in groups)
    head = f"{total} properties in {len(groups)} groups. {said}\n"
    rewrite(DOC, "proofs", "\n".join([head, *told]))


def givens(sby: Path) -> list[str]:
    """What a group assumes of its surroundings."""
    out = []
    for file in property_files(sby):
        text = re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.M)
        for begin in re.finditer(r"`MMCS_GIVEN\(", text):
            end = TEXT.search(text, begin.end())
            out.append(end[1] if end else "")
    return [text for text in out if len(text) > 1]


def read_vcd(file: Path, names: dict[str, str]) -> list[Line]:
    """The named signals of the top scope, one value per clock; times are those of the trace."""
    found = {var.full_name.partition(".")[2]: var for var in Waveform(str(file)).all_vars()}
    lines = []
    for name, label in names.items():
        width = found[name].length
        changes = [(at * CLOCK_PS // STEP, number(value)) for at, value in found[name].signal]
        lines.append(Line(label, "bit" if width == 1 else "hex", width, changes))
    return lines


def picture(entry: dict, trace: Path) -> None:
    """Draws the counter-example of one breakage."""
    lines = read_vcd(trace, entry["picture"])
    end = max(line.changes[-1][0] for line in lines) + CLOCK_PS
    title = f"Counter-example to {entry['proof']['property']}: {entry['name']}"
    PICTURE.write_text(svg(title, lines, 0, end))
    print(f"formal: {PICTURE.relative_to(ROOT)}")
