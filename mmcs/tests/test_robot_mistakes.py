# SPDX-License-Identifier: Apache-2.0
"""Every class of mistake in a robot file, each with the exact line that a user sees."""

import pytest

from mmcs.scenario.load import load
from mmcs.tests.conftest import GOOD, good, one_clear_line, put

OWN = GOOD.replace('"lab500"', '"own.toml"')

ROBOT = """
title = "a motor"
[[axis]]
rotor_inertia = 1e-6
inertia = 2e-6
viscous = 0.0
coulomb_pos = 0.1
coulomb_neg = 0.1
stiction_pos = 0.1
stiction_neg = 0.1
km = 0.02
resistance = 1.0
v_supply = 24.0
amp_gain = 0.3
amp_max = 3.0
amp_tau = 0.0
gear = 1.0
counts_per_rev = 2000
"""
# Of the axis: a line, and why it cannot be. Told is axis.0.LINE: WHY.
LINES = {
    "km = 0": "must be at least 1e-12",
    "friction = -1": "must be at least 0",
    "inertia = 2000000.0": "must be at most 1000000",
    "rotor_inertia = 1e-16": "must be at least 1e-12",
    "rotor_inertia = 0.001": "must be at most inertia (2e-06), which includes it",
    "amp_gain = -1e+300": "must be at least -10000",
    "gear = 0.0": "must not be 0; 1 for a motor without gear",
    "stiction_neg = 0.05": "must be at least coulomb_neg (0.1)",
    "counts_per_rev = 7": "must be a multiple of 4",
    "backlash = 0.1": "needs a stiffness above 0",
    "servo.pd_1000us = [1, 2]": "must be [a0, a1, b0] or [a0, a1, b0, b1], whole numbers of "
    "32 bits",
    'source.gear = "E book"': "must be a confidence A, B, C or D, a space, and a reference",
    'source.gear = "A book"': '[reference] has no "book"',
}
LINK = "[[link]]\nalpha=0.0\na=0.0\nd=0.0\ntheta0=0.0\nmass=1.0\ninertia=[1,1,1,0,0,0]\ncom="
CASES = {
    "missing": (ROBOT.replace("km = 0.02", ""), "axis.0.km: is missing"),
    "typo": (
        ROBOT.replace("viscous", "viscus"),
        'axis.0.viscus: unknown key; did you mean "viscous"?',
    ),
    "every axis": (
        ROBOT.replace("[[axis]]", "[every_axis]\nviscus = 1\n[[axis]]"),
        'every_axis.viscus: unknown key; did you mean "viscous"?',
    ),
    "winding": (
        put(ROBOT, "km = 2.0"),
        "axis.0.inertia = 2e-06: must be at least 0.0002, by km and resistance: steps are 50 us",
    ),
    "gravity": (
        ROBOT.replace("[[axis]]", "gravity = [0, 0, 1e9]\n[[axis]]"),
        "gravity = [0, 0, 1000000000.0]: must be numbers from -1000 to 1000",
    ),
    "stops": (
        ROBOT + "stop_lo = 1.0\nstop_hi = 2.0",
        "axis.0.angle0 = 0.0: must lie between the stops (1 to 2)",
    ),
    "arm": (
        f"{ROBOT}{LINK}[0,0,0]\n{LINK}[0,0,0]",
        'link = "2 links": an arm needs one [[link]] per [[axis]] (1)',
    ),
    "vector": (f"{ROBOT}{LINK}[0]", "link.0.com = [0]: must be a list of 3 numbers"),
    **{line: (put(ROBOT, line), f"axis.0.{line}: {why}") for line, why in LINES.items()},
}


@pytest.mark.parametrize("case", CASES)
def test_robot_mistake(mmcs, scenario, case):
    text, expected = CASES[case]
    robot = scenario(text, "own.toml")
    path = scenario(OWN)
    one_clear_line(mmcs("run", path), start=f"{robot}: {expected}\n")


def test_good_robot_of_ones_own(mmcs, scenario):
    scenario(ROBOT, "own.toml")
    assert "good; axes 1, motions 1" in good(mmcs("check", scenario(OWN)), silent=True)


def test_friction_of_a_robot_file_is_that_of_sweeps(scenario):
    four = [line for line in ROBOT.splitlines() if line.startswith(("coulomb", "stiction"))]
    texts = {
        "four.toml": ROBOT,
        "one.toml": ROBOT.replace("\n".join(four), "friction = 0.1"),
        "given.toml": ROBOT.replace("[[axis]]", "[[axis]]\nfriction = 0.2"),
        "every.toml": ROBOT.replace("[[axis]]", "[every_axis]\nfriction = 0.2\nkm = 7.0\n[[axis]]"),
    }
    motors = []
    for name, text in texts.items():
        scenario(text, name)
        motors.append(load(str(scenario(GOOD.replace("lab500", name)))).motors())
    assert all(motor == motors[0] for motor in motors)
