# SPDX-License-Identifier: Apache-2.0
"""As six.c, from Python."""

import sys

import mmcs

SAMPLES, TO = int([*sys.argv, 1400][1]), (5000, 6000, 4000, 6000, 5000, 6000)

with mmcs.Device() as dev:
    arm = mmcs.Motion(dev, "puma560")
    arm.enable()
    for n in range(SAMPLES):
        s = min(max(n - 50, 0) / 800.0, 1)
        share = s * s * s * (10 + s * (6 * s - 15))
        dev.wait()
        dev.read(arm.axes)
        step = 200 if n >= 1000 else 0
        dev.write([round(to * share) + step for to in TO])
    dev.stop()
