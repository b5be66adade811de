# SPDX-License-Identifier: Apache-2.0
"""What auto-tune finds of a motor in its recorded motion, and the gains made of it."""

import numpy as np
import pytest

from mmcs.scenario.identify import frequency, identify


def recording(g=150.0, lag=3.0, pos=300.0, neg=350.0, seconds=4.0, dt=1e-3, sign=1):
    """A motor driven back and forth in torque mode, integrated finely; counts as an encoder has."""
    t, y, u, at, v, current, sub = [], [], [], 0.0, 0.0, 0.0, 20
    for n in range(int(seconds / dt)):
        t.append(n * dt)
        y.append(int(np.floor(sign * at)))
        current = (500, 800, 1200)[n // 300 % 3] * (1 if n // 150 % 2 else -1)
        u.append(current)
        for _ in range(sub):
            drag = pos if v > 0 else -neg if v < 0 else float(np.clip(current, -neg, pos))
            after = v + (g * (current - drag) - lag * v) * dt / sub
            v = 0.0 if v * after < 0 else after
            at += v * dt / sub
    return np.array(t), np.array(y), np.array(u)


@pytest.mark.req("TOOL-1", "SYN-1")
@pytest.mark.parametrize(
    "g,lag,pos,neg", [(150, 3, 300, 350), (760, 2, 70, 106), (1450, 0.3, 105, 105)]
)
def test_the_motor_is_found_in_its_motion(g, lag, pos, neg):
    motor = identify(*recording(g, lag, pos, neg))
    assert motor.g == pytest.approx(g, rel=0.02)
    assert motor.lag == pytest.approx(lag, abs=1.0)
    assert motor.tc_pos == pytest.approx(pos, abs=12)
    assert motor.tc_neg == pytest.approx(neg, abs=12)


@pytest.mark.req("TOOL-1")
def test_a_measured_frequency_response_is_that_of_the_system():
    t = np.arange(20000) * 1e-3
    w = 100 * np.sin(2 * np.pi * np.cumsum(1 + 1.5 * t) * 1e-3)
    y, a = np.zeros_like(w), 0.9
    for n in range(1, len(w)):
        y[n] = a * y[n - 1] + (1 - a) * w[n]
    made = frequency(t, w, y, 2, 25)
    z = np.exp(2j * np.pi * made.hz * 1e-3)
    truth = (1 - a) / (1 - a / z)
    assert len(made.hz) > 20
    assert np.max(np.abs(made.gain_db - 20 * np.log10(abs(truth)))) < 0.3
    assert np.max(np.abs(made.phase_deg - np.degrees(np.angle(truth)))) < 3
