# SPDX-License-Identifier: Apache-2.0
"""Joins the requirements (docs/requirements.toml) with the tests that carry their ids.

Writes build/traceability.md; fails on a requirement without a test, a test with an unknown
id, a file that is not there, or a requirement of RTL or driver that has neither a seeded fault
whose test carries its id nor a reason (tools/mutation/faults.toml).
"""

import argparse
import json
import re
import sys
import tempfile
import tomllib
from pathlib import Path

from tools.compiled import ROOT, ran
from tools.mutation import faults

PAGE = ROOT / "build" / "traceability.md"
# Tests that hold no RTL, and what they hold: of a requirement of rtl/ they show nothing.
WITHOUT_RTL = {
    "cocotb_tests/checkers": "the bus checkers alone",
    "cocotb_tests/chips/test_models.py": "the reference models",
    "firmware/tests/test_firmware.py": "the driver before a mock",
    "firmware/tests/test_processors.py": "the same on two processors",
    "mmcs/tests/test_design.py": "control design",
    "mmcs/tests/test_regs.py": "the files that the register map generates",
}


def collect() -> dict[str, list[str]]:
    """{pytest node id: requirement ids}, by pytest's own collection; runs no test."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "req.json"
        options = ("--collect-only", "-qq", "--req-json", out)
        done = ran(sys.executable, "-m", "pytest", *options)
        if done.returncode or not out.is_file():
            sys.exit(f"trace: the tests cannot be collected\n{done.stdout[-3000:]}{done.stderr}")
        return json.loads(out.read_text())


def links(files: list[str]) -> str:
    return ", ".join(f"[{Path(f).name}](../{f})" for f in files)


def in_rtl(requirement: dict) -> bool:
    return any(f.startswith("rtl") for f in requirement["files"])


def holds_rtl(node: str) -> bool:
    return not any(node.startswith((f"{place}::", f"{place}/")) for place in WITHOUT_RTL)


def unseeded(requirements: dict, tests: dict[str, list[str]]) -> list[str]:
    """What the list of seeded faults lacks: a requirement, or its id at a fault's test."""
    listed, without = faults.read()
    rows = [f for f in listed if "req" in f]
    named = [row["req"] for row in rows] + list(without)
    here = {k for k, r in requirements.items() if r["files"][0].startswith(("rtl", "firmware"))}
    out = [f"{k}: wants a fault or one reason in {faults.LIST.name}"
           for k in {*here, *named}
           if k not in requirements or k not in named or (k in without and named.count(k) > 1)
           ]  # fmt: skip
    for row in rows:
        ids = tests.get(re.sub(r"icarus\]$", "verilator]", row["test"]), [])
        if row["req"] not in ids:
            out.append(f"{row['name']}: {row['test']} does not carry {row['req']}")
    return out


def page(requirements: dict, tests: dict[str, list[str]]) -> str:
    lines = ["| id | report § | requirement | implemented in | tests |", "|---|---|---|---|---|"]
    for key, req in requirements.items():
        nodes = [n for n, ids in tests.items() if key in ids and (not in_rtl(req) or holds_rtl(n))]
        held = links(sorted({n.partition("::")[0] for n in nodes}))
        held = held or ("open" if req.get("open") else "**MISSING**")
        cells = (key, req["section"], req["text"], links(req["files"]), held)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(["# Requirements and their tests", "", *lines, ""])


def problems(requirements: dict, tests: dict[str, list[str]]) -> list[str]:
    used = {i for ids in tests.values() for i in ids}
    held = {i for node, ids in tests.items() if holds_rtl(node) for i in ids}
    wanted = {k: r for k, r in requirements.items() if not r.get("open")}
    out = unseeded(requirements, tests)
    out += [f"{f} is not there: WITHOUT_RTL" for f in WITHOUT_RTL if not (ROOT / f).exists()]
    out += [f"{k}: no test carries this id" for k in wanted if k not in used]
    out += [f"{k}: no test that holds RTL carries this id"
            for k, r in requirements.items() if k in used - held and in_rtl(r)]  # fmt: skip
    out += [f"{node}: unknown requirement id {i}"
            for node, ids in tests.items() for i in ids if i not in requirements]  # fmt: skip
    out += [f"{k}: {f} does not exist"
            for k, r in wanted.items() for f in r["files"] if not (ROOT / f).exists()]  # fmt: skip
    return out


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    requirements = tomllib.loads((ROOT / "docs" / "requirements.toml").read_text())
    tests = collect()
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page(requirements, tests))
    found = problems(requirements, tests)
    for line in found:
        print(f"trace: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
