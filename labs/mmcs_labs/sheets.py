# SPDX-License-Identifier: Apache-2.0
"""The lab sheets, NN_name/ here or in a folder of the teacher's, and folders to work in."""

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from mmcs import InputError, whole_file

LABS = Path(__file__).resolve().parent
ANSWER, SHEET, GRADER = "answer.toml", "sheet.md", "grader.py"


@dataclass(frozen=True)
class Sheet:
    number: int
    name: str
    folder: Path

    @property
    def files(self) -> list[Path]:
        """What a student is given."""
        return [p for p in sorted(self.folder.iterdir()) if p.is_file() and p.name != GRADER]

    @property
    def title(self) -> str:
        return (read(self.folder / SHEET).splitlines() or [""])[0].removeprefix("# ")


def read(path: Path) -> str:
    """The text of a sheet's file. Raises InputError."""
    try:
        return path.read_text()
    except (OSError, ValueError) as error:
        raise InputError.one(path, "", None, f"cannot be read: {error}") from None


def sheets(folder: Path = LABS) -> list[Sheet]:
    """The sheets of a folder. Raises InputError."""
    found = []
    for path in sorted(folder.glob(f"*/{SHEET}")):
        number, _, name = path.parent.name.partition("_")
        if not re.fullmatch(r"\d{1,3}", number) or not name:
            raise InputError.one(path.parent, "", None, "a sheet's folder is called NN_name")
        for needed in (ANSWER, GRADER):
            if not (path.parent / needed).is_file():
                raise InputError.one(path.parent, "", None, f"a sheet needs a file {needed}")
        found.append(Sheet(int(number), name, path.parent))
        if [s.number for s in found].count(int(number)) > 1:
            raise InputError.one(path.parent, "", None, f"there is another sheet {int(number)}")
    if not found:
        raise InputError.one(folder, "", None, f"holds no sheets: no NN_name/{SHEET} is there")
    return found


def find_sheet(text: str, folder: Path = LABS) -> Sheet:
    """By number or name."""
    known = sheets(folder)
    for sheet in known:
        if text == sheet.name or re.fullmatch(f"0*{sheet.number}", text):
            return sheet
    names = ", ".join(f"{sheet.number} {sheet.name}" for sheet in known)
    raise InputError.one(f'"{text}"', "", None, f"no such lab sheet; there are: {names}")


def start(sheet: Sheet, folder: Path) -> list[Path]:
    """Copies the sheet's files into the folder; what is there already is left alone."""
    for path in sheet.files:
        if (folder / path.name).exists():
            allowed = "is there already, perhaps with your work; name another folder"
            raise InputError.one(folder / path.name, "", None, allowed)
    made: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path in sheet.files:
            with whole_file(folder / path.name) as part:
                shutil.copyfile(path, part)
            made.append(folder / path.name)
        return made
    except OSError as error:
        for path in made:  # they would be told as work at the next try
            path.unlink(missing_ok=True)
        raise InputError.one(folder, "", None, f"cannot be made: {error.strerror}") from None
