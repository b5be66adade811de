# SPDX-License-Identifier: Apache-2.0
"""A program that runs away, and a monitor that stops it: a read-only open may stop the machine.

mmcs exec --lockstep --scenario lab500 -- python firmware/examples/guard.py
"""

import os

import mmcs
from mmcs import mcdef as mc

FASTEST = 60  # counts per servo period

if os.fork():
    with mmcs.Device(flags=os.O_RDONLY) as monitor:
        while abs(monitor.read(1)[0].vel) < FASTEST:
            monitor.wait()
        monitor.stop()
        status = monitor.status()
        print(f"stopped by the monitor: {status.stopped_by == os.getpid()}", flush=True)
        os.wait()
else:
    with mmcs.Device() as dev:
        dev.set_num_joints(1)
        dev.change_param(0, mode=mc.MD_VEL, a0=100, b0=1)
        dev.enable()
        try:
            for n in range(2000):
                dev.write([n // 10])
                dev.wait()
        except OSError as error:
            print(f"sample {n}: {error.strerror}", flush=True)
