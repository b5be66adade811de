# SPDX-License-Identifier: Apache-2.0
"""What an answer is worth: questions, their points, and the reason for each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path

from mmcs.errors import InputError, RunError
from mmcs.lab.bench import run
from mmcs.lab.sheets import ANSWER, Sheet
from mmcs.scenario.files import read_toml
from mmcs.scenario.schema import Strict, validate

Verdict = tuple[bool, str]


@dataclass(frozen=True)
class Question:
    key: str  # of the answer file
    points: int
    judge: Callable[[Strict, Callable], Verdict]  # of the answer, and run(scenario, *sets)


@dataclass(frozen=True)
class Mark:
    key: str
    points: int
    of: int
    why: str


def near(given: float, true: float, within: float, unit: str, how: str) -> Verdict:
    """A figure measured by the grader; how: where the student can see it."""
    if abs(given - true) <= within:
        return True, f"{given:g} {unit} agrees: {how}"
    way = "high" if given > true else "low"
    by = f", by more than {within:g}" if within else ""
    return False, f"{given:g} {unit} is too {way}{by}: {how}"


def arrives(figures: dict, overshoot_pct: float, rise_ms: float) -> Verdict:
    """A step of a motor with the student's gains, by the figures that `mmcs run` prints."""
    pct, rise = figures["overshoot_pct"], figures["rise_ms"]
    told = f"overshoot {pct:.1f} %, rise {'never' if rise is None else f'{rise:.1f} ms'}"
    good = pct <= overshoot_pct and rise is not None and rise <= rise_ms
    return good, f"{told}; at most {overshoot_pct:g} % and {rise_ms:g} ms"


def read_answer(sheet: Sheet, path: Path) -> Strict:
    """Raises InputError with every mistake of the file."""
    path = path / ANSWER if path.is_dir() else path
    answer, mistakes = validate(_grader(sheet).Answer, read_toml(path), str(path))
    if mistakes:
        raise InputError(*mistakes)
    return answer


def grade(sheet: Sheet, answer: Strict) -> list[Mark]:
    return [_mark(sheet, question, answer) for question in _grader(sheet).QUESTIONS]


def _mark(sheet: Sheet, question: Question, answer: Strict) -> Mark:
    if getattr(answer, question.key) is None:
        return Mark(question.key, 0, question.points, "no answer yet")
    try:
        good, why = question.judge(answer, partial(run, sheet.folder))
    except RunError as error:
        good, why = False, f"cannot be run: {error}"
    return Mark(question.key, question.points if good else 0, question.points, why)


def _grader(sheet: Sheet):
    return import_module(f"mmcs.lab.graders.{sheet.name}")
