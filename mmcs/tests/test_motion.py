# SPDX-License-Identifier: Apache-2.0
"""The motion library, C and Python: docs/use/motion.md."""

import ctypes
import errno
import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from mmcs import ROOT
from mmcs.device.motion import Motion, Point, header, joints_of, rest_at, zero_of
from mmcs.errors import InputError
from mmcs.scenario.load import load
from mmcs.tests.device_bench import (
    EXAMPLES,
    ROBOT,
    compile_example,
    compile_program,
    output_in_lockstep,
)
from tools.compiled import compiled, ran, written

JOINTS = joints_of("puma560")


class FakeDevice:
    """Joints that are where they are told to be."""

    def __init__(self):
        self.sample, self.setpoints = 7, [0] * 6

    def set_num_joints(self, joints):
        self.joints = joints

    def set_interval(self, us):
        self.us = us

    def interval(self):
        return self.us

    def get_param(self, axis):
        return {"which": axis}

    def set_param(self, axis, param):
        assert param["which"] == axis and param["mode"] & 1

    def enable(self):
        pass

    def wait(self):
        self.sample += 1
        return self.sample

    def read(self, axes):
        return [SimpleNamespace(encnow=self.setpoints[n], inow=100) for n in range(axes)]

    def write(self, setpoints):
        self.setpoints = setpoints

    def write_axis(self, axis, setpoint):
        self.setpoints[axis] = setpoint


def arm():
    motion = Motion(FakeDevice(), "puma560")
    motion.enable()
    return motion


TO = [0.5, -0.3, 0.8, 0.0, 0.2, -1.0]


@pytest.mark.parametrize("profile", ["trapezoid", "quintic", "jerk"])
def test_a_profile_keeps_its_limits_and_all_joints_end_together(profile):
    """At every sample, within the share; nobody moves before or after the others."""
    if profile == "jerk":
        pytest.importorskip("ruckig", reason='pip install "mmcs[motion]"')
    motion, rows = arm(), []
    motion.move(TO, 0.5, profile)
    while motion.step():
        rows.append(motion._at(motion.time)[1])
    speeds = np.abs([p.velocity for p in rows])
    rises = np.abs([p.acceleration for p in rows])
    for n, joint in enumerate(JOINTS):
        assert speeds[:, n].max() <= 0.5 * joint.speed * (1 + 1e-9)
        assert rises[:, n].max() <= 0.5 * joint.acceleration * (1 + 1e-9)
    near = [s.max() / (0.5 * j.speed) for s, j in zip(speeds.T, JOINTS, strict=True)]
    near += [s.max() / (0.5 * j.acceleration) for s, j in zip(rises.T, JOINTS, strict=True)]
    assert max(near) > 0.95  # somebody is at its limit, or it would be slower than it need be
    moving = [np.flatnonzero(s > 1e-9) for s, to in zip(speeds.T, TO, strict=True) if to]
    assert {m[0] for m in moving} == {0} or profile == "jerk"
    assert max(m[-1] for m in moving) - min(m[-1] for m in moving) <= 1
    assert motion.rest.position == pytest.approx(TO) and not any(motion.rest.velocity)


def test_moves_queue_and_a_motion_within_time():
    motion = arm()
    motion.move(TO, 1.0)
    motion.move([0.0] * 6, 1.0, "quintic")
    motion.move([0.0] * 6)  # there already
    motion.run()
    assert motion.rest.position == pytest.approx([0.0] * 6)
    assert motion.late == 0
    motion.device.sample += 5
    motion.step()
    assert motion.late == 5


def test_the_polynomial_goes_through_its_knots():
    motion = arm()
    start = motion.time
    to = Point(TO, [0.1, -0.2, 0.0, 0.3, 0.0, 0.0], [1.0, 0.0, -1.0, 0.0, 2.0, 0.0], [0.0] * 6)
    motion.put(start, motion.rest)
    motion.put(start + 0.5, to)
    motion.put(start + 1.0, rest_at(TO))
    early, late = (motion._at(start + t)[1] for t in (0.5 - 1e-9, 0.5))
    for a, b in zip((early.position, early.velocity, early.acceleration),
                    (late.position, late.velocity, late.acceleration), strict=True):  # fmt: skip
        assert a == pytest.approx(b, abs=1e-6)
    assert late.velocity == pytest.approx(to.velocity)


def test_mistakes():
    motion = arm()
    with pytest.raises(OSError, match="is earlier than") as caught:
        motion.put(0.0, motion.rest)
    assert caught.value.errno == errno.EINVAL
    with pytest.raises(OSError, match="must be one of"):
        motion.move(TO, profile="spline")
    nan = float("nan")
    for to in (TO[:5], [*TO[:5], nan], [nan] * 6):
        with pytest.raises(OSError, match="must be 6 finite numbers"):
            motion.move(to, 0.2, "quintic")
    for mistake in (lambda: motion.set(6, 0.0), lambda: motion.set(0, nan),
                    lambda: motion.move(TO, 0.0), lambda: motion.move(TO, nan)):  # fmt: skip
        with pytest.raises(OSError, match="must be") as caught:
            mistake()
        assert caught.value.errno == errno.EINVAL
    assert not motion._knots
    motion.put(motion.time, Point([0.0] * 6, [1.0] * 6, [0.0] * 6, [0.0] * 6))
    with pytest.raises(OSError, match="ended at a velocity") as caught:
        motion.run()
    assert caught.value.errno == errno.ETIME
    with pytest.raises(InputError):
        joints_of("nobody")


MISTAKES_C = """
#include <assert.h>
#include <motion.h>
int main(void) {
  struct motion_axis axis[2] = {{.speed = 1, .acceleration = 1}, {.speed = 1, .acceleration = 1}};
  struct motion m = {.axis = axis, .axes = 2, .interval = 0.001};
  struct motion_point point = {.position = {0, NAN}};
  double to[] = {NAN, 1.0}, there[] = {1.0, 1.0};
  assert(motion_put(&m, 1.0, &point) < 0 && errno == EINVAL);
  assert(motion_put(&m, INFINITY, &m.rest) < 0 && errno == EINVAL);
  errno = 0;
  assert(motion_set(&m, 2, 0.0) < 0 && errno == EINVAL);
  assert(motion_set(&m, 0, NAN) < 0 && m.rest.position[0] == 0.0);
  assert(motion_quintic(&m, to, 0.2) < 0 && motion_trapezoid(&m, to, 0.2) < 0 && m.used == 0);
  assert(motion_quintic(&m, there, 0.0) < 0 && errno == EINVAL);
  return 0;
}
"""


def test_mistakes_in_c():
    program = compile_program(written("mistakes.c", MISTAKES_C))
    assert ran(program).returncode == 0


def test_without_ruckig_it_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(OSError, match=r"pip install .mmcs\[motion\]"):
        arm().move(TO, profile="jerk")


def test_units():
    """Counts by gear and encoder; amperes by the amplifier; 12 bits over +-10 V."""
    motion = arm()
    assert JOINTS[0].counts == pytest.approx(1000 * -62.6111 / math.tau)
    assert JOINTS[0].per_ampere == pytest.approx(2048 / 10 / 0.883)
    assert motion.currents()[0] == pytest.approx(100 * 0.883 * 10 / 2048)
    motion.set(1, 0.25)
    assert motion.device.setpoints[1] == round(0.25 * JOINTS[1].counts)
    push = Point([0.0] * 6, [0.0] * 6, [0.0] * 6, [2.0] + [0.0] * 5)
    for _ in range(1000):
        ahead, *others = motion._setpoints(push)
    law = JOINTS[0].param
    gain = (law["a0"] + law["a1"]) / (law["b0"] + law["b1"])  # of the compensator, at rest
    assert ahead * gain == pytest.approx(2.0 * JOINTS[0].per_ampere, rel=0.02)
    assert others == [0] * 5


# --- the same in C, and on the machine ------------------------------------------------------------

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
int trapezoid(const double *to, double share) { return motion_trapezoid(&m, to, share); }
int quintic(const double *to, double share) { return motion_quintic(&m, to, share); }
int at(double time, int *setpoints) {
  struct motion_point p;
  int goes_on = motion_at(&m, time, &p);
  for (int i = 0; i < m.axes; i++) setpoints[i] = motion_setpoint(&m, i, &p);
  return goes_on;
}
int zero(int axis, int adc, int encoder, int index) {
  return motion_zero(&robot[axis], adc, encoder, index);
}
"""


@pytest.fixture(scope="module")
def c_library():
    table = written("robot.h", header("puma560", 1000))
    flags = ["-std=gnu17", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror", "-O2",
             "-fPIC", "-shared", f"-I{table.parent}", f"-I{ROOT / 'firmware/lib'}"]  # fmt: skip
    flags += [f"-I{ROOT / d}" for d in ("firmware/include", "sim/device/include")]
    library = ctypes.CDLL(str(compiled("probe.so", ["gcc", *flags], [written("probe.c", PROBE)],
                                       ["-lm"])))  # fmt: skip
    library.at.argtypes = [ctypes.c_double, ctypes.c_void_p]
    library.put.argtypes = [ctypes.c_double] * 3
    for name in ("trapezoid", "quintic"):
        getattr(library, name).argtypes = [ctypes.c_void_p, ctypes.c_double]
    library.begin()
    return library


def test_c_and_python_make_the_same_setpoints(c_library):
    """To the bit, at every sample of two motions."""
    library, motion = c_library, Motion(FakeDevice(), "puma560")
    motion.begin = motion.sample = 0
    to = (ctypes.c_double * 6)(*TO)
    back = (ctypes.c_double * 6)()
    got = (ctypes.c_int * 6)()
    library.begin()
    assert library.trapezoid(to, 0.3) == library.quintic(back, 0.9) == 0
    motion.move(TO, 0.3)
    motion.move([0.0] * 6, 0.9, "quintic")
    motion.device.sample, goes_on, count = 0, True, 0
    while goes_on:
        goes_on = motion.step()
        assert library.at(motion.time, got) == goes_on
        assert list(got) == motion.device.setpoints
        count += 1
    assert count > 1000


def test_the_buffer_of_c_is_bounded(c_library):
    c_library.begin()
    assert c_library.put(0.0005, 0.0, 0.0) == errno.EINVAL  # the setpoints of then are written
    assert [c_library.put(0.01 * n + 1, 0.1, 0.0) for n in range(64)] == [0] * 64
    assert c_library.put(2.0, 0.1, 0.0) == errno.EAGAIN
    got = (ctypes.c_int * 6)()
    assert c_library.at(1.105, got) == 1
    assert [c_library.put(2.0 + n, 0.1, 0.0) for n in range(9)] == [0] * 9
    assert c_library.put(3.0, 0.1, 0.0) == errno.EINVAL  # earlier than the last


def test_zero_by_potentiometer_and_index(c_library):
    """Any angle: the index gives the count at 0 rad exactly, C as Python."""
    for axis, joint in enumerate(JOINTS):
        for angle in np.linspace(-1.5, 1.5, 31):
            adc = math.floor(joint.pot_zero + angle / joint.pot + 0.5)
            absolute = math.floor(angle * joint.counts + 0.5)  # where the encoder reads 0
            index = -absolute % joint.turn
            state = SimpleNamespace(adcvai=adc, encnow=0)
            assert zero_of(joint, state, index) == -absolute
            assert c_library.zero(axis, adc, 0, index) == -absolute


SETS = ("pose_deg=[70.0, -130.0]",)


def test_home_on_the_machine(tmp_path):
    """Two joints somewhere; their angles are the physics' afterwards, from C and from Python."""
    text = f"""
import mmcs
with mmcs.Device() as dev:
    arm = mmcs.Motion(dev, {str(ROBOT)!r})
    arm.enable()
    arm.home()
    for joint, at, zero in zip(arm.joints, arm.rest.position, arm.zero):
        print(f"{{joint.name}} is at {{at:.4f}} rad, 0 rad is count {{zero}}")
"""
    outs = []
    for command in ([compile_example(EXAMPLES / "home.c")], [sys.executable, "-c", text]):
        said, status, _ = output_in_lockstep(tmp_path, *command, sets=SETS)
        assert status == 0, said
        outs.append(said)
    assert outs[0] == outs[1]
    rows = [line.split() for line in said.splitlines()]
    counts = joints_of(str(ROBOT))[0].counts
    for row, degrees in zip(rows, (70.0, -130.0), strict=True):
        assert int(row[-1]) == math.floor(-math.radians(degrees) * counts + 0.5)


@pytest.mark.parametrize("ahead", [True, False])
def test_feedforward_follows_closer(ahead, tmp_path):
    """The same motion with and without: farthest off, counts. What is left is friction."""
    take_away = "" if ahead else (
        "arm.joints = [replace(j, inertia=0.0, friction=0.0) for j in arm.joints]")  # fmt: skip
    text = f"""
from dataclasses import replace
import mmcs
with mmcs.Device() as dev:
    arm = mmcs.Motion(dev, {str(ROBOT)!r})
    {take_away}
    arm.enable()
    arm.move([20.0, -20.0], 0.5, "quintic")
    most, asked, going = 0, arm.positions(), True
    while going:
        going = arm.step()
        most = max(most, *(abs(a - b) * 318.3 for a, b in zip(asked, arm.positions())))
        asked = arm._at(arm.time)[1].position
    print(most)
"""
    off, status, _ = output_in_lockstep(tmp_path, sys.executable, "-c", text)
    assert status == 0 and (float(off) < 10 if ahead else float(off) > 50)


def test_the_header_is_of_the_scenario_s_robot():
    setup = load("puma560")
    text = header("puma560", 1000)
    for params in setup.params:
        assert f".a0 = {params['a0']}, " in text
        assert f".b0 = {params['b0']}, " in text and f".ilim = {params['ilim']}, " in text
