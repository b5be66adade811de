# SPDX-License-Identifier: Apache-2.0
"""The servo law in C against servo_reference.py where chance seldom leads: every small coefficient
of both signs, limits that are exactly met, friction at rest."""

from itertools import product

import pytest
import servo_reference as ref
from test_servo import run_both

OPEN = ref.POS | ref.ZEROFB  # error = setpoint
ERRORS = [(0, 0, e) for e in (5, -3, 1, 0, 2, -1, 7, 7)]
LARGEST = 2**31 - 1


@pytest.mark.req("SRV-2")
@pytest.mark.parametrize("b0", [1, 2, 3, -1, -2])
def test_small_coefficients(b0):
    roots = {(0, 0), (-b0, 0), (b0, 0), (-b0, -1), (-b0, 1), (-b0 - 1, 0), (1 - b0, 0), (0, -b0),
             (0, b0), (-2 * b0, b0), (2 * b0, -b0), (1, -1)}  # fmt: skip
    for a in product([-1, 0, 1, 2], repeat=3):
        for b1, b2 in sorted(roots):
            run_both(ref.Params(a0=a[0], a1=a[1], a2=a[2], b0=b0, b1=b1, b2=b2, mode=OPEN), ERRORS)


@pytest.mark.req("SRV-4")
@pytest.mark.parametrize("sign", [1, -1])
def test_overload_is_more_than_the_limit(sign):
    """At the limit is no overload, whatever the limit; one unit of friction more is."""
    for limit in (0, 1, 100, 2046, 2047, 2048, LARGEST):
        p = ref.Params(mode=ref.TORQ, ilim=limit, ilimax=1)
        assert not run_both(p, [(0, 0, sign * limit)] * 5)[:, 7].any()
        p.mode |= ref.COULCOMP
        p.ic_pos = p.ic_neg = 1
        if limit:
            assert run_both(p, [(0, 0, sign * limit)] * 5)[:, 7].any()
        p.mode, p.ilimax = ref.TORQ, 0
        for over in (-1, 0, 1):
            run_both(p, [(0, 0, max(-LARGEST - 1, min(LARGEST, sign * (limit + over))))] * 2)


@pytest.mark.req("SRV-3")
def test_friction_at_rest_in_either_direction():
    for pos, neg, u in product([-2, -1, 0, 1, 2], [-2, -1, 0, 1, 2], [-2, -1, 0, 1, 2]):
        p = ref.Params(mode=ref.TORQ | ref.COULCOMP, ic_pos=pos, ic_neg=neg)
        run_both(p, [(0, 0, u)])
        for step in (-1, 1):  # and when it moves
            run_both(p, [(0, 0, u), (step & 0xFFFF, 0, u), (step & 0xFFFF, 0, u)])


@pytest.mark.req("SRV-6")
def test_triangles_of_every_small_height():
    for limit, ilimax in product(range(-1, 6), (0, 1)):
        p = ref.Params(mode=ref.TEST1, ilim=limit, ilimax=ilimax)
        run_both(p, [(0, 0, 0)] * 30)


@pytest.mark.req("DRV-10", "SRV-6")
def test_limits_are_crossed_by_going_beyond():
    for low, high in [(-3, 3), (0, 0), (2, -2), (-(2**31), LARGEST)]:
        p = ref.Params(mode=ref.POS | ref.POSCHK, plo=low, phi=high)
        run_both(p, [(c & 0xFFFF, 0, 0) for c in (0, 3, 4, 3, -3, -4, -5, -3, 5, -5, 0)])
