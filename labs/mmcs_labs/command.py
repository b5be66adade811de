# SPDX-License-Identifier: Apache-2.0
"""`mmcs lab`: the sheets of a control course, and their answers graded by running the machine."""

import csv
import json
import shlex
import sys
from pathlib import Path

import click

from mmcs import echo, one_line

_number = click.argument("number", metavar="N")


@click.group(invoke_without_command=True)
@click.option("--sheets", "own", type=click.Path(path_type=Path), metavar="DIR",
              help="Own sheets: DIR/NN_name with sheet.md, answer.toml and grader.py.")  # fmt: skip
@click.pass_context
def lab(context, own: Path | None) -> None:
    """List the lab sheets; start one; check an answer, or those of a class."""
    from mmcs_labs.sheets import LABS, sheets

    context.obj = own or LABS
    if context.invoked_subcommand is None:
        for sheet in sheets(context.obj):
            echo(f"{sheet.number:2}  {sheet.name:15} {sheet.title}")


@lab.command()
@_number
@click.argument("folder", metavar="[DIR]", required=False, type=click.Path(path_type=Path))
@click.pass_obj
def start(own: Path, number: str, folder: Path | None) -> None:
    """Make a folder to work in, with the sheet, its scenarios and an empty answer."""
    from mmcs_labs import sheets

    sheet = sheets.find_sheet(number, own)
    made = sheets.start(sheet, folder or Path(sheet.folder.name))
    for path in made:
        echo(str(path))
    answer = made[0].parent / sheets.ANSWER
    again = ("mmcs", "lab", *(() if own == sheets.LABS else ("--sheets", str(own))), "check")
    told = shlex.join([*again, str(sheet.number), str(answer)])
    echo(f"read {made[0].parent / sheets.SHEET}; then {told}")


@lab.command()
@_number
@click.argument("answer", metavar="ANSWER|FOLDER", type=click.Path(path_type=Path))
@click.option("--csv", "form", flag_value="csv", help="A row for each student.")
@click.option("--json", "form", flag_value="json", help="Points and reasons of each student.")
@click.pass_obj
def check(own: Path, number: str, answer: Path, form: str | None) -> None:
    """Grade answers by running them: status 0 all points, 1 some are missing, 2 bad input.

    A FOLDER without an answer.toml holds those of a class: NAME.toml, or NAME/answer.toml.
    """
    from mmcs_labs import marks as lab_marks
    from mmcs_labs.sheets import ANSWER, find_sheet

    sheet = find_sheet(number, own)
    if answer.is_dir() and not (answer / ANSWER).is_file():
        graded = lab_marks.grade_class(sheet, answer)
    else:
        name = answer.parent.name if answer.name == ANSWER else answer.stem
        given = lab_marks.read_answer(sheet, answer)
        graded = {name: lab_marks.grade(sheet, given)}
        if form is None:
            _tell(sheet, graded[name])
            sys.exit(0 if all(mark.points == mark.of for mark in graded[name]) else 1)
    rows = [_row(sheet, name, marks) for name, marks in graded.items()]
    if form == "json":
        echo(json.dumps(rows, indent=1))
    elif form == "csv":
        keys = [question.key for question in lab_marks.questions(sheet)]
        table = csv.DictWriter(sys.stdout, ["student", *keys, "points", "of", "mistake"])
        table.writeheader()
        for row in rows:
            points = {key: mark["points"] for key, mark in row.pop("marks").items()}
            table.writerow({key: _plain(value) for key, value in (row | points).items()})
    else:
        for row in rows:
            why = f"  {row['mistake']}" if row["mistake"] else ""
            echo(f"{row['student']}: {row['points']} of {row['of']} points{why}")
    sys.exit(0 if all(row["points"] == row["of"] for row in rows) else 1)


def _plain(value: object) -> object:
    """A cell that neither a terminal nor a spreadsheet carries out."""
    if not isinstance(value, str):
        return value
    text = one_line(value)
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text


def _tell(sheet, marks) -> None:
    echo(f"lab {sheet.number}, {sheet.title}")
    for mark in marks:
        echo(f"  {mark.points} of {mark.of}  {mark.key}: {mark.why}")
    points, of = sum(mark.points for mark in marks), sum(mark.of for mark in marks)
    echo(f"{points} of {of} points")


def _row(sheet, student: str, marks) -> dict:
    """A student's line; marks may be why the file cannot be graded."""
    from mmcs_labs.marks import questions

    mistake = marks if isinstance(marks, str) else ""
    marks = [] if mistake else marks
    return {
        "student": student,
        "points": sum(mark.points for mark in marks),
        "of": sum(question.points for question in questions(sheet)),
        "mistake": mistake,
        "marks": {mark.key: {"points": mark.points, "why": mark.why} for mark in marks},
    }
