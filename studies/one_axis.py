# SPDX-License-Identifier: Apache-2.0
"""The reference servo: one motor and the servo law of §2.2, a page of arithmetic.

It shares no code with firmware, RTL or plant. At every sample the encoder is read and the law
computes; the D/A changes at the next one. Between samples the motor moves in steps of 50 us.
"""

import math

STEP = 50e-6


def move(motor, law: dict, setpoint, interval: float, seconds: float) -> list[tuple]:
    """(setpoint, count, current) at each sample. law: a0, a1, b0, b1, ic_pos, ic_neg, ilim."""
    per_rad = motor.counts_per_rev / (2 * math.pi)
    amps = motor.amp_gain * 10 / 2048
    share = 1 - math.exp(-STEP / motor.amp_tau) if motor.amp_tau else 1.0
    angle = speed = amperes = 0.0
    y1 = y2 = e1 = n1 = waiting = 0
    log = []
    for k in range(round(seconds / interval)):
        out, w = waiting, setpoint(k * interval)
        y = math.floor(angle * per_rad + 0.5)
        velocity = int((3 * y - 4 * y1 + y2) / 2)
        y2, y1 = y1, y
        e = w - y
        n1 = law["a0"] * e + law["a1"] * e1 - int(law.get("b1", 0) * n1 / law["b0"])
        e1 = e
        u = int(n1 / law["b0"])
        way = velocity or u
        u += law["ic_pos"] if way > 0 else -law["ic_neg"] if way < 0 else 0
        waiting = max(-law["ilim"], min(law["ilim"], u))
        log.append((w, y, waiting))
        for _ in range(round(interval / STEP)):
            amperes += share * (out * amps - amperes)
            if motor.v_supply:
                back = motor.km * speed
                amperes = max(-(motor.v_supply + back) / motor.resistance,
                              min((motor.v_supply - back) / motor.resistance, amperes))  # fmt: skip
            speed = _friction(motor, speed, motor.km * amperes)
            angle += speed * STEP
    return log


def _friction(motor, speed: float, torque: float) -> float:
    """The speed after one step: the shaft sticks as long as friction can hold it."""
    push = motor.inertia / STEP * speed + torque
    pos, neg = motor.coulomb_pos, motor.coulomb_neg
    held = (motor.stiction_pos, motor.stiction_neg) if speed == 0 else (pos, neg)
    if -held[1] <= push <= held[0]:
        return 0.0
    return (push - pos if push > 0 else push + neg) / (motor.inertia / STEP + motor.viscous)
