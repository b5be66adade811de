# SPDX-License-Identifier: Apache-2.0
"""Two processes, an axis each: write_axis() of the one leaves the other's setpoint alone.

mmcs exec --lockstep --scenario puma560 -- python firmware/examples/two.py
"""

import math
import os

import mmcs
from mmcs import mcdef as mc

AXES, SAMPLES = 2, 600
first = mmcs.Device()
first.set_num_joints(AXES)
first.set_interval(1000)
for axis in range(AXES):
    first.change_param(axis, mode=mc.MD_POS, a0=7309, a1=-7027, b0=64)
first.enable()
begin = first.wait()
mine = 0 if os.fork() else 1
with mmcs.Device() as dev:
    farthest = 0
    for _ in range(SAMPLES):
        t = (dev.wait() - begin) * 1e-3
        dev.write_axis(mine, round(100 * math.sin(2 * math.pi * (2 + mine) * t)))
        farthest = max(farthest, abs(dev.read(AXES)[mine].encnow))
    print(f"axis {mine} went {farthest} counts to one side", flush=True)
if mine == 0:
    os.wait()
    first.stop()
