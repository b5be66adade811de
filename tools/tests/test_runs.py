# SPDX-License-Identifier: Apache-2.0
"""The tables of runs in the pages: each row says when, of which commit, what was run, what came,
and of what folders: the mark that `make docs` tells its age by."""

import datetime
import re

import pytest

from mmcs import ROOT
from tools.pages import MARK

HEAD = "| date | commit | run | result |\n|---|---|---|---|\n"


def faults(text: str) -> list[str]:
    rows = [row for part in text.split(HEAD)[1:] for row in part.partition("\n\n")[0].splitlines()]
    return [row for row in rows if not _is_whole(row.split("|"))]


def _is_whole(cells: list[str]) -> bool:
    try:
        _, date, commit, run, result, _ = map(str.strip, cells)
        datetime.date.fromisoformat(date)
    except ValueError:
        return False
    return bool(re.fullmatch("[0-9a-f]{7,12}", commit) and run and MARK.search(result))


def test_rows_of_the_pages_are_whole():
    pages = {page: page.read_text() for page in (ROOT / "docs").rglob("*.md")}
    assert sum(text.count(HEAD) for text in pages.values()) >= 4
    assert {page.name: bad for page, text in pages.items() if (bad := faults(text))} == {}


OF = "<!-- of rtl@01234567 -->"
BAD = (
    f"| today | 0123abc | x | y {OF} |", f"| 2026-11-22 | HEAD | x | y {OF} |",
    f"| 2026-11-22 | 0123abc | | y {OF} |", "| 2026-11-22 | 0123abc | x |",
    "| 2026-11-22 | 0123abc | x | y |",
)  # fmt: skip


@pytest.mark.parametrize("row", BAD)
def test_a_row_that_is_not(row):
    good = f"| 2026-11-22 | 0123abc | `make x` | 12 of 12 {OF} |"
    assert faults(f"{HEAD}{good}\n{row}\n\nmore") == [row]
