# SPDX-License-Identifier: Apache-2.0
"""`mmcs lab`: the sheets of a control course, and their answers graded by running the machine."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from mmcs.screen import echo

_number = click.argument("number", metavar="N")


@click.group(invoke_without_command=True)
@click.pass_context
def lab(context) -> None:
    """List the lab sheets; start one; check an answer."""
    if context.invoked_subcommand is None:
        from mmcs.lab.sheets import sheets

        for sheet in sheets():
            echo(f"{sheet.number:2}  {sheet.name:15} {sheet.title}")


@lab.command()
@_number
@click.argument("folder", metavar="[DIR]", required=False, type=click.Path(path_type=Path))
def start(number: str, folder: Path | None) -> None:
    """Make a folder to work in, with the sheet, its scenarios and an empty answer."""
    from mmcs.lab import sheets

    sheet = sheets.find_sheet(number)
    made = sheets.start(sheet, folder or Path(sheet.folder.name))
    for path in made:
        echo(str(path))
    echo(f"read {made[0].parent / sheets.SHEET}; then mmcs lab check {sheet.number} "
         f"{made[0].parent / sheets.ANSWER}")  # fmt: skip


@lab.command()
@_number
@click.argument("answer", metavar="ANSWER", type=click.Path(path_type=Path))
def check(number: str, answer: Path) -> None:
    """Grade an answer by running it: status 0 all points, 1 some are missing, 2 bad input."""
    from mmcs.lab.marks import grade, read_answer
    from mmcs.lab.sheets import find_sheet

    sheet = find_sheet(number)
    given = read_answer(sheet, answer)
    echo(f"lab {sheet.number}, {sheet.title}")
    marks = grade(sheet, given)
    for mark in marks:
        echo(f"  {mark.points} of {mark.of}  {mark.key}: {mark.why}")
    points, of = sum(mark.points for mark in marks), sum(mark.of for mark in marks)
    echo(f"{points} of {of} points")
    sys.exit(0 if points == of else 1)
