# SPDX-License-Identifier: Apache-2.0
"""The lab sheets in the page: text, form, and the marks that `mmcs lab check` gives."""

import tomllib

import pytest
from bench import picture, saved, unfold

from mmcs import ensure_library
from mmcs_labs.marks import grade, read_answer
from mmcs_labs.sheets import LABS, find_sheet

ROWS = """() => [...document.querySelectorAll("#lab-marks tbody tr")]
  .map((row) => [...row.cells].map((cell) => cell.textContent))"""


def open_sheet(desk, number: int):
    desk.page.click("#tab-labs")
    unfold(desk.page, "#lab-sheet", str(number))
    sheet = find_sheet(str(number))
    desk.until("t => document.querySelector('.lab-text h1').textContent === t", sheet.title)
    return sheet


def fill(page, answer: dict) -> None:
    """Types as a student does: a list without its brackets, a name without its quotes."""
    for key, value in answer.items():
        pairs = value.items() if isinstance(value, dict) else [("", value)]
        for name, one in pairs:
            text = ", ".join(map(str, one)) if isinstance(one, list) else str(one)
            page.fill(f"[id='lab-{key}{'.' if name else ''}{name}']", text)


def check(desk) -> str:
    desk.page.click("#lab-check")
    desk.until("() => !document.getElementById('lab-check').disabled")
    return desk.page.inner_text("#lab-said")


@pytest.mark.req("TOOL-1")
@pytest.mark.pictures
def test_a_sheet_is_read_answered_and_graded_as_by_the_command(desk, tmp_path):
    ensure_library(1, "speed")  # the page would wait for it, too, but not the test
    page = desk.page
    open_sheet(desk, 2)
    sheet = open_sheet(desk, 1)
    for student in ("bad", "good"):  # the manual has no right answers
        path = LABS / "01_velocity" / "tests" / f"{student}.toml"
        fill(page, tomllib.loads(path.read_text()))
        marks = grade(sheet, read_answer(sheet, path))
        points = sum(mark.points for mark in marks)
        assert check(desk) == f"{points} of 10 points" and points == {"bad": 0, "good": 10}[student]
        assert [(row[0], row[1][2:], row[2]) for row in page.evaluate(ROWS)] == [
            (mark.key, f"{mark.points} of {mark.of}", mark.why) for mark in marks
        ]
        if student == "bad":
            picture(page, "labs")
    saved(page, "#lab-save", tmp_path)
    assert read_answer(sheet, tmp_path) == read_answer(sheet, path)
    page.fill("#lab-mean_cps", "1,5x")
    assert check(desk).startswith("answer.toml: ") and page.is_hidden("#lab-marks")
