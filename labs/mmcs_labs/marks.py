# SPDX-License-Identifier: Apache-2.0
"""What an answer is worth: questions, their points, and the reason for each."""

import re
import runpy
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import create_model

from mmcs import InputError, RunError, Strict, once, read_toml, validate
from mmcs_labs.sheets import ANSWER, GRADER, Sheet
from mmcs_labs.trial import Run, run

Verdict = tuple[bool, str]


@dataclass(frozen=True)
class Question:
    key: str  # of the answer file
    points: int
    kind: Any  # type of the answer, with its bounds
    judge: Callable[[Any, Run], Verdict]  # of all answers, and run(scenario, *sets)


@dataclass(frozen=True)
class Mark:
    key: str
    points: int
    of: int
    why: str


def figure(key: str, points: int, true: Callable[[Run], float], within: float, unit: str, how: str,
           kind: Any = float) -> Question:  # fmt: skip
    """A question for what true(run) measures; how: where the student can see it."""

    def judge(answer, run: Run) -> Verdict:
        return near(getattr(answer, key), true(run), within, unit, how)

    return Question(key, points, kind, judge)


def near(given: float, true: float, within: float, unit: str, how: str) -> Verdict:
    if abs(given - true) <= within:
        return True, f"{given:g} {unit} agrees: {how}"
    way = "high" if given > true else "low"
    by = f", by more than {within:g}" if within else ""
    return False, f"{given:g} {unit} is too {way}{by}: {how}"


def edge(key: str, points: int, kind: Any, measure: Callable[[Run, Any], float], most: float,
         step: float, text: str, way: str) -> Question:  # fmt: skip
    """A question for the last value with which measure(run, value) is at most `most`: with a step
    more it is above. text: of figure and value; way: of the values beyond, "long" or "short"."""

    def judge(answer, run: Run) -> Verdict:
        given = getattr(answer, key)
        here, beyond = measure(run, given), measure(run, given + step)
        told, further = text.format(here, given), text.format(beyond, given + step)
        if here > most:
            return False, f"{told}: too {way}"
        if beyond <= most:
            return False, f"{further}: there is a {way}er one"
        return True, f"{told}, {further}"

    return Question(key, points, kind, judge)


def arrives(figures: dict, overshoot_pct: float, rise_ms: float) -> Verdict:
    """A step of a motor with the student's gains, by the figures that `mmcs run` prints."""
    pct, rise = figures["overshoot_pct"], figures["rise_ms"]
    told = f"overshoot {pct:.1f} %, rise {'never' if rise is None else f'{rise:.1f} ms'}"
    good = pct <= overshoot_pct and rise is not None and rise <= rise_ms
    return good, f"{told}; at most {overshoot_pct:g} % and {rise_ms:g} ms"


def read_answer(sheet: Sheet, path: Path) -> Strict:
    """Raises InputError with every mistake of the file."""
    path = path / ANSWER if path.is_dir() else path
    answer, mistakes = validate(answer_model(sheet), read_toml(path), str(path))
    if mistakes:
        raise InputError(*mistakes)
    return answer


def answers(folder: Path) -> dict[str, Path]:
    """The answers of a class by student: NAME.toml, or NAME/answer.toml. Raises InputError."""
    found: dict[str, Path] = {}
    for path in sorted([*folder.glob("*.toml"), *folder.glob(f"*/{ANSWER}")]):
        name = path.parent.name if path.name == ANSWER else path.stem
        if name in found:
            allowed = f"is a second answer of {name}, beside {found[name]}: remove one"
            raise InputError.one(path, "", None, allowed)
        found[name] = path
    if not found:
        allowed = f"holds no answers: no NAME.toml and no NAME/{ANSWER} is there"
        raise InputError.one(folder, "", None, allowed)
    return dict(sorted(found.items()))


def grade_class(sheet: Sheet, folder: Path) -> dict[str, list[Mark] | str]:
    """By student: the marks, or why the file cannot be graded."""
    graded: dict[str, list[Mark] | str] = {}
    for name, path in answers(folder).items():
        try:
            graded[name] = grade(sheet, read_answer(sheet, path))
        except InputError as error:
            graded[name] = "; ".join(f"{m.key}: {m.allowed}".lstrip(": ") for m in error.mistakes)
    return graded


def answer_model(sheet: Sheet) -> type[Strict]:
    return _loaded(*_state(sheet))[1]


def questions(sheet: Sheet) -> tuple[Question, ...]:
    return _loaded(*_state(sheet))[0]


def grade(sheet: Sheet, answer: Strict) -> list[Mark]:
    return [_mark(sheet, question, answer) for question in questions(sheet)]


def _mark(sheet: Sheet, question: Question, answer: Strict) -> Mark:
    if getattr(answer, question.key) is None:
        return Mark(question.key, 0, question.points, "no answer yet")
    try:
        good, why = question.judge(answer, partial(run, sheet.folder))
    except RunError as error:
        text = re.sub(r"^axis\.\d+\.", f"{question.key}.", str(error))  # the student's own name
        good, why = False, f"cannot be run: {text}"
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # a mistake of the grader, not of the student
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if Path(frame.filename).name == GRADER]
        frame = (own or frames)[-1]
        where = f"question {question.key}, {Path(frame.filename).name}:{frame.lineno}"
        what = f"{type(error).__name__}: {error}"
        raise InputError.one(sheet.folder / GRADER, where, None, what) from None
    return Mark(question.key, question.points if good else 0, question.points, why)


def _state(sheet: Sheet) -> tuple[Path, int]:
    path = sheet.folder / GRADER
    return path, path.stat().st_mtime_ns


@once
def _loaded(path: Path, _: int) -> tuple[tuple[Question, ...], type[Strict]]:
    """QUESTIONS of a grader, and the model of their answers; once a process for each state of the
    file, so that there is one model."""
    try:
        questions = tuple(runpy.run_path(str(path))["QUESTIONS"])
        keys = [one.key for one in questions if type(one.points) is int]
        if len(keys) < len(questions):
            raise TypeError("points of a question must be a whole number")
        if twice := {key for key in keys if keys.count(key) > 1}:
            raise ValueError(f"QUESTIONS has {min(twice)} twice")
        fields = {one.key: (one.kind | None, None) for one in questions}
        return questions, create_model("Answer", __base__=Strict, **fields)
    except (Exception, SystemExit) as error:
        raise InputError.one(path, "", None, f"{type(error).__name__}: {error}") from None
