# SPDX-License-Identifier: Apache-2.0
"""The log of runs: the pages show it as it is, and a row that is not whole is refused."""

import pytest

from mmcs import ROOT
from tools import runs

ROW = """
[[long]]
date = 2026-11-22
commit = "0123abc"
run = "`make long`"
result = "12 of 12"
"""


def test_pages_are_fresh():
    for path, whole in runs.pages(runs.load(runs.DATA.read_text())).items():
        assert path.read_text() == whole, f"{path.relative_to(ROOT)} is stale: make generate"


def test_a_row_becomes_a_line():
    lines = runs.table(runs.load(ROW)["long"]).splitlines()
    assert lines[2:] == ["| 2026-11-22 | 0123abc | `make long` | 12 of 12 |"]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('run = "`make long`"\n', "", "has date, commit, result; wanted date, commit, run, result"),
        ("2026-11-22", '"today"', "date is no date such as 2026-11-22, without quotes"),
        ("0123abc", "HEAD", "commit 'HEAD' is not 7 to 12 hex digits"),
        ("12 of 12", "12 | 12", "a cell is one line without '|'"),
    ],
)
def test_refused(old, new, says):
    with pytest.raises(SystemExit, match=r"^runs.toml: \[\[long\]\] .*") as end:
        runs.load(ROW.replace(old, new))
    assert says in str(end.value)


def test_a_table_that_no_page_shows():
    with pytest.raises(SystemExit, match="no page has <!-- generated: runs lost -->"):
        runs.pages({"lost": []})
