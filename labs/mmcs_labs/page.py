# SPDX-License-Identifier: Apache-2.0
"""The lab sheets for the page: what a student is given, and answers graded as by `mmcs lab check`.

Lines as mmcs/tool/worker.py has them; one process for each page that opens them.

  sheets   number, name and title of each
  sheet    number: html of sheet.md, the fields of its answer, the commands that do the same
  check    number, answer (text of an answer.toml): the marks, points, of
"""

import os
import re
import shlex
import sys
import tempfile
import typing
from dataclasses import asdict
from pathlib import Path

from markdown_it import MarkdownIt
from pydantic import BaseModel

from mmcs import InputError, Worker, work
from mmcs_labs.marks import answer_model, grade, read_answer
from mmcs_labs.sheets import ANSWER, LABS, SHEET, Sheet, find_sheet, read, sheets

POLITE = 10  # the machine in real time, and STOP, come before a grader's runs
FORM = r"^# {key} = (.*?)(?:\s+# (.*))?$"  # of a field in answer.toml


def listed(folder: Path = LABS) -> list[dict]:
    """Raises InputError."""
    return [{"number": s.number, "name": s.name, "title": s.title} for s in sheets(folder)]


def told(sheet: Sheet) -> dict:
    """What a student is given of a sheet. Raises InputError."""
    text, form = read(sheet.folder / SHEET), read(sheet.folder / ANSWER)
    html = MarkdownIt("commonmark", {"html": False}).enable("table").render(text)
    return {"number": sheet.number, "html": html, "fields": _fields(answer_model(sheet), form),
            **_commands(sheet)}  # fmt: skip


def everything() -> dict:
    """For a page without Python: web/engine/labs.js."""
    return {"sheets": listed(), "sheet": {one.number: told(one) for one in sheets()}}


def _commands(sheet: Sheet) -> dict:
    own = sheet.folder.parent
    lab = "mmcs lab" if own == LABS else f"mmcs lab --sheets {shlex.quote(str(own))}"
    return {"start": f"{lab} start {sheet.number}", "check": f"{lab} check {sheet.number} {ANSWER}"}


def _fields(model: type[BaseModel], form: str) -> list[dict]:
    """Of an answer: key, what its answer.toml says of it, and the keys inside a table."""
    found = []
    for key, field in model.model_fields.items():
        line = re.search(FORM.format(key=re.escape(key)), form, re.MULTILINE)
        example, hint = line.groups() if line else ("", "")
        kinds = (field.annotation, *typing.get_args(field.annotation))
        table = [k for k in kinds if isinstance(k, type) and issubclass(k, BaseModel)]
        members = list(table[0].model_fields) if table else []
        found.append({"key": key, "example": example, "hint": hint or "", "members": members})
    return found


class Labs(Worker):
    def __init__(self, folder: Path = LABS, out=sys.stdout):
        super().__init__(out)
        self.folder = folder

    def _sheet(self, message: dict) -> Sheet:
        return find_sheet(str(message["number"]), self.folder)

    def do_sheets(self, message: dict) -> dict:
        return {"sheets": listed(self.folder)}

    def do_sheet(self, message: dict) -> dict:
        return told(self._sheet(message))

    def do_check(self, message: dict) -> dict:
        """A file is written, and graded as any other."""
        sheet = self._sheet(message)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / ANSWER
            path.write_text(message["answer"])
            try:
                answer = read_answer(sheet, path)
            except InputError as error:
                words = "; ".join(str(m).replace(str(path), ANSWER, 1) for m in error.mistakes)
                raise ValueError(words) from None
        marks = grade(sheet, answer)
        return {
            "marks": [asdict(mark) for mark in marks],
            "points": sum(mark.points for mark in marks),
            "of": sum(mark.of for mark in marks),
        }


if __name__ == "__main__":
    os.nice(POLITE)
    work(Labs(*map(Path, sys.argv[1:])))
