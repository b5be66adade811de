# SPDX-License-Identifier: Apache-2.0
"""All joints of a robot at once, with the motion library: there with constant acceleration, back on
a polynomial of fifth order; and how far they were off.

mmcs exec --lockstep --scenario puma560 -- python firmware/examples/move.py puma560
"""

import sys

import mmcs

with mmcs.Device() as dev:
    arm = mmcs.Motion(dev, sys.argv[1])
    arm.enable()
    back = arm.positions()
    to = [q + 1.0 / (2 + n) for n, q in enumerate(back)]  # rad
    for profile, goal in (("trapezoid", to), ("quintic", back)):
        arm.move(goal, 0.2, profile)
        began, most, goes_on = arm.time, [0] * arm.axes, True
        while goes_on:
            goes_on = arm.step()
            most = [max(a, abs(s.error)) for a, s in zip(most, dev.read(arm.axes), strict=True)]
        names = " ".join(f"{j.name} {e}" for j, e in zip(arm.joints, most, strict=True))
        print(f"{profile}: {arm.time - began:.3f} s; {names} counts off")
    dev.stop()
