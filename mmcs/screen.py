# SPDX-License-Identifier: Apache-2.0
"""What goes to the terminal: names and sentences of the user's are text and nothing else.

Nothing else prints: a bracket is no markup here, an escape character no command, and a name that
is no text at all is spelled out.
"""

import contextlib
import locale
import os
import sys
import time

import click

from mmcs.errors import one_line


def clean(text: str) -> str:
    """The text, line by line, with what would move the cursor or break a line spelled out."""
    return "\n".join(one_line(line) for line in text.split("\n"))


def echo(text: str, err: bool = False) -> None:
    click.echo(clean(text), err=err)


def console(stderr: bool = False):
    from rich.console import Console

    class Plain(Console):
        def print(self, *objects, **options) -> None:
            texts = (clean(o) if isinstance(o, str) else o for o in objects)
            super().print(*texts, **options)

    told = dict(os.environ)
    if not told.get("COLUMNS", "").strip("0"):  # no width: nothing would be printed
        told.pop("COLUMNS", None)
    return Plain(highlight=False, soft_wrap=True, markup=False, emoji=False, stderr=stderr,
                 _environ=told)  # fmt: skip


@contextlib.contextmanager
def progress(total: float, text: str, completed: float = 0, first_s: float = 0.0):
    """A bar on stderr, once so many seconds have passed, if somebody watches; gives advance(done,
    more text). text: with {task.completed} and {task.total}."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn(text),
        BarColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[more]}"),
    )
    bar = Progress(*columns, console=console(stderr=True), transient=True)
    task, began = bar.add_task("", total=total, completed=completed, more=""), time.monotonic()

    def advance(done: float, more: str = "") -> None:
        bar.update(task, completed=done, more=more)
        if time.monotonic() - began >= first_s:
            bar.start()

    try:
        yield advance
    finally:
        bar.stop()


def table(title: str, head: tuple[str, ...], rows: list[tuple[str, ...]], left: int) -> str:
    """As rich, slow to import, draws one: so many columns to the left; headings may have lines."""
    heads = [heading.split("\n") for heading in head]
    high = max(map(len, heads))
    above = [*zip(*([""] * (high - len(lines)) + lines for lines in heads), strict=True)]
    rows = [[one_line(text).strip() for text in row] for row in rows]
    wide = [max(map(len, column)) for column in zip(*above, *rows, strict=True)]

    def drawn(row, bar: str) -> str:
        cells = (f" {text:{'<>'[n >= left]}{wide[n]}} " for n, text in enumerate(row))
        return bar + bar.join(cells) + bar

    def rule(begin: str, line: str, cross: str, end: str) -> str:
        return begin + cross.join(line * (width + 2) for width in wide) + end

    return "\n".join([
        title, rule(*"┏━┳┓"), *(drawn(row, "┃") for row in above), rule(*"┡━╇┩"),
        *(drawn(row, "│") for row in rows), rule(*"└─┴┘"),
    ])  # fmt: skip


def prepare() -> None:
    """Standard files that are closed become nothing; a locale without Unicode becomes UTF-8."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # the next file opened would be it: a result, full of messages
            os.open(os.devnull, os.O_RDWR)
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "r+"))  # noqa: SIM115
    if not sys.flags.utf8_mode and locale.getpreferredencoding(False).upper() != "UTF-8":
        sys.stdout.flush()
        with contextlib.suppress(OSError):
            os.execv(sys.executable, [sys.executable, "-X", "utf8", "-m", "mmcs", *sys.argv[1:]])


def shown(value: float | None) -> str:
    """A figure in a table."""
    if value is None:
        return "-"
    return f"{value:.0f}" if value == round(value) else f"{value:.1f}"
