# SPDX-License-Identifier: Apache-2.0
"""Joins the requirements (docs/requirements.toml) with the tests that carry their ids.

Writes docs/evidence/traceability.md; fails on a requirement without a test, a test with an unknown
id, a file that is not there, or a requirement of rtl/ without a breakage whose test carries its id
(tools/breakage/list.toml).
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

from tools.breakage import run as breakages
from tools.pages import fill

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "evidence" / "traceability.md"
NONE = {"files": []}
# Tests that hold no RTL, and what they hold: of a requirement of rtl/ they show nothing.
WITHOUT_RTL = {
    "cocotb_tests/checkers": "the bus checkers alone",
    "cocotb_tests/chips/test_models.py": "the reference models",
    "firmware/tests/test_firmware.py": "the driver before a mock",
    "firmware/tests/test_processors.py": "the same on two processors",
    "mmcs/tests/test_design.py": "control design",
    "mmcs/tests/test_regs.py": "the files that the register map generates",
    "tools/tests/test_fpga.py": "what elaborates, and does not run",
}


def collect() -> dict[str, list[str]]:
    """{pytest node id: requirement ids}, by pytest's own collection; runs no test."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "req.json"
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "--collect-only", "-qq", "--req-json", out],
            cwd=ROOT,
            text=True,
            capture_output=True,
            check=False,
        )
        if done.returncode or not out.is_file():
            sys.exit(f"trace: the tests cannot be collected\n{done.stdout[-3000:]}{done.stderr}")
        return json.loads(out.read_text())


def test_files(nodes: list[str]) -> list[str]:
    """Test files with the number of tests in each, for one requirement."""
    count = defaultdict(set)
    for node in nodes:
        file, _, name = node.partition("::")
        count[file].add(re.sub(r"\[(verilator|icarus)\]$", "", name))
    return [f"[{Path(f).name}](../../{f}) ({len(names)})" for f, names in sorted(count.items())]


def in_rtl(requirement: dict) -> bool:
    return any(f.startswith("rtl") for f in requirement["files"])


def holds_rtl(node: str) -> bool:
    return not any(node.startswith((f"{place}::", f"{place}/")) for place in WITHOUT_RTL)


def unbroken(requirements: dict, tests: dict[str, list[str]], rows: list[dict]) -> list[str]:
    """What a list of breakages lacks: a requirement of rtl/, or its id at a row's test."""
    named = {row["req"] for row in rows}
    out = [f"{k}: no breakage of {breakages.LIST.name} breaks it" for k, r in requirements.items()
           if in_rtl(r) and k not in named]  # fmt: skip
    for row in rows:
        for test in row["test"].split():
            ids = tests.get(re.sub(r"icarus\]$", "verilator]", test), [])
            if row["req"] not in ids:
                out.append(f"{row['name']}: {test} does not carry {row['req']}")
    return out


def shown(requirement: dict, nodes: list[str]) -> str:
    """The tests of a requirement; if it is one of rtl/, those without RTL apart."""
    rest = [n for n in nodes if in_rtl(requirement) and not holds_rtl(n)]
    held = ", ".join(test_files([n for n in nodes if n not in rest]))
    held = held or ("open" if requirement.get("open") else "**MISSING**")
    return held + (f"; without RTL: {', '.join(test_files(rest))}" if rest else "")


def page(requirements: dict, tests: dict[str, list[str]], rows: list[dict]) -> str:
    broken = Counter(row["req"] for row in rows)
    lines = [
        "| id | report § | requirement | implemented in | tests | breakages |",
        "|---|---|---|---|---|---|",
    ]
    for key, req in requirements.items():
        nodes = [n for n, ids in tests.items() if key in ids]
        files = ", ".join(
            f"[{Path(f).name}](../../{f})" for f in req["files"] if (ROOT / f).exists()
        )
        row = (key, req["section"], req["text"], files, shown(req, nodes), str(broken[key] or ""))
        lines.append(f"| {' | '.join(row)} |")
    covered = sum(any(k in ids for ids in tests.values()) for k in requirements)
    entries = [n for n, ids in tests.items() for i in ids if in_rtl(requirements.get(i, NONE))]
    without = sum(not holds_rtl(n) for n in entries)
    lines += [
        "",
        f"{covered} of {len(requirements)} requirements have tests. Of {len(entries)} entries of",
        f"requirements in `rtl/` {without} hold no RTL and do not count:",
        "",
        *(f"* `{file}` holds {what}" for file, what in WITHOUT_RTL.items()),
    ]
    return fill(PAGE, {"requirements": lines})


def problems(requirements: dict, tests: dict[str, list[str]], rows: list[dict]) -> list[str]:
    used = {i for ids in tests.values() for i in ids}
    held = {i for node, ids in tests.items() if holds_rtl(node) for i in ids}
    out = [
        f"{k}: no test that holds RTL carries this id"
        for k, r in requirements.items()
        if k in used - held and in_rtl(r)
    ]
    out += unbroken(requirements, tests, rows)
    out += [f"{f} is not there: WITHOUT_RTL" for f in WITHOUT_RTL if not (ROOT / f).exists()]
    out += [
        f"{k}: no test carries this id"
        for k, r in requirements.items()
        if k not in used and not r.get("open")
    ]
    out += [
        f"{node}: unknown requirement id {i}"
        for node, ids in tests.items()
        for i in ids
        if i not in requirements
    ]
    out += [
        f"{k}: {f} does not exist"
        for k, r in requirements.items()
        if not r.get("open")
        for f in r["files"]
        if not (ROOT / f).exists()
    ]
    return out


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; a stale page fails")
    check = parser.parse_args().check
    requirements = tomllib.loads((ROOT / "docs" / "requirements.toml").read_text())
    tests = collect()
    rows = [e for e in breakages.entries("tests") if "test" in e]
    text = page(requirements, tests, rows)
    found = problems(requirements, tests, rows)
    if check:
        if PAGE.read_text() != text:
            found.append("docs/evidence/traceability.md is stale: run `make generate`")
    else:
        PAGE.write_text(text)
    for line in found:
        print(f"trace: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
