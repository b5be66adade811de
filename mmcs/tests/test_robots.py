# SPDX-License-Identifier: Apache-2.0
"""Robot files: `mmcs check` of one alone, flexible axes, copies, motors drawn by a sweep."""

import pytest

from mmcs import ROBOTS
from mmcs.scenario.load import load_robot
from mmcs.tests.conftest import good
from mmcs.tests.test_mistakes import FLEXIBLE, ROBOT
from mmcs.tests.test_sweep import SHORT, rows_of


@pytest.mark.parametrize("name", sorted(path.stem for path in ROBOTS.glob("*.toml")))
def test_ready_robots_are_good(mmcs, name):
    """The published inertia of the PUMA's forearm is that of no body, and `check` says so."""
    out = good(mmcs("check", f"sim/robots/{name}.toml"), silent=True)
    cautions = [line for line in out.splitlines() if line.startswith("caution")]
    assert [line[:34] for line in cautions] == (
        ["caution: link 2: its greatest prin"] if name == "puma560" else []
    )
    assert f"sim/robots/{name}.toml: good; robot of " in out


def test_every_mistake_of_a_robot_file(mmcs, scenario):
    path = scenario(ROBOT.replace("gear = 1.0", "gear = 0.0\nbacklash = 0.1"), "own.toml")
    status, out, err = mmcs("check", path)
    assert (status, out) == (2, "")
    assert err.splitlines() == [
        f"mmcs: {path}: axis.0.gear = 0.0: must not be 0; 1 for a motor without gear",
        f"mmcs: {path}: axis.0.backlash = 0.1: needs a stiffness above 0",
    ]


def test_flexible_axis_gives_the_rotor_and_the_load(scenario):
    _, robot = load_robot(str(scenario(FLEXIBLE, "own.toml")))
    motor = robot.motors(coupled=False)[0]
    assert (motor["inertia"], motor["load_inertia"]) == (1e-6, 5e-6)
    _, rigid = load_robot(str(scenario(ROBOT, "own.toml")))
    assert rigid.motors(coupled=False)[0]["inertia"] == 2e-6
    assert rigid.motors(coupled=True)[0]["inertia"] == 1e-6


def test_cautions(mmcs, scenario):
    text = ROBOT.replace("gear = 1.0", "gear = 1.0\nservo.ilim = 20\nservo.ic_pos = 2000")
    out = good(mmcs("check", scenario(text, "own.toml")))
    assert "caution: axis 0: takes 3413 D/A units to break away, ilim is less" in out


def test_motors_are_drawn(mmcs, scenario, tmp_path):
    out = tmp_path / "out"
    drawn = ("--random", "robot.axis.all.friction=0.001..0.004", "--samples", "3")
    status, said, _ = mmcs("sweep", scenario(SHORT), "--out", out, *drawn)
    assert len({row["hash"] for row in rows_of(out)}) == 3
    assert status in (0, 1)
