# SPDX-License-Identifier: Apache-2.0
"""firmware/examples/motion.h, and the table of joints that `mmcs exec --robot` prints."""

import ctypes
import errno
import math

import numpy as np
import pytest

from mmcs.scenario.load import load_robot
from mmcs.scenario.robot_header import header, joint_of
from mmcs.tests.device_bench import (
    EXAMPLES,
    FLAGS,
    ROBOT,
    compile_example,
    output_in_lockstep,
)
from tools.compiled import compiled, written

PUMA = load_robot("puma560")[1]
JOINTS = [joint_of(PUMA, axis, 1000) for axis in range(6)]
TO = [0.5, -0.3, 0.8, 0.0, 0.2, -1.0]

PROBE = """
#include <motion.h>
#include "robot.h"
static struct motion m;
void begin(void) {
  memset(&m, 0, sizeof m);
  m.axis = robot; m.axes = ROBOT_AXES; m.interval = 1e-3;
}
int put(double time, double position, double velocity) {
  struct motion_point p = m.rest;
  p.position[0] = position;
  p.velocity[0] = velocity;
  return motion_put(&m, time, &p) < 0 ? errno : 0;
}
int quintic(const double *to, double share) { return motion_quintic(&m, to, share); }
int at(double time, double (*seen)[ROBOT_AXES]) {
  struct motion_point p;
  int goes_on = motion_at(&m, time, &p);
  for (int i = 0; i < m.axes; i++) {
    seen[0][i] = p.position[i];
    seen[1][i] = p.velocity[i];
    seen[2][i] = p.acceleration[i];
  }
  return goes_on;
}
"""


@pytest.fixture(scope="module")
def built():
    table = written("robot.h", header("puma560", 1000))
    flags = [*FLAGS, "-std=gnu17", "-Wconversion", "-Wshadow", "-Werror", "-fPIC", "-shared"]
    library = ctypes.CDLL(str(compiled("probe.so", ["gcc", *flags, f"-I{table.parent}"],
                                       [written("probe.c", PROBE)], ["-lm"])))  # fmt: skip
    library.at.argtypes = [ctypes.c_double, ctypes.c_void_p]
    library.put.argtypes = [ctypes.c_double] * 3
    library.quintic.argtypes = [ctypes.c_void_p, ctypes.c_double]
    return library


@pytest.fixture
def library(built):
    built.begin()
    return built


def samples(library, step=1e-3):
    """Position, velocity and acceleration of the joints to the end of the buffer."""
    got, rows, goes_on = (ctypes.c_double * 18)(), [], 1
    while goes_on:
        goes_on = library.at(step * (len(rows) + 1), got)
        rows.append(np.array(got).reshape(3, 6))
    return np.array(rows)


def test_the_profile_keeps_its_limits_and_all_joints_end_together(library):
    """At every sample, within the share; no joint moves before or after the others."""
    assert library.quintic((ctypes.c_double * 6)(*TO), 0.5) == 0
    rows = samples(library)
    used = []
    for order, limit in ((1, "speed"), (2, "acceleration")):
        limits = np.array([0.5 * joint[limit] for joint in JOINTS])
        used.append((np.abs(rows[:, order]).max(axis=0) / limits).max())
    assert 0.95 < max(used) <= 1 + 1e-9
    moving = [np.flatnonzero(rows[:, 1, n]) for n, to in enumerate(TO) if to]
    assert len({m[0] for m in moving}) == 1 and len({m[-1] for m in moving}) == 1
    assert rows[-1, 0] == pytest.approx(TO) and not rows[-1, 1].any()


def test_mistakes(library):
    nowhere, there = (ctypes.c_double * 6)(math.nan), (ctypes.c_double * 6)(*TO)
    assert library.put(1.0, math.nan, 0.0) == library.put(math.inf, 0.0, 0.0) == errno.EINVAL
    assert library.quintic(nowhere, 0.2) < 0
    assert library.quintic(there, 0.0) < 0
    assert not samples(library)[:, 0].any()  # nothing was taken


def test_motions_queue_and_go_through_their_knots(library):
    """Smooth positions and velocities through two profiles, whose ends are those asked for."""
    assert library.quintic((ctypes.c_double * 6)(*TO), 1.0) == 0
    assert library.quintic((ctypes.c_double * 6)(), 1.0) == 0
    rows = samples(library)
    assert rows[-1, 0] == pytest.approx([0.0] * 6)
    assert np.abs(rows[:, 0] - TO).max(axis=1).min() < 1e-4
    mean = (rows[1:, 1] + rows[:-1, 1]) / 2
    assert np.abs(np.diff(rows[:, 0], axis=0) / 1e-3 - mean).max() < 0.01


def test_the_buffer_is_bounded(library):
    assert library.put(0.0005, 0.0, 0.0) == errno.EINVAL  # the setpoints of then are written
    assert [library.put(0.01 * n + 1, 0.1, 0.0) for n in range(63)] == [0] * 63
    assert library.quintic((ctypes.c_double * 6)(*TO), 1.0) == -1  # neither of its two knots
    assert library.put(1.63, 0.1, 0.0) == 0
    assert library.put(2.0, 0.1, 0.0) == errno.EAGAIN
    assert library.at(1.105, (ctypes.c_double * 18)()) == 1
    assert [library.put(2.0 + n, 0.1, 0.0) for n in range(9)] == [0] * 9
    assert library.put(3.0, 0.1, 0.0) == errno.EINVAL  # earlier than the last
    library.begin()
    assert [library.put(0.01 * n + 1, 0.1, 0.0) for n in range(62)] == [0] * 62
    assert library.quintic((ctypes.c_double * 6)(*TO), 1.0) == 0  # the last two


def test_home_on_the_machine(tmp_path):
    """Two joints somewhere; their angles are the physics' afterwards."""
    move, pose = compile_example(EXAMPLES / "move.c"), "pose_deg=[70.0, -130.0]"
    said, status, _ = output_in_lockstep(tmp_path, move, sets=(pose,))
    assert status == 0, said
    counts = joint_of(load_robot(str(ROBOT))[1], 0, 1000)["counts"]
    for line, degrees in zip(said.splitlines(), (70.0, -130.0), strict=False):
        want = math.floor(-math.radians(degrees) * counts + 0.5)
        assert "0 rad is count" in line and int(line.split()[-1]) == want
