# SPDX-License-Identifier: Apache-2.0
"""The joints of a robot as a C header, for firmware/examples/motion.h: `mmcs exec --robot`."""

import math
from pathlib import Path

from mmcs import mcdef
from mmcs.scenario.load import load_robot
from mmcs.scenario.robot import Robot

UNITS_PER_V, ADC_ZERO = 204.8, 2048  # D/A and A/D: 12 bits over +-10 V
SHARE = 0.5  # of the motor's limits, for those that motions ask for


def joint_of(robot: Robot, axis: int, interval_us: int) -> dict:
    """The fields of struct motion_axis, whose comments give their units."""
    motor = robot.axis[axis]
    param = robot.servo(axis, interval_us)
    mode = mcdef.mode_word(param.pop("mode"), param.pop("flags"))
    per_ampere = UNITS_PER_V / motor.amp_gain
    torque = param["ilim"] / abs(per_ampere) * motor.km
    left = max(torque - motor.coulomb_pos, 0.2 * torque)
    speed = motor.v_supply / motor.km if motor.v_supply else math.sqrt(left / motor.inertia)
    scale = SHARE / abs(motor.gear)
    return {
        "name": motor.name,
        "counts": robot.counts_per_rad(axis),
        "per_ampere": per_ampere,
        "inertia": motor.inertia * motor.gear / motor.km,
        "friction": motor.viscous * motor.gear / motor.km,
        "speed": scale * speed,
        "acceleration": scale * left / motor.inertia,
        "low": motor.stop_lo,
        "high": motor.stop_hi,
        "turn": motor.counts_per_rev if motor.index_per_rev else 0,
        "mark": motor.encoder_offset * motor.counts_per_rev / math.tau,
        "pot": 1 / (UNITS_PER_V * motor.pot_v_per_rad) if motor.pot_v_per_rad else 0.0,
        "pot_zero": ADC_ZERO + UNITS_PER_V * motor.pot_offset,
        "param": mcdef.initial() | {"mode": mode, **param},
    }


def header(robot: str, interval_us: int) -> str:
    """Of a robot file, or of a name of sim/robots. Raises InputError."""
    _, found = load_robot(robot)
    rows = [_row(joint_of(found, axis, interval_us)) for axis in range(found.axes())]
    title = f"/* The joints of {Path(robot).stem} at {interval_us} us: mmcs exec --robot */"
    return (
        f"{title}\n#include <motion.h>\n"
        f"#define ROBOT_AXES {len(rows)}\n#define ROBOT_INTERVAL_US {interval_us}\n"
        f"static const struct motion_axis robot[ROBOT_AXES] = {{\n{''.join(rows)}}};\n"
    )


def _row(joint: dict) -> str:
    param = joint.pop("param")
    values = [f".{name} = {_c(value)}" for name, value in joint.items()]
    names = [name for name in mcdef.fields("mc_param") if name in param]
    params = ", ".join(f".{name} = {_c(param[name])}" for name in names)
    return "    {" + ",\n     ".join([*values, f".param = {{{params}}}"]) + "},\n"


def _c(value) -> str:
    if value == -(1 << 31):
        return "-2147483647 - 1"  # which C has no literal for
    return f'"{value}"' if isinstance(value, str) else repr(value)
