# SPDX-License-Identifier: Apache-2.0
"""The arm against the Robotics Toolbox's PUMA 560, and the robot file against its parameters."""

import numpy as np
import pytest
from test_plant import build

from mmcs import load
from tools.compiled import ran

SEED = 1989
STATES = 500


@pytest.fixture(scope="module")
def puma():
    rtb = pytest.importorskip(
        "roboticstoolbox",
        reason="roboticstoolbox is missing; install it with: uv pip install -e .[test]",
    )
    return rtb.models.DH.Puma560()


def test_robot_file_is_the_toolbox_robot(puma):
    robot = load("puma560").robot
    for axis, link, joint in zip(robot.axis, robot.link, puma.links, strict=True):
        assert np.allclose([link.alpha, link.a, link.d], [joint.alpha, joint.a, joint.d])
        xx, yy, zz, xy, yz, xz = link.inertia
        assert np.array_equal([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], joint.I)
        assert link.mass == joint.m
        assert link.com == list(joint.r)
        assert (axis.gear, axis.rotor_inertia) == (joint.G, joint.Jm)
        assert axis.viscous == joint.B
        # The toolbox gives Coulomb friction by the joint's direction, we by the motor's.
        positive, negative = joint.Tc if joint.G > 0 else -joint.Tc[::-1]
        assert (axis.coulomb_pos, axis.coulomb_neg) == (positive, -negative)


def test_dynamics_equal_the_toolbox(puma):
    rng = np.random.default_rng(SEED)
    q = rng.uniform(-np.pi, np.pi, (STATES, 6))
    qd = rng.uniform(-3, 3, (STATES, 6))
    qdd = rng.uniform(-10, 10, (STATES, 6))
    lines = "\n".join(" ".join(f"{x:.17g}" for x in row) for row in np.hstack([q, qd, qdd]))
    done = ran(build("arm_oracle"), input=lines, check=True)
    ours = np.array([row.split() for row in done.stdout.splitlines()], dtype=float)
    assert ours.shape == (STATES, 48)
    free = puma.nofriction(coulomb=True, viscous=True)
    torque = np.array([free.rne(*state) for state in zip(q, qd, qdd, strict=True)])
    mass = np.array([free.inertia(pose).ravel() for pose in q])
    # The toolbox's inertia() is the links' and the rotors'.
    worst = [
        np.abs(ours[:, :6] - torque).max(),
        np.abs(ours[:, 6:42] - mass).max(),
        np.abs(ours[:, 42:] - qdd).max(),
    ]
    print(f"seed {SEED}: torque {worst[0]:.2g} N m, mass matrix {worst[1]:.2g} kg m2,", end=" ")
    print(f"acceleration {worst[2]:.2g} rad/s2")
    assert max(worst) < 1e-9, worst
