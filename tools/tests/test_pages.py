# SPDX-License-Identifier: Apache-2.0
"""The parts of pages that programs write: replaced whole, the rest untouched, marks needed."""

import re

import pytest

from mmcs import ROOT
from tools.pages import marks, part, rewrite, splice

PAGE = "before\n<!-- generated: x -->\nold\n<!-- end of x -->\nafter\n"


def test_splice():
    text = splice(PAGE, "x", "\nnew\nlines\n")
    assert text == PAGE.replace("old", "new\nlines")
    assert part(text, "x") == "new\nlines\n" and splice(text, "x", part(text, "x")) == text


def test_a_page_without_the_marks(capsys):
    with pytest.raises(SystemExit):
        splice("nothing", "x", "new")
    assert 'no lines "<!-- generated: x -->"' in capsys.readouterr().err


def test_what_was_measured_says_when(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    rewrite(page, "x", "| 1 |", measured_by="make x")
    assert re.search(r"\*Measured \d{4}-\d\d-\d\d by `make x`\.\*\n\n\| 1 \|", page.read_text())


def test_every_begin_has_its_end():
    for page in (ROOT / "docs").rglob("*.md"):
        text = page.read_text()
        for name in re.findall(r"^<!-- generated: ([^>]+) -->$", text, re.M):
            begin, end = marks(name)
            assert text.count(begin) == text.count(end) == 1, f"{page.name}: {name}"
