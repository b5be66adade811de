# SPDX-License-Identifier: Apache-2.0
"""Parts of pages that programs write: replaced whole, the rest as it was; whole rows of runs."""

import datetime
import re
import sys

import pytest

from mmcs import ROOT
from tools import pages
from tools.compiled import ran
from tools.pages import MARK, aged, marks, old_ones, part, rewrite, splice

PAGE = "before\n<!-- generated: x -->\nold\n<!-- end of x -->\nafter\n"


def test_splice():
    text = splice(PAGE, "x", "\nnew\nlines\n")
    assert text == PAGE.replace("old", "new\nlines")
    assert part(text, "x") == "new\nlines\n" and splice(text, "x", part(text, "x")) == text


def test_a_page_without_the_marks(capsys):
    with pytest.raises(SystemExit):
        splice("nothing", "x", "new")
    assert 'no lines "<!-- generated: x -->"' in capsys.readouterr().err


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A checkout of another project: two folders, one commit, one page with a measured table."""
    monkeypatch.setattr(pages, "ROOT", tmp_path)
    for name in ("rtl/a.sv", "sim/b.cpp"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text("one\n")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "page.md").write_text(PAGE)
    commit(tmp_path)
    return tmp_path


def commit(tree) -> None:
    git = ["git", "-C", tree, "-c", "user.name=x", "-c", "user.email=x@x"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "x"]):
        ran(*git, *words, check=True)


def test_a_measured_table_tells_its_age(tree):
    page = tree / "docs" / "page.md"
    rewrite(page, "x", "| 1 |", "make x", "rtl sim")
    text = page.read_text()
    told = r"\*Measured \d{4}-\d\d-\d\d at [0-9a-f]{7,} by `make x`\.\* <!-- of "
    assert re.search(told + r"rtl@\w{8} sim@\w{8} -->\n\n\| 1 \|", text)
    assert "Nothing of it changed since" in aged(text) and old_ones() == []
    (tree / "rtl" / "a.sv").write_text("two\n")
    (tree / "docs" / "more.md").write_text("a page changes no figure\n")
    commit(tree)
    assert "**Changed since: `rtl`.**" in aged(text) and "sim" not in aged(text).split("x`.*")[1]
    assert len(old_ones()) == 1 and old_ones()[0].endswith("changed: rtl")
    with pytest.raises(SystemExit, match="rtl sim changed while they were measured"):
        rewrite(page, "x", "| 2 |", "make x", "rtl sim")
    (tree / "sim" / "b.cpp").unlink()
    commit(tree)
    assert "**Changed since: `rtl`, `sim`.**" in aged(text)


def test_no_figure_is_of_changes_that_no_commit_has(tree):
    (tree / "rtl" / "a.sv").write_text("two\n")
    with pytest.raises(SystemExit, match="a figure is of a commit, and rtl/a.sv is changed"):
        rewrite(tree / "docs" / "page.md", "x", "| 1 |", "make x", "rtl sim")
    assert (tree / "docs" / "page.md").read_text() == PAGE
    with pytest.raises(SystemExit, match="HEAD has no gone"):
        rewrite(tree / "docs" / "page.md", "x", "| 1 |", "make x", "gone sim")


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


@pytest.mark.slow  # twelve simulations
def test_the_diagrams_are_fresh():
    done = ran(sys.executable, "tools/wavegen.py", "--check")
    assert done.returncode == 0, done.stdout + done.stderr
