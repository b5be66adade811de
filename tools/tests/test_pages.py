# SPDX-License-Identifier: Apache-2.0
"""Parts of pages that programs write have their marks, runs whole rows, diagrams are fresh."""

import datetime
import re
import sys

import pytest

from mmcs import ROOT
from tools.compiled import ran
from tools.pages import MARK, marks


def test_every_measured_line_has_its_mark():
    for page in (ROOT / "docs").rglob("*.md"):
        for line in re.findall(r"^\*Measured [^|]*?(?:\n\n|\Z)", page.read_text(), re.M):
            assert MARK.search(line), f"{page.name}: {line}"


def test_every_begin_has_its_end():
    for page in (ROOT / "docs").rglob("*.md"):
        text = page.read_text()
        for name in re.findall(r"^<!-- generated: ([^>]+) -->$", text, re.M):
            begin, end = marks(name)
            assert text.count(begin) == text.count(end) == 1, f"{page.name}: {name}"


HEAD = "| date | commit | run | result |\n|---|---|---|---|\n"


def test_rows_of_the_pages_are_whole():
    found = 0
    for page in (ROOT / "docs").rglob("*.md"):
        for table in page.read_text().split(HEAD)[1:]:
            found += 1
            for row in table.partition("\n\n")[0].splitlines():
                _, date, commit, run, result, _ = map(str.strip, row.split("|"))
                datetime.date.fromisoformat(date)
                whole = re.fullmatch("[0-9a-f]{7,12}", commit) and run and MARK.search(result)
                assert whole, f"{page.name}: {row}"
    assert found >= 4


@pytest.mark.slow  # twelve simulations
def test_the_diagrams_are_fresh():
    done = ran(sys.executable, "tools/wavegen.py", "--check")
    assert done.returncode == 0, done.stdout + done.stderr
