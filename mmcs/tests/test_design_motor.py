# SPDX-License-Identifier: Apache-2.0
"""What `mmcs design` says of friction, limit and the step to expect, against the machine."""

import json
import re

import pytest

from mmcs import ROOT
from mmcs.scenario.load import load_robot
from mmcs.scenario.motor import compensation

pytestmark = pytest.mark.req("SYN-1")


@pytest.mark.parametrize("robot", ["lab500", "puma560"])
def test_compensation_is_that_of_the_robot_files(robot):
    motors = load_robot(robot)[1].axis
    for motor in motors:
        pos, neg = compensation(motor)
        assert abs(pos - motor.servo.ic_pos) <= 1 and abs(neg - motor.servo.ic_neg) <= 1
    reversed_axis = motors[0].model_copy(update={"amp_gain": -motors[0].amp_gain})
    assert compensation(reversed_axis) == tuple(-ic for ic in compensation(motors[0]))


def test_the_design_says_where_the_machine_rests(mmcs, tmp_path):
    """The bounds that the program prints hold in the machine, and are not far from what it does."""
    status, said, _ = mmcs("design", "--wn", "80", "--robot", "lab500")
    bounds = re.search(r"may rest (\d+) counts off its setpoint, (\d+) without", said)
    first = re.search(r"a step of more than (\d+) counts begins at ilim 1024", said)
    assert status == 0 and "ic_pos 84, ic_neg 84" in said and first
    for flags, bound in (('["coulcomp"]', bounds[1]), ("[]", bounds[2])):
        out = tmp_path / bound
        mmcs("run", "lab500", "--set", f"axis.0.flags={flags}", "--out", str(out))
        error = json.loads((out / "report.json").read_text())["axes"][0]["steady_error_counts"]
        assert 0.3 * int(bound) - 1 <= error <= int(bound)
    for step, cut in ((int(first[1]) - 1, False), (int(first[1]) + 2, True)):
        out = tmp_path / f"step{step}"
        said = mmcs("run", "lab500", "--set", f"motion.0.to={step}", "--out", str(out))[1]
        assert ("the limit cut the current" in said) == cut
        assert (
            json.loads((out / "report.json").read_text())["axes"][0]["limited_samples"] > 0
        ) == cut


@pytest.mark.parametrize("axis, options", [(0, ()), (0, ("--wn", "40")), (1, ()), (5, ())])
def test_the_expected_step_is_the_machine_s(mmcs, tmp_path, axis, options):
    """On the bench motor, and on joints of the PUMA, of which one counts the other way."""
    robot = "puma560" if axis else "lab500"
    wanted = ("--robot", robot, "--axis", axis, *(options or ("--wn", "80")))
    said = mmcs("design", *map(str, wanted))[1]
    told = r"rises in (\d+) ms, overshoots by (\d+) %, ends (\d+) counts off"
    rise, over, off = map(int, re.search(told, said).groups())
    pasted = mmcs("design", *map(str, wanted), "--toml")[1]
    made = dict(re.findall(r"^([a-z]\w+) = (-?\d+)$", pasted, re.M))
    sets = [f"--set=axis.{axis}.{key}={value}" for key, value in made.items() if key != "axis"]
    text = f'description = "step"\nrobot = "{robot}"\ncards = {3 if axis else 1}\nduration = 0.7\n'
    (tmp_path / "s.toml").write_text(
        f'{text}[[motion]]\naxis = {axis}\nkind = "step"\nat = 0.05\nto = 200\n'
    )
    mmcs("run", str(tmp_path / "s.toml"), *sets, "--out", str(tmp_path / "run"))
    seen = json.loads((tmp_path / "run" / "report.json").read_text())["axes"][axis]
    assert abs(seen["rise_ms"] - rise) <= max(3, 0.1 * rise), (seen["rise_ms"], rise)
    assert abs(seen["overshoot_pct"] - over) <= 2
    assert abs(abs(seen["steady_error_counts"]) - off) <= 3


def test_the_first_hour_tells_what_the_design_expects(mmcs, tmp_path):
    page = (ROOT / "docs" / "use" / "first_hour.md").read_text()
    motor = tmp_path / "motor.toml"
    motor.write_text(re.search(r"```toml motor.toml\n(.*?)```", page, re.S)[1])
    said = mmcs("design", "--wn", "80", "--robot", str(motor))[1]
    rise, off = re.search(r"rises in (\d+) ms, .* ends (\d+) counts off", said).groups()
    told = f"rises in {rise} ms and ends {off} counts from its setpoint"
    assert told in " ".join(page.split())


def test_a_step_that_friction_stops_is_told(mmcs, tmp_path):
    (tmp_path / "stiff.toml").write_text(
        'title = "stiff"\n[[axis]]\ninertia = 1e-5\nkm = 0.02\namp_gain = 0.3\n'
        "counts_per_rev = 2000\ncoulomb_pos = 0.02\n"
    )
    said = mmcs("design", "-p", "1", "-d", "0.01", "--robot", str(tmp_path / "stiff.toml"))[1]
    assert "expected: a step of 200 counts ends at" in said and "short of 90 %" in said
