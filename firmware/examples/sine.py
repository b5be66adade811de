# SPDX-License-Identifier: Apache-2.0
"""A sine of 200 counts at 2 Hz on axis 0, and what the axis made of it.

mmcs exec --lockstep --scenario lab500 -- python firmware/examples/sine.py > sine.csv
"""

import math

import mmcs
from mmcs import mcdef as mc

INTERVAL_US, SAMPLES, HZ = 1000, 1000, 2.0

with mmcs.Device("/dev/mc0") as dev:
    dev.set_num_joints(1)
    dev.set_interval(INTERVAL_US)
    param = dev.get_param(0)  # Table 2.1, mode off
    gains = {"a0": 7309, "a1": -7027, "b0": 64, "ic_pos": 84, "ic_neg": 84}  # robots/lab500.toml
    dev.set_param(0, {**param, "mode": mc.MD_POS | mc.COULCOMP, **gains})
    dev.write([0])
    dev.enable()
    print("sample,setpoint,encoder,current")
    begin = now = dev.wait()  # the number of a servo sample
    while now - begin < SAMPLES:
        setpoint = round(200 * math.sin(2 * math.pi * HZ * (now - begin) * INTERVAL_US * 1e-6))
        dev.write([setpoint])
        state = dev.read(1)[0]
        print(f"{now - begin},{setpoint},{state.encnow},{state.inow}")
        now = dev.wait()
    dev.stop()
