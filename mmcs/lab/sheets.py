# SPDX-License-Identifier: Apache-2.0
"""Finds the lab sheets, docs/labs/NN_name/, and makes folders to work in."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from mmcs.errors import InputError
from mmcs.place import ROOT

LABS = ROOT / "docs" / "labs"
ANSWER, SHEET = "answer.toml", "sheet.md"


@dataclass(frozen=True)
class Sheet:
    number: int
    name: str
    folder: Path

    @property
    def title(self) -> str:
        return (self.folder / SHEET).read_text().splitlines()[0].removeprefix("# ")


def sheets() -> list[Sheet]:
    found = []
    for path in sorted(LABS.glob(f"*/{SHEET}")):
        number, _, name = path.parent.name.partition("_")
        found.append(Sheet(int(number), name, path.parent))
    return found


def find_sheet(text: str) -> Sheet:
    """By number or name."""
    known = sheets()
    for sheet in known:
        if text == sheet.name or re.fullmatch(f"0*{sheet.number}", text):
            return sheet
    names = ", ".join(f"{sheet.number} {sheet.name}" for sheet in known)
    raise InputError.one(f'"{text}"', "", None, f"no such lab sheet; there are: {names}")


def start(sheet: Sheet, folder: Path) -> list[Path]:
    """Copies the sheet's files into the folder; what is there already is left alone."""
    for path in sorted(sheet.folder.iterdir()):
        if (folder / path.name).exists():
            allowed = "is there already, perhaps with your work; name another folder"
            raise InputError.one(folder / path.name, "", None, allowed)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [
            Path(shutil.copyfile(path, folder / path.name))
            for path in sorted(sheet.folder.iterdir())
        ]
    except OSError as error:
        raise InputError.one(folder, "", None, f"cannot be made: {error.strerror}") from None
