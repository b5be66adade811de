# SPDX-License-Identifier: Apache-2.0
"""An axis as a linear plant for python-control: volts of the D/A in, encoder counts out.

    control.step_response(mmcs.bridge.linear.state_space("lab500"))

Left out, for they are not linear: Coulomb friction and stiction, the limits of amplifier, supply
and D/A, stops, and the encoder's whole counts. An axis of an arm is taken alone, with its mean
inertia.
"""

import math

from mmcs.errors import InputError


def matrices(motor: dict) -> tuple[list, list, list, list]:
    """A, B, C, D of one motor (fields of mmcs_motor); states: current in A if the amplifier has a
    time constant, speed and angle of the motor."""
    if motor["stiffness"] or motor["backlash"]:
        raise InputError.one("stiffness", "", motor["stiffness"], "a flexible axis is not exported")
    a, b = -motor["viscous"] / motor["inertia"], motor["km"] / motor["inertia"]
    gain, tau = motor["amp_gain"], motor["amp_tau"]
    counts = motor["counts_per_rev"] / (2 * math.pi)
    if tau == 0:
        return [[a, 0.0], [1.0, 0.0]], [[b * gain], [0.0]], [[0.0, counts]], [[0.0]]
    rows = [[-1 / tau, 0.0, 0.0], [b, a, 0.0], [0.0, 1.0, 0.0]]
    return rows, [[gain / tau], [0.0], [0.0]], [[0.0, 0.0, counts]], [[0.0]]


def state_space(scenario: str, axis: int = 0, interval_s: float | None = None):
    """control.StateSpace of an axis of a scenario; interval_s: sampled so, with the D/A's hold."""
    try:
        import control
    except ImportError:
        raise ImportError("python-control is not installed; pip install -e '.[learn]'") from None
    from mmcs.scenario.load import load

    setup = load(scenario, ())
    if not 0 <= axis < setup.axes:
        raise InputError.one("axis", "", axis, f"must be 0 to {setup.axes - 1}")
    motor = setup.robot.motors(coupled=False)[axis]
    states = ["speed", "angle"] if motor["amp_tau"] == 0 else ["current", "speed", "angle"]
    plant = control.ss(*matrices(motor), states=states, inputs=["volts"], outputs=["counts"],
                       name=f"{setup.name}_{axis}")  # fmt: skip
    return plant if interval_s is None else control.c2d(plant, interval_s, "zoh")
