# SPDX-License-Identifier: Apache-2.0
"""The parts of a page that a program writes: between `<!-- generated: NAME -->` and its end.

What a run has measured bears the day on which it was measured, and the command that repeats it.
"""

import datetime
import sys
from pathlib import Path


def marks(name: str) -> tuple[str, str]:
    return f"<!-- generated: {name} -->\n", f"<!-- end of {name} -->"


def part(text: str, name: str) -> str:
    """What stands there."""
    begin, end = marks(name)
    return text.split(begin)[1].split(end, maxsplit=1)[0]


def splice(text: str, name: str, content: str) -> str:
    """The page with this content there; it must have the two marks."""
    begin, end = marks(name)
    if begin not in text or end not in text:
        print(f'pages: the page has no lines "{begin.strip()}" and "{end}"', file=sys.stderr)
        raise SystemExit(2)
    head, rest = text.split(begin)
    return f"{head}{begin}{content.strip()}\n{rest[rest.index(end) :]}"


def fill(page: Path, parts: dict[str, list[str]]) -> str:
    """The page's text with these lines at the marks of each name."""
    text = page.read_text()
    for name, lines in parts.items():
        text = splice(text, name, "\n".join(lines))
    return text


def rewrite(page: Path, name: str, content: str, measured_by: str = "") -> None:
    """Puts the content into the page; measured_by: the command of a run, if it is one's result."""
    if measured_by:
        today = datetime.date.today()
        content = f"*Measured {today:%Y-%m-%d} by `{measured_by}`.*\n\n{content.strip()}"
    page.write_text(splice(page.read_text(), name, content))
