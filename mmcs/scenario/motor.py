# SPDX-License-Identifier: Apache-2.0
"""The motor of a robot file as control design needs it. docs/use/design.md"""

import math

import numpy as np

from mmcs.scenario.identify import Motor
from mmcs.scenario.predict import step
from mmcs.scenario.synthesis import Coefficients, Plant

COMPENSATED = 0.8  # of the Coulomb friction
STEP, LONGEST_S = 200, 2.0  # counts, of which friction_and_limit() and expected_step() tell


def torque_per_lsb(motor) -> float:
    """N m at the motor by one D/A unit."""
    return motor.km * motor.amp_gain * 10 / 2048


def plant_of(motor) -> Plant:
    """The motor of a robot file as the linear design sees it, alone with its mean inertia."""
    counts_per_rad = motor.counts_per_rev / (2 * math.pi)
    lag = motor.viscous / motor.inertia
    return Plant(counts_per_rad * torque_per_lsb(motor) / motor.inertia, lag)


def compensation(motor) -> tuple[int, int]:
    """ic_pos, ic_neg in D/A units: 80 % of the Coulomb friction; with all of it the axis creeps."""
    unit = torque_per_lsb(motor)
    return round(COMPENSATED * motor.coulomb_pos / unit), round(
        COMPENSATED * motor.coulomb_neg / unit
    )


def friction_and_limit(k: Coefficients, motor) -> list[str]:
    """What the linear design leaves out: sentences on the rest position and on the limit."""
    unit = abs(torque_per_lsb(motor))
    stuck = max(motor.stiction_pos, motor.stiction_neg) / unit
    helped = min(map(abs, compensation(motor)))
    dc = sum(k.a) / sum(k.b) if sum(k.b) else math.inf
    out = []
    if stuck and dc:
        off, bare = (max(0.0, stuck - ic) / abs(dc) for ic in (helped, 0))
        out.append(
            f"friction: the axis may rest {math.ceil(off)} counts off its setpoint, "
            f"{math.ceil(bare)} without Coulomb compensation"
        )
    ilim, first = motor.servo.ilim, abs(k.a[0] / k.b[0])
    drag = max(motor.coulomb_pos, motor.coulomb_neg) / unit
    if first and ilim > drag:
        g = abs(plant_of(motor).g)
        least = math.sqrt(2 * STEP * (1 / (g * (ilim - drag)) + 1 / (g * (ilim + drag))))
        out.append(f"limit: a step of more than {ilim / first:.0f} counts begins at ilim {ilim}; "
                   f"one of {STEP} counts takes at least {1000 * least:.0f} ms")  # fmt: skip
    return out


def expected_step(k: Coefficients, motor, t: float) -> str:
    """A step of STEP counts by the law in integers, with Coulomb compensation, friction and limit,
    and one sample of delay for double-buffered D/As. The linear loop must be stable."""
    unit, ic = torque_per_lsb(motor), compensation(motor)
    plant = plant_of(motor)
    real = Motor(plant.g, plant.lag, motor.coulomb_pos / unit, motor.coulomb_neg / unit, 1.0)
    param = k.named() | {"mode": 0x10, "ilim": motor.servo.ilim, "ic_pos": ic[0], "ic_neg": ic[1]}
    stuck = max(motor.stiction_pos, motor.stiction_neg) / abs(unit)
    y = step(real, param, t, STEP, int(LONGEST_S / t) + 2, stuck, delay=1)
    told = f"expected: a step of {STEP} counts "
    if y.max() < 0.9 * STEP:
        return f"{told}ends at {y[-1]:.0f}, short of 90 %"
    low, high = (int(np.argmax(y >= share * STEP)) for share in (0.1, 0.9))
    over = 100 * max(0.0, y.max() - STEP) / STEP
    return (f"{told}rises in {1000 * t * (high - low):.0f} ms, overshoots by {over:.0f} %, "
            f"ends {abs(STEP - y[-1]):.0f} counts off")  # fmt: skip
