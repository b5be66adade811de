# SPDX-License-Identifier: Apache-2.0
"""What runs have measured: docs/evidence/runs.toml, drawn as dated tables into the pages.

A page shows the table NAME between `<!-- generated: runs NAME -->` and its end. `make generate`
runs this; a test holds the pages fresh.
"""

from __future__ import annotations

import argparse
import datetime
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tools.pages import marks, splice  # noqa: E402

DATA = ROOT / "docs" / "evidence" / "runs.toml"
FIELDS = ("date", "commit", "run", "result")


def load(text: str) -> dict[str, list[dict]]:
    """The tables; a row that is not whole ends with a sentence."""
    tables = tomllib.loads(text)
    for name, rows in tables.items():
        for row in rows:
            told = f"runs.toml: [[{name}]] {row.get('run', '')!r}"
            if tuple(row) != FIELDS:
                raise SystemExit(f"{told}: has {', '.join(row)}; wanted {', '.join(FIELDS)}")
            if not isinstance(row["date"], datetime.date):
                raise SystemExit(f"{told}: date is no date such as 2026-11-22, without quotes")
            if not re.fullmatch(r"[0-9a-f]{7,12}", row["commit"]):
                raise SystemExit(f"{told}: commit {row['commit']!r} is not 7 to 12 hex digits")
            if any("|" in row[f] or "\n" in row[f].strip() for f in ("run", "result")):
                raise SystemExit(f"{told}: a cell is one line without '|'")
    return tables


def table(rows: list[dict]) -> str:
    head = ["| date | commit | run | result |", "|---|---|---|---|"]
    return "\n".join(
        head + ["| " + " | ".join(str(r[f]).strip() for f in FIELDS) + " |" for r in rows]
    )


def pages(tables: dict[str, list[dict]]) -> dict[Path, str]:
    """Each page that shows a table, as it should be; a table that no page shows ends it."""
    found, shown = {}, set()
    for path in sorted((ROOT / "docs").rglob("*.md")):
        text = path.read_text()
        here = [name for name in tables if marks(f"runs {name}")[0] in text]
        for name in here:
            text = splice(text, f"runs {name}", table(tables[name]))
        shown.update(here)
        if here:
            found[path] = text
    if lost := sorted(set(tables) - shown):
        raise SystemExit(f"runs.toml: no page has <!-- generated: runs {lost[0]} -->")
    return found


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for page, whole in pages(load(DATA.read_text())).items():
        page.write_text(whole)
