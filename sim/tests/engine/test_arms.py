# SPDX-License-Identifier: Apache-2.0
"""Random arms: what `mmcs check` refuses and why, and that those it accepts stay within what their
energy allows."""

import math
import random
from types import SimpleNamespace

import machines
import numpy as np
import pytest

from mmcs import arm as checks
from mmcs import ensure_library, load_robot, robot_cautions

ARMS = 60
CONFIG = {"cards": 1, "axes": 2, "links": 2, "seed": 1, "bus_timeout_us": 16.0, "skip": 1,
          "gravity": [0.0, -9.81, 0.0]}  # fmt: skip


def exponent(chance, low, high):
    return 10 ** chance.uniform(low, high)


def random_arm(chance):
    motors = [{
        "rotor_inertia": exponent(chance, -5, -3), "viscous": exponent(chance, -5, -3),
        "coulomb_pos": 0.0, "coulomb_neg": 0.0, "stiction_pos": 0.0, "stiction_neg": 0.0,
        "km": 0.1, "resistance": exponent(chance, -2, 1), "v_supply": 40.0, "amp_gain": 1.0,
        "amp_max": 5.0, "gear": chance.choice([1.0, -60.0, 100.0]), "stop_lo": 0.0,
        "stop_hi": 0.0, "angle0": chance.uniform(-1, 1), "counts_per_rev": 1000,
        "stiffness": chance.choice([0.0, exponent(chance, 1, 6)]), "damping": 0.0,
    } for _ in range(2)]  # fmt: skip
    for motor in motors:
        if motor["stiffness"]:
            motor["damping"] = chance.choice([0.0, exponent(chance, -2, 3)])
    links = [{
        "alpha": chance.choice([0.0, math.pi / 2]), "a": chance.uniform(0.05, 0.5), "d": 0.0,
        "theta0": 0.0, "mass": exponent(chance, -2, 1), "com": [-0.1, chance.uniform(-0.1, 0.1), 0],
        "inertia": [exponent(chance, -5, -1) for _ in range(3)] +
        [chance.choice([0.0, exponent(chance, -5, -2)]), 0.0, 0.0],
    } for _ in range(2)]  # fmt: skip
    return motors, links


def told(motors, links):
    """What `mmcs check` says of it."""
    for m in motors:
        if m["rotor_inertia"] < (m["km"] ** 2 / m["resistance"] - m["viscous"]) * checks.STEP_S:
            return "winding"
    if not all(checks.is_body(link["inertia"]) for link in links):
        return "body"
    robot = SimpleNamespace(
        axis=[SimpleNamespace(**m) for m in motors], link=[SimpleNamespace(**x) for x in links]
    )
    found = [key.rpartition(".")[2] for key, _ in checks.stiff_joints(robot)]
    return found[0] if found else "good"


def energy_speed(motors, links):
    """Faster than this no joint can be that only falls: all links from the highest place to the
    lowest, and all that energy in the lightest thing that turns; of two joints that turn it."""
    reach = sum(link["a"] + math.hypot(*link["com"]) for link in links)
    energy = sum(link["mass"] for link in links) * 9.81 * 2 * reach
    light = []
    for motor, link in zip(motors, links, strict=True):
        x, y, z, xy, yz, xz = link["inertia"]
        body = float(np.linalg.eigvalsh([[x, xy, xz], [xy, y, yz], [xz, yz, z]])[0])
        rotor = motor["rotor_inertia"] * motor["gear"] ** 2
        light.append(min(rotor, body) if motor["stiffness"] else rotor)
    return 2 * math.sqrt(2 * energy / max(min(light), 1e-9))


def test_random_arms():
    chance, library = random.Random(1989), ensure_library(1, "speed")
    seen, fastest = {}, 0.0
    for _ in range(ARMS):
        motors, links = random_arm(chance)
        found = told(motors, links)
        seen[found] = seen.get(found, 0) + 1
        if found != "good":
            continue
        given = [{k: v for k, v in m.items() if k != "rotor_inertia"}
                 | {"inertia": m["rotor_inertia"]} for m in motors]  # fmt: skip
        with machines.made(library, CONFIG, given, links) as sim:
            assert sim.run(0.1)
            for axis in range(2):
                truth = sim.true(axis)
                fastest = max(fastest, abs(truth["velocity"]) / energy_speed(motors, links))
                assert math.isfinite(truth["angle"])
                assert abs(truth["velocity"]) < energy_speed(motors, links), (motors, links)
    print(f"{ARMS} random arms: {seen}, {fastest:.2f} of the bound")
    assert set(seen) >= {"good", "stiffness", "winding", "body"} and seen["good"] >= 10


FLEXIBLE = {"rotor_inertia": 1e-4, "km": 0.1, "resistance": 1.0, "viscous": 0.0, "gear": 60.0,
            "stiffness": 1e4, "damping": 0.1, "angle0": 0.0, "stop_lo": 0.0,
            "stop_hi": 0.0}  # fmt: skip
LINK = {"alpha": 0.0, "a": 0.3, "d": 0.0, "theta0": 0.0, "mass": 2.0, "com": [-0.15, 0, 0],
        "inertia": [0.01, 0.02, 0.02, 0, 0, 0]}  # fmt: skip


@pytest.mark.parametrize(("motor", "link", "why"), [
    ({}, {}, "good"),
    ({"stiffness": 1e7}, {}, "stiffness"),
    ({}, {"mass": 1e-3, "inertia": [1e-5] * 3 + [0.0] * 3}, "stiffness"),
    ({"damping": 2e3}, {}, "damping"),
    ({}, {"mass": 0.0, "inertia": [0.0] * 6}, "stiffness"),
    ({}, {"inertia": [0.01, 0.02, 0.02, 0.1, 0, 0]}, "body"),
    ({}, {"inertia": [0.01] * 3 + [0.02] * 3}, "body"),  # two below 0
    ({}, {"inertia": [0.01] * 3 + [-0.008] * 3}, "body"),  # one
    ({"resistance": 1e-4}, {}, "winding"),
])  # fmt: skip
def test_what_explodes_is_refused(motor, link, why):
    rigid = FLEXIBLE | {"stiffness": 0.0, "damping": 0.0}
    assert told([rigid, FLEXIBLE | motor], [LINK, LINK | link]) == why


@pytest.mark.parametrize(("inertia", "body"), [
    ([0.01, 0.02, 0.03, 0, 0, 0], True),  # a plate
    ([0.01, 0.02, 0.031, 0, 0, 0], False),
    ([0.02, 0.02, 0.02, 0.011, 0, 0], False),  # 0.009, 0.031, 0.02: turned by 45 degrees
    ([0.02, 0.02, 0.02, 0.005, 0, 0], True),  # 0.015, 0.025, 0.02
    ([0.02, 0.02, 0.005, 0.015, 0, 0], False),  # 0.005, 0.035, 0.005
])  # fmt: skip
def test_inertia_beyond_the_triangle_is_told(inertia, body):
    """It can be integrated, and published ones are so: a caution."""
    robot = load_robot("puma560")[1]
    robot.link[1].inertia = inertia
    robot.link[2].inertia = [0.01] * 3 + [0.0] * 3
    cautions = [text for text in robot_cautions(robot) if text.startswith("link")]
    wrong = ["link 1: its greatest principal inertia is more than the sum of the other two"]
    assert [text.rpartition(",")[0] for text in cautions] == ([] if body else wrong)


def test_angle_and_encoder_are_of_one_instant():
    """The log's angle is that of the SCLOCK edge, as the encoder is."""
    library = ensure_library(1, "speed")
    motor = {"inertia": 1e-4, "km": 0.1, "resistance": 1.0, "amp_gain": 1.0, "gear": 1.0,
             "counts_per_rev": 8000, "viscous": 1e-5}  # fmt: skip
    config = CONFIG | {"axes": 1, "links": 0, "gravity": [0.0] * 3}
    with machines.made(library, config, [motor]) as sim:
        client = sim.open(2)
        sim.add_event(sim.time, sim.input_names().index("load_torque"), 0, -0.05)
        sim.start_motion(client)
        assert sim.run(sim.time + 0.2)
        log = sim.log()
        assert log[-1, 3] != 0 or log[-1, 2] > 5000
        turned = log[:, 7] * 8000 / (2 * math.pi) - log[:, 2]
        assert abs(turned - turned[0]).max() <= 1.001
