# SPDX-License-Identifier: Apache-2.0
"""What an answer is worth: questions, their points, and the reason for each."""

import re
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from mmcs.errors import InputError, RunError
from mmcs.lab.sheets import ANSWER, GRADER, Sheet
from mmcs.lab.trial import run
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
    answer, mistakes = validate(answer_model(sheet), read_toml(path), str(path))
    if mistakes:
        raise InputError(*mistakes)
    return answer


def answers(folder: Path) -> dict[str, Path]:
    """The answers of a class by student: NAME.toml, or NAME/answer.toml. Raises InputError."""
    found = {path.stem: path for path in folder.glob("*.toml")}
    found |= {path.parent.name: path for path in folder.glob(f"*/{ANSWER}")}
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
    return _grader(sheet).Answer


def questions(sheet: Sheet) -> list[Question]:
    return _grader(sheet).QUESTIONS


def grade(sheet: Sheet, answer: Strict) -> list[Mark]:
    return [_mark(sheet, question, answer) for question in _grader(sheet).QUESTIONS]


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
    except Exception as error:  # a mistake of the grader, not of the student
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if Path(frame.filename).name == GRADER]
        frame = (own or frames)[-1]
        where = f"question {question.key}, {Path(frame.filename).name}:{frame.lineno}"
        what = f"{type(error).__name__}: {error}"
        raise InputError.one(sheet.folder / GRADER, where, None, what) from None
    return Mark(question.key, question.points if good else 0, question.points, why)


def _grader(sheet: Sheet):
    """The module in the sheet's folder: Answer, a model, and QUESTIONS."""
    path = sheet.folder / GRADER
    return _loaded(path, path.stat().st_mtime_ns)


@cache
def _loaded(path: Path, _: int):
    """Once a process for each state of the file, so that there is one Answer."""
    spec = spec_from_file_location(f"grader_of_{path.parent.name}", path)
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # models of pydantic look there for their types
    try:
        spec.loader.exec_module(module)
        _ = module.Answer, module.QUESTIONS
    except Exception as error:
        raise InputError.one(path, "", None, f"{type(error).__name__}: {error}") from None
    return module
