# SPDX-License-Identifier: Apache-2.0
"""The parts of a page that a program writes: between `<!-- generated: NAME -->` and its end.

What a run has measured bears the day and the commit, the command that repeats it, and a mark with
the folders that it depends on and Git's digest of each: `<!-- of rtl@1f2e3d4c -->`. `make docs`
puts in place of a mark which of them have changed since. As a program it lists what is older than
they are; with a commit and folders it prints their mark, for a row of a table of runs.
"""

import argparse
import datetime
import re
import sys
from pathlib import Path

from tools.compiled import ROOT, ran

MARK = re.compile(r"<!-- of ((?:[\w./-]+@\w+ ?)+)-->")


def marks(name: str) -> tuple[str, str]:
    return f"<!-- generated: {name} -->\n", f"<!-- end of {name} -->"


def part(text: str, name: str) -> str:
    """What stands there."""
    begin, end = marks(name)
    return text.split(begin)[1].split(end, maxsplit=1)[0]


def splice(text: str, name: str, content: str) -> str:
    """The page with this content there; it must have the two marks."""
    return between(text, *marks(name), content)


def between(text: str, begin: str, end: str, content: str) -> str:
    """The text with this content between two marks of it."""
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


def rewrite(page: Path, name: str, content: str, command: str, folders: str) -> None:
    """Puts what the command has measured of these folders into the page, with the day and commit.

    Raises SystemExit where a folder has changes that no commit has: who measures for hours asks
    committed() first.
    """
    mark = committed(folders)
    told = f"*Measured {datetime.date.today():%Y-%m-%d} at {_git('rev-parse', '--short', 'HEAD')}"
    content = f"{told} by `{command}`.* {mark}\n\n{content.strip()}"
    page.write_text(splice(page.read_text(), name, content))


# --- how old it is -------------------------------------------------------------------------------


def _git(*words: str) -> str:
    return ran("git", *words, cwd=ROOT).stdout.strip()


def digests(folders: list[str], commit: str = "HEAD") -> list[str]:
    """Of each folder or file Git's own digest, 8 digits; "" where the commit has none."""
    return [_git("rev-parse", "-q", "--verify", f"{commit}:{name}")[:8] for name in folders]


def mark_of(folders: str, commit: str = "HEAD") -> str:
    names = folders.split()
    found = dict(zip(names, digests(names, commit), strict=True))
    if lost := [name for name in names if not found[name]]:
        raise SystemExit(f"pages: {commit} has no {', '.join(lost)}")
    return f"<!-- of {' '.join(f'{name}@{digest}' for name, digest in found.items())} -->"


def committed(folders: str) -> str:
    """The folders' mark. Raises SystemExit where they have changes that no commit has, and where
    they are others than when this process asked first: what it measured is then of neither."""
    if changed := _git("diff", "--name-only", "HEAD", "--", *folders.split()):
        raise SystemExit(
            f"pages: a figure is of a commit, and {changed.splitlines()[0]} is changed: commit it, "
            "then measure"
        )
    mark = mark_of(folders)
    if _asked.setdefault((ROOT, folders), mark) != mark:
        raise SystemExit(f"pages: {folders} changed while they were measured: measure again")
    return mark


_asked: dict[tuple[Path, str], str] = {}  # what committed() has said


def changed_since(mark: re.Match) -> list[str]:
    """Of the folders of a mark those that are others by now."""
    then = dict(word.split("@") for word in mark[1].split())
    now = digests(list(then))
    return [name for (name, old), new in zip(then.items(), now, strict=True) if old != new]


def aged(text: str) -> str:
    """The page, with what has changed since in place of each mark."""

    def say(mark: re.Match) -> str:
        changed = ", ".join(f"`{name}`" for name in changed_since(mark))
        return f"**Changed since: {changed}.**" if changed else "*Nothing of it changed since.*"

    return MARK.sub(say, text)


def old_ones() -> list[str]:
    """A line for each figure in docs/ that is older than what it measures."""
    found = []
    for page in sorted((ROOT / "docs").rglob("*.md")):
        for line in page.read_text().splitlines():
            for mark in MARK.finditer(line):
                if changed := changed_since(mark):
                    told = MARK.sub("", line).strip("| *")[:140]
                    found.append(f"{page.relative_to(ROOT)}: {told}: changed: {' '.join(changed)}")
    return found


def told_age() -> str:
    """One line on all of them."""
    return f"{len(old_ones())} figures in docs/ are older than what they measure: tools/pages.py"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commit", nargs="?", help="print the mark of this commit's FOLDERs")
    parser.add_argument("folder", nargs="*", metavar="FOLDER")
    given = parser.parse_args()
    print(mark_of(" ".join(given.folder), given.commit) if given.commit else "\n".join(old_ones()))
