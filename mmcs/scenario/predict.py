# SPDX-License-Identifier: Apache-2.0
"""What a step will look like: the driver's law in integers, its limit, the motor's friction."""

from math import floor, trunc

import numpy as np

from mmcs.scenario.identify import Motor

PARTS = 10  # of an interval, for the motion between samples


def step(motor: Motor, param: dict, t: float, size: int, rows: int,
         stiction: float = 0.0, delay: int = 0) -> np.ndarray:  # fmt: skip
    """Counts at each servo sample after a step from rest. stiction: the current, D/A units, below
    which the axis stays where it is; delay: whole samples between reading and output."""
    a = [param[f"a{k}"] / param["b0"] for k in range(3)]
    b = [param[f"b{k}"] / param["b0"] for k in range(3)]
    drag_pos, drag_neg = (max(0.0, motor.g * c) for c in (motor.tc_pos, motor.tc_neg))
    hold = max(drag_pos, drag_neg, abs(motor.g) * stiction)
    at, v = 0.5, 0.0  # in the middle of a count
    errors, outputs, before = [0.0] * 3, [0.0] * 3, [0] * 3
    sent = [0.0] * (delay + 1)
    made = np.zeros(rows)
    for n in range(rows):
        count = floor(at)
        made[n] = count
        before = [count, *before[:2]]
        errors = [size - count, *errors[:2]]
        u = sum(x * e for x, e in zip(a, errors, strict=True))
        u -= b[1] * outputs[0] + b[2] * outputs[1]
        outputs = [u, *outputs[:2]]
        speed = trunc((3 * before[0] - 4 * before[1] + before[2]) / 2)
        current = u + (_coulomb(param, speed, u) if param["mode"] & 0x10 else 0.0)
        sent = [float(np.clip(current, -param["ilim"], param["ilim"])), *sent[:delay]]
        push = motor.g * sent[delay]
        for _ in range(PARTS):
            if v == 0.0 and abs(push) <= hold:
                break
            way = v if v else push
            after = v + (push - (drag_pos if way > 0 else -drag_neg) - motor.lag * v) * t / PARTS
            v = 0.0 if v * after < 0 else after
            at += v * t / PARTS
    return made


def _coulomb(param: dict, speed: int, u: float) -> float:
    """SRV-3: by the velocity; at rest by what the law wants, the other way on a reversed axis."""
    way = speed if speed else u * (-1 if param["ic_pos"] < 0 else 1)
    return float(param["ic_pos"] if way > 0 else -param["ic_neg"] if way < 0 else 0)
