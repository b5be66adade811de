# SPDX-License-Identifier: Apache-2.0
"""Graders attacked: no point for zero gains, no motion, constants, or names that are swapped."""

import tomllib

from mmcs import validate
from mmcs_labs.marks import answer_model, grade

NOTHING = {"a0": 0, "a1": 0, "a2": 0, "b0": 1, "b1": 0, "b2": 0}
STILL = {"ilim": 0, "ilimax": 0}


def good_answer(sheet) -> dict:
    return tomllib.loads((sheet.folder / "tests" / "good.toml").read_text())


def points(sheet, answer: dict) -> dict[str, int]:
    """By key; nothing for what the answer file may not even say."""
    made, mistakes = validate(answer_model(sheet), answer, "answer")
    return {} if mistakes else {mark.key: mark.points for mark in grade(sheet, made)}


def is_number(value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def degenerate(key: str, value):
    """What somebody writes who has done nothing."""
    if isinstance(value, dict) and "b0" in value:
        yield {k: NOTHING.get(k, 0) for k in value}
        yield {**value, "a0": 1, **{k: 0 for k in ("a1", "a2") if k in value}}
    elif isinstance(value, dict):
        yield {k: 0 for k in value}
        if set(value) == set(STILL):
            yield from ({"ilim": i, "ilimax": m} for i, m in ((0, 20), (1, 1), (100_000, 0)))
    elif isinstance(value, list):
        yield from ([], [0] * len(value), [1] * len(value))
        if len(value) > 1 and all(map(is_number, value)):
            yield [0.0] * (len(value) - 1) + [1.0]
    elif is_number(value):
        yield from (type(value)(x) for x in (0, 1, -1, 9999))


def test_nothing_done_earns_nothing(sheet):
    """Zero gains, no motion, constants: each in the place of a good answer, the rest good."""
    whole = good_answer(sheet)
    for key, value in whole.items():
        for tried in degenerate(key, value):
            if tried == value or (is_number(value) and abs(tried - value) <= 0.02 * abs(value)):
                continue
            earned = points(sheet, whole | {key: tried}).get(key, 0)
            assert earned == 0, (key, tried)


def test_one_constant_in_every_place_earns_nothing(sheet):
    """Also where a question takes its measure from another answer."""
    whole = good_answer(sheet)
    for constant in (0, 1, 9999):
        answer = {}
        for key, value in whole.items():
            if is_number(value):
                answer[key] = type(value)(constant)
            elif isinstance(value, list) and all(map(is_number, value)):
                answer[key] = [constant] * len(value)
            elif isinstance(value, dict) and "b0" in value:
                answer[key] = {k: NOTHING.get(k, 0) for k in value}
        kept = {k: v for k, v in answer.items() if points(sheet, {k: v})}  # what may be said
        for key, earned in points(sheet, kept).items():
            same = is_number(whole[key]) and abs(constant - whole[key]) <= 1
            assert earned == 0 or same, (constant, key)


def test_swapped_names_earn_nothing(sheet):
    """The answer of each question in the place of the next of its kind."""
    whole = good_answer(sheet)
    kinds: dict[str, list[str]] = {}
    for key, value in whole.items():
        if is_number(value) or isinstance(value, dict):
            kind = "number" if is_number(value) else str(sorted(value))
            kinds.setdefault(kind, []).append(key)
    for keys in kinds.values():
        for key, other in zip(keys, keys[1:] + keys[:1], strict=True):
            a, b = whole[key], whole[other]
            if a == b or (is_number(a) and abs(a - b) <= max(1.0, 0.05 * abs(a))):
                continue
            swapped = int(b) if isinstance(a, int) and is_number(b) else b
            earned = points(sheet, whole | {key: swapped}).get(key, 0)
            assert earned == 0, (key, other)
