# SPDX-License-Identifier: Apache-2.0
"""What the commands say when something is wrong, in one line each."""

from __future__ import annotations

import errno
from dataclasses import dataclass


@dataclass(frozen=True)
class Mistake:
    """One mistake in the user's input: where it is, what stands there, what may stand there."""

    file: str
    key: str
    value: str | None
    allowed: str

    def __str__(self) -> str:
        where = f"{self.file}: {self.key}" if self.key else self.file
        shown = "" if self.value is None else f" = {self.value}"
        return one_line(f"{where}{shown}: {self.allowed}")


class InputError(Exception):
    """Bad input: exit status 2. Holds every mistake found, the first one is the one to show."""

    def __init__(self, *mistakes: Mistake):
        super().__init__(str(mistakes[0]))
        self.mistakes = mistakes

    @classmethod
    def one(cls, file: object, key: str, value: object, allowed: str) -> InputError:
        return cls(Mistake(str(file), key, None if value is None else show(value), allowed))


class RunError(Exception):
    """The run could not be carried out although the input was good: exit status 1."""


def out_of_memory(error: BaseException) -> bool:
    """Also a library that finds no room, wherever it is imported."""
    if isinstance(error, OSError):
        return error.errno == errno.ENOMEM
    told = ("failed to map segment", "annot allocate memory", "annot apply additional memory")
    crowded = isinstance(error, ImportError) and any(words in str(error) for words in told)
    return crowded or isinstance(error, MemoryError)


def one_line(text: str) -> str:
    """The text with what would break the line, or the terminal, spelled out."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def toml(value: object) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\n", "\\n") + '"'
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k} = {toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    return str(value)


def show(value: object) -> str:
    """The same cut to a readable length."""
    text = toml(value)
    return text if len(text) <= 60 else text[:57] + "..."


def suggest(word: str, choices) -> str:
    """'; did you mean "x"?' for a close match, else nothing."""
    import difflib

    close = difflib.get_close_matches(word, list(choices), n=1, cutoff=0.6)
    return f'; did you mean "{close[0]}"?' if close else ""
