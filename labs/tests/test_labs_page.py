# SPDX-License-Identifier: Apache-2.0
"""The lab sheets of the page, without a browser: what is given, and one way of grading."""

import io
import json
import shutil
from dataclasses import asdict
from pathlib import Path

import pytest

from mmcs.tests.conftest import call, one_clear_line
from mmcs_labs.marks import answer_model, grade, read_answer
from mmcs_labs.page import Labs, told
from mmcs_labs.sheets import LABS, find_sheet

pytestmark = pytest.mark.req("TOOL-1")


def ask(folder: Path, **message) -> dict:
    out = io.StringIO()
    Labs(folder, out).run([json.dumps({"id": 1, **message})])
    return json.loads(out.getvalue())


def test_the_page_is_given_what_a_student_is(sheet):
    given = told(sheet)
    text = (sheet.folder / "sheet.md").read_text()
    assert given["html"].count("<code class=") == text.count("```") // 2
    assert [field["key"] for field in given["fields"]] == list(answer_model(sheet).model_fields)
    assert all(field["example"] for field in given["fields"])
    assert given["check"] == f"mmcs lab check {sheet.number} answer.toml"


@pytest.mark.parametrize("student", ["good", "bad"])
def test_the_page_s_marks_are_those_of_the_command(student):
    path = LABS / "01_velocity" / "tests" / f"{student}.toml"
    found = ask(LABS, op="check", number=1, answer=path.read_text())
    sheet = find_sheet("1")
    assert found["marks"] == [asdict(mark) for mark in grade(sheet, read_answer(sheet, path))]
    assert f"{found['points']} of {found['of']} points" in call("lab", "check", 1, path)[1]


@pytest.mark.parametrize(("message", "word"), [
    ({"op": "check", "number": 7, "answer": "stall_ms = x"}, "answer.toml: line 1, column 12"),
    ({"op": "check", "number": 7, "answer": 'stall_ms = "x"'}, "stall_ms"),
    ({"op": "check", "number": 7, "answer": 5}, "check"),
    ({"op": "check", "number": 7}, "answer"),
    ({"op": "sheet", "number": 77}, "no such lab sheet"),
    ({"op": "sheet", "number": "../7"}, "no such lab sheet"),
])  # fmt: skip
def test_a_bad_answer_is_one_sentence_without_a_path(message, word):
    error = ask(LABS, **message)["error"]
    assert word in error and "/" not in error.replace("../7", "") and "\n" not in error


def test_own_sheets_come_without_html_and_without_their_grader(own_sheets):
    """What is raw HTML in a sheet stands there as text."""
    path = next(own_sheets.glob("*/sheet.md"))
    path.write_text("# A gain\n\n<script>alert(1)</script> [x](javascript:alert(1))\n")
    assert ask(own_sheets, op="sheets")["sheets"] == [
        {"number": 1, "name": "gain", "title": "A gain"}
    ]
    given = ask(own_sheets, op="sheet", number=1)
    assert "<script" not in given["html"] and "href" not in given["html"]
    assert [field["members"][:2] for field in given["fields"]] == [[], ["a0", "a1"]]
    assert str(own_sheets) in given["check"]
    assert ask(own_sheets, op="check", number=1, answer="final = 200")["of"] == 10
    shutil.rmtree(path.parent)
    assert "holds no sheets" in ask(own_sheets, op="sheets")["error"]
    one_clear_line(call("tool", "--sheets", own_sheets, "--no-browser"), "holds no sheets")
