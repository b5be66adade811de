# SPDX-License-Identifier: Apache-2.0
"""Robot files: `mmcs check` of one alone, flexible axes, copies, motors drawn by a sweep."""

from mmcs.scenario.load import load_robot
from mmcs.scenario.robot import with_values
from mmcs.tests.conftest import good
from mmcs.tests.test_mistakes import FLEXIBLE, ROBOT


def test_flexible_axis_gives_the_rotor_and_the_load(scenario):
    _, robot = load_robot(str(scenario(FLEXIBLE, "own.toml")))
    motor = robot.motors(coupled=False)[0]
    assert (motor["inertia"], motor["load_inertia"]) == (1e-6, 5e-6)
    _, rigid = load_robot(str(scenario(ROBOT, "own.toml")))
    assert rigid.motors(coupled=False)[0]["inertia"] == 2e-6
    assert rigid.motors(coupled=True)[0]["inertia"] == 1e-6


def test_copies_are_numbered_from_1():
    robot = {"axis": [{"copies": 2, "name": "J"}, {"name": "K"}]}
    changed = with_values(robot, [{"axis": [1], "km": 2.0}])["axis"]
    assert [(m["name"], m.get("km")) for m in changed] == [("J1", None), ("J2", 2.0), ("K", None)]


def test_cautions(mmcs, scenario):
    text = ROBOT.replace("gear = 1.0", "gear = 1.0\nservo.ilim = 20\nservo.ic_pos = 2000")
    out = good(mmcs("check", scenario(text, "own.toml")))
    assert "caution: axis 0: takes 3413 D/A units to break away, ilim is less" in out
