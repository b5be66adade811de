# SPDX-License-Identifier: Apache-2.0
"""What auto-tune finds of a motor in its recorded motion."""

import numpy as np
import pytest

from mmcs.scenario.identify import identify


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
