# SPDX-License-Identifier: Apache-2.0
"""All joints of a robot by 0.2 rad at once, jerk limited, with the package ruckig.

mmcs exec --lockstep --scenario puma560 -- python firmware/examples/move.py puma560
"""

import sys

from ruckig import InputParameter, Result, Ruckig, Trajectory

import mmcs
from mmcs import mcdef as mc

_, robot = mmcs.load_robot(sys.argv[1])
axes = range(robot.axes())
counts = [robot.counts_per_rad(axis) for axis in axes]
with mmcs.Device() as dev:
    dev.set_num_joints(len(axes))
    dev.set_interval(1000)
    for axis in axes:
        servo = robot.servo(axis, 1000)
        mode = mc.mode_word(servo.pop("mode"), servo.pop("flags"))
        dev.set_param(axis, dev.get_param(axis) | {"mode": mode, **servo})
    dev.enable()
    begin = now = dev.wait()
    start = [s.encnow / c for s, c in zip(dev.read(len(axes)), counts, strict=True)]
    goal, way = InputParameter(len(axes)), Trajectory(len(axes))
    goal.current_position, goal.target_position = start, [q + 0.2 for q in start]
    goal.max_velocity, goal.max_acceleration = [0.5] * len(axes), [2.0] * len(axes)
    goal.max_jerk = [20.0] * len(axes)
    assert Ruckig(len(axes)).calculate(goal, way) == Result.Working
    while (now - begin) * 1e-3 < way.duration:
        position = way.at_time((now + 1 - begin) * 1e-3)[0]
        dev.write([round(q * c) for q, c in zip(position, counts, strict=True)])
        now = dev.wait()
    off = [s.error for s in dev.read(len(axes))]
    print(f"there after {way.duration:.3f} s; {off} counts off")
    dev.stop()
