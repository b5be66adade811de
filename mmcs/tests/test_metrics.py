# SPDX-License-Identifier: Apache-2.0
"""The four figures of a step response, on responses whose figures are known by hand."""

import numpy as np
import pytest

from mmcs.runs.metrics import steady_error, step_response
from mmcs.runs.report import limited

T = np.arange(0, 0.5, 0.001)


def first_order(target, tau=0.02, start=0.05, begin=0.0):
    t = np.maximum(T - start, 0)
    return begin + (target - begin) * (1 - np.exp(-t / tau))


@pytest.mark.parametrize(("begin", "target"), [(0, 200), (0, -200), (100, 300), (-50, -60)])
def test_first_order(begin, target):
    seen = step_response(T, first_order(target, begin=begin), 0.05, begin, target)
    assert seen.rise_ms == pytest.approx(20 * np.log(9), abs=0.2)
    assert seen.overshoot_pct == 0
    assert seen.steady_error_counts == pytest.approx(0, abs=1e-6)
    share = max(0.02, 2 / abs(target - begin))  # 2 counts are 20 % of the small step
    assert seen.settle_ms == pytest.approx(-20 * np.log(share), abs=1.0)


@pytest.mark.parametrize("first", [0, 1, 50])
def test_rise_between_samples(first):
    """A ramp of 13 counts a sample from 7, where the axis stands at the last sample before the
    step: exact, though the levels lie between samples."""
    y = 7.0 + np.clip(13.0 * (np.arange(len(T)) - first), 0, 100)
    y[: max(first - 1, 0)] = 40
    seen = step_response(T, y, T[first], 0, 100)
    assert seen.rise_ms == round(80 / 13, 3)
    if first:
        y[first - 1] = -20  # over 10 % of the step with its first sample
        assert step_response(T, y, T[first], 0, 100).rise_ms == round(63 / 13, 3)


@pytest.mark.parametrize("samples", range(300, 320))
def test_steady_error_is_of_twenty_milliseconds(samples):
    """Of 20 samples and no more, however their times are rounded."""
    t = T[:samples] - 0.05
    for place, error in ((-21, 0), (-20, 5), (-1, 5)):
        y = np.full(samples, 200.0)
        y[place] -= 100
        assert steady_error(t, np.full(samples, 200.0), y) == error


@pytest.mark.parametrize(
    ("axis", "cut"),
    [({}, [0, 1, 1]), ({"ilim": 0}, [0, 0, 0]), ({"mode": "off"}, [0, 0, 0]),
     ({"ilimax": 1}, [0, 0, 1]), ({"ilim": 9999}, [0, 0, 1])],
)  # fmt: skip
def test_samples_that_the_limit_cut(axis, cut):
    params = {"mode": "torque", "ilim": 50, "ilimax": 0} | axis
    assert limited(np.array([0, 50, -2047]), params).tolist() == cut
