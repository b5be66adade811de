# SPDX-License-Identifier: Apache-2.0
"""The servo law in C against servo_reference.py, bit by bit, over random parameters and corners."""

import os
import random
from dataclasses import fields
from itertools import product
from pathlib import Path

import cffi
import numpy as np
import pytest
import servo_reference as ref
from fwbuild import ROOT, compile_c

from mmcs import mcdef

SAMPLES = 100  # per set of parameters
TOTAL = 1_000_000
QUICK = 100_000
CORNERS = [0, 1, -1, 2, -2, 1024, -1024, 2047, 2048, 32767, -32768, 65535,
           2**31 - 1, -(2**31), 2**31 - 2, -(2**31) + 1]  # fmt: skip
COLUMNS = ["position", "phi", "fb", "vel", "error", "current", "inow", "events", "clipped"]


class Axis:
    """The C law behind the same calls as the reference."""

    def __init__(self, params: ref.Params, counter: int):
        self.ffi, self.lib = library()
        self.x = self.ffi.new("char[]", self.lib.axis_size())
        self.lib.axis_start(self.x, self.param(params), counter)

    def param(self, params: ref.Params):
        par = self.ffi.new("struct mc_param *")
        for f in fields(params):
            setattr(par, f.name, getattr(params, f.name))
        return par

    def change(self, params: ref.Params) -> None:
        self.lib.axis_change(self.x, self.param(params))

    def run(self, rows: np.ndarray) -> np.ndarray:
        out = np.zeros((len(rows), 9), np.int32)
        self.lib.axis_run(self.x, len(rows), self.ffi.cast("int *", rows.ctypes.data),
                          self.ffi.cast("int *", out.ctypes.data))  # fmt: skip
        return out


_loaded = []


def library():
    if not _loaded:
        sources = sorted((ROOT / "firmware" / "mc").glob("servo*.c"))
        sources.append(Path(__file__).parent / "servo_batch.c")
        path = compile_c("servo.so", sources, ["-O2", "-shared", "-fPIC"])
        ffi = cffi.FFI()
        ffi.cdef(mcdef.structures())
        ffi.cdef("""size_t axis_size(void);
            void axis_start(void *x, const struct mc_param *par, uint16_t counter);
            void axis_change(void *x, const struct mc_param *par);
            int axis_wide(const void *x);
            void axis_run(void *x, int n, const int *in, int *out);""")
        _loaded.extend([ffi, ffi.dlopen(str(path))])
    return _loaded


def number(rng: random.Random) -> int:
    """Any 32-bit number, small ones and corners more often than chance would have them."""
    kind = rng.random()
    if kind < 0.2:
        return rng.choice(CORNERS)
    bits = rng.choice([4, 8, 12, 16, 24, 31])
    return rng.randrange(-(1 << bits), 1 << bits)


def edge(rng: random.Random, bound: int) -> int:
    """Either way, more often than not at a power of two or at the bound, or one beside it."""
    size = rng.choice([bound, 1 << rng.randrange(bound.bit_length()), rng.randrange(bound + 1)])
    return rng.choice([1, -1]) * (size + rng.choice([0, 0, 0, 1, -1]))


def narrow(rng: random.Random) -> ref.Params:
    """About the bounds between which servo_narrow.c computes in 32 bits."""
    p = ref.Params(b0=edge(rng, 1 << 14) or 1)
    p.a0, p.a1, p.a2 = (edge(rng, 1 << rng.choice([8, 16, 29])) for _ in range(3))
    p.b1, p.b2 = (rng.choice([0, -p.b0, edge(rng, 2 * abs(p.b0))]) for _ in range(2))
    p.ic_pos, p.ic_neg = edge(rng, 1 << 28), edge(rng, 1 << 28)
    p.adc_a, p.adc_b = edge(rng, 1 << 14), edge(rng, 1 << rng.choice([12, 27, 30]))
    p.mode = rng.choice([ref.POS, ref.POS, ref.VEL, ref.TORQ]) | rng.randrange(0x80) << 4
    p.ilim, p.ilimax = rng.randrange(3000), rng.choice([0, 5])
    p.ipole = rng.choice([0, 900])
    return p


def working(rng: random.Random) -> ref.Params:
    """A loop as machines have them: small coefficients, roots near the unit circle."""
    b0 = rng.choice([1, 2, 64, 1024, 3, 100, -8, rng.randrange(1, 2000)])
    p = ref.Params(b0=b0, mode=rng.choice([ref.POS, ref.VEL, ref.TORQ, ref.TEST1]))
    p.a0, p.a1, p.a2 = (rng.choice([0, 0, 1, -1, rng.randint(-3000, 3000)]) for _ in range(3))
    near = rng.choice([-1, 1]) * rng.choice([0, 0, 1, 2])
    any_two = rng.randint(-abs(b0), abs(b0)), rng.randint(-abs(b0), abs(b0))
    roots = [(0, 0), (b0, 0), (-b0 + near, near), (-b0 + near, 0),
             (-2 * b0 + near, b0 - near), any_two]  # fmt: skip
    p.b1, p.b2 = rng.choice(roots)
    p.ic_pos, p.ic_neg = rng.randint(-100, 100), rng.randint(-100, 100)
    p.adc_a, p.adc_b = rng.randint(-3, 3), rng.randint(-6000, 6000)
    p.mode |= rng.randrange(0x80) << 4
    p.ilim = rng.choice([0, 1, 2, 3, rng.randrange(2300)])
    p.ilimax = rng.choice([0, 1, 2, 5])
    p.plo, p.phi = rng.randint(-300, 0), rng.randint(-20, 300)
    p.ipole = rng.choice([0, 1, 900, 1023])
    return p


def params(rng: random.Random) -> ref.Params:
    kind = rng.random()
    if kind < 0.5:
        return narrow(rng) if kind < 0.25 else working(rng)
    p = ref.Params(**{f.name: number(rng) for f in fields(ref.Params)})
    p.b0 = p.b0 or rng.choice([1, -1, 64])
    if rng.random() < 0.4:
        p.b1 = p.b2 = 0
    p.mode = rng.randrange(16) if rng.random() < 0.1 else rng.randrange(1, 5)
    p.mode |= rng.randrange(0x80) << 4
    p.ilim = rng.choice([p.ilim, rng.randrange(0, 3000)])
    p.ilimax = rng.choice([0, 0, 1, 2, 5, 50, p.ilimax])
    p.ipole = rng.choice([0, 1, 512, 1000, 1023, rng.randrange(1024)])
    return p


def inputs(rng: random.Random, counter: int) -> np.ndarray:
    """A counter that walks (through its wrap), an A/D value, a setpoint that jumps at times: to
    anywhere, or about where the axis is, or about 0."""
    calm = rng.random() < 0.4
    speed = rng.choice([0, 1, 20] if calm else [0, 1, 20, 1000, 32767])
    about, reach = rng.choice([0, 1]), rng.choice([1, 10, 300])

    def wanted() -> int:
        if not calm:
            return number(rng)
        return about * ((counter ^ 0x8000) - 0x8000) + rng.randint(-reach, reach)

    rows, setpoint = [], wanted()
    for _ in range(SAMPLES):
        counter = (counter + rng.randint(-speed, speed)) & 0xFFFF
        if rng.random() < 0.1:
            setpoint = wanted()
        rows.append((counter, rng.randrange(4096), setpoint))
    return np.array(rows, np.int32)


def compare(c: Axis, r: ref.Servo, rows: np.ndarray, what: str) -> None:
    got = c.run(np.ascontiguousarray(rows)).tolist()
    for i, row in enumerate(rows.tolist()):
        want = r.step(*row)
        assert got[i] == want, f"{what}: sample {i} of {dict(zip(COLUMNS, want, strict=True))}"


def lock_step(seed: int, total: int) -> int:
    rng = random.Random(seed)
    done = 0
    while done < total:
        counter, first = rng.randrange(65536), params(rng)
        c, r = Axis(first, counter), ref.Servo(first, counter)
        for change in range(3):
            compare(c, r, inputs(rng, r.counter), f"seed {seed}, {r.p}, change {change}")
            done += SAMPLES
            other = params(rng)
            if rng.random() < 0.5:
                other.mode = r.p.mode
            if not (other.mode ^ r.p.mode) & (0xF | ref.ADFB | ref.ZEROFB):
                other.ilim = r.p.ilim  # the triangle under way keeps its height
            c.change(other)
            r.change(other)
    return done


SEEDS = range(1, 11)


@pytest.mark.req("SRV-1", "SRV-2", "SRV-3", "SRV-4", "SRV-5", "SRV-6", "SRV-7", "DRV-10")
@pytest.mark.parametrize("seed", SEEDS)
def test_lock_step(seed):
    total = QUICK if "MMCS_RANDOM_OPS" in os.environ else TOTAL
    print(f"seed {seed}")
    assert lock_step(seed, total // len(SEEDS)) >= total // len(SEEDS)


NARROW_N = 1 << 28  # of servo.c: beyond this N = b0*u is kept in 64 bits
RECURSIONS = {  # by (b0, b1, b2): N grows, swings, or stays where it is
    "integrator": (1, -1, 0),
    "integrator, b0 = 64": (64, -64, 0),
    "two integrators": (8, -16, 8),
    "undamped": (5, -6, 5),
    "alternating": (16, 16, 0),
    "two alternating": (3, 6, 3),
}


def steer(rng: random.Random, r: ref.Servo, top: int) -> int:
    """An error that brings N to a bound or beside it, on beyond all 32 bits, or back home."""
    d = ref.Compensator(list(r.d.errors), list(r.d.products))
    d.output(r.p, 0)  # N without any error
    near = rng.choice([1, -1]) * NARROW_N + rng.choice([-2, -1, 0, 1])
    target = rng.choice([near, near, near, 0, 1 << 33, -(1 << 33), 0x7FFFFFFF, -0x7FFFFFFF])
    wanted = (target - d.products[0]) // r.p.a0
    if rng.random() < 0.3:
        top = 1 << 31  # this sample goes the wide way
    return max(-top, min(top - 1, wanted))


@pytest.mark.req("SRV-2", "SRV-7")
@pytest.mark.parametrize("a", [(1, 0, 0), (1000, 0, 0), (3, -3, 1), (1, 1999, -1900)])
@pytest.mark.parametrize("name", RECURSIONS)
def test_history_leaves_32_bits_and_comes_back(name, a):
    """N goes over the bound of the narrow way and comes back, many times: same bits throughout."""
    rng = random.Random(name + str(a))
    b0, b1, b2 = RECURSIONS[name]
    p = ref.Params(*a, b0, b1, b2, mode=ref.POS | ref.ZEROFB, ilim=2047, ilimax=5)
    top = (1 << 27) // sum(map(abs, a))  # errors with which the sum of a*e stays narrow
    crossings, exact = 0, set()
    for _ in range(40):
        c, r = Axis(p, 0), ref.Servo(p, 0)
        was_wide = 1
        for _ in range(60):
            compare(c, r, np.array([(0, 0, steer(rng, r, top))], np.int32), str(p))
            n, wide = r.d.products[0], c.lib.axis_wide(c.x)
            assert wide or -NARROW_N <= n < NARROW_N, "the history does not fit the narrow way"
            crossings += wide != was_wide
            was_wide = wide
            exact.add(n)
    assert crossings > 40
    if a == (1, 0, 0):
        assert {-NARROW_N - 1, -NARROW_N, NARROW_N - 1, NARROW_N} <= exact


def run_both(p: ref.Params, rows) -> np.ndarray:
    c, r = Axis(p, rows[0][0] & 0xFFFF), ref.Servo(p, rows[0][0] & 0xFFFF)
    rows = np.array(rows, np.int32)
    compare(c, r, rows, str(p))
    return Axis(p, int(rows[0][0]) & 0xFFFF).run(rows)


LARGEST = 2**31 - 1
OPEN = ref.POS | ref.ZEROFB  # error = setpoint
STEEP = {"a0": LARGEST, "a1": LARGEST, "a2": LARGEST, "mode": OPEN, "ilim": 2047}
FRICTION = {"mode": ref.TORQ | ref.COULCOMP, "ic_pos": 100, "ic_neg": 80}
OVER = {"mode": ref.TORQ, "ilim": 100, "ilimax": 5}
# S1 and S4 at the A/D, loop open: a filter from A/D to D/A (§2.2.4), here a mean of three.
MEAN = {"a0": 1, "a1": 1, "a2": 1, "b0": 3, "adc_b": -2048, "ilim": 2047,
        "mode": ref.POS | ref.ADFB | ref.ADDMD | ref.ZEROFB}  # fmt: skip
# What is known by hand: parameters, samples, a column and its last values.
KNOWN = {
    # 1/7 unit per sample for 700 samples is 100 units: truncated history would stay at 0
    "integrator": ("SRV-2", {"a0": 1, "b0": 7, "b1": -7, "mode": OPEN}, [(0, 0, 1)] * 700,
                   "current", [100]),
    "saturates-up": ("SRV-2", STEEP, [(0, 0, LARGEST)] * 5, "current", [2047] * 5),
    "saturates-down": ("SRV-2", STEEP, [(0, 0, -LARGEST - 1)] * 5, "current", [-2047] * 5),
    # 3/2 and -3/2, toward zero
    "velocity-up": ("SRV-1", {"mode": ref.VEL}, [(0, 0, 0), (1, 0, 0)], "vel", [1]),
    "velocity-down": ("SRV-1", {"mode": ref.VEL}, [(0, 0, 0), (65535, 0, 0)], "vel", [-1]),
    "wrap": ("DRV-10", {"mode": ref.POS}, [((32000 + 500 * i) & 0xFFFF, 0, 0) for i in range(300)],
             "position", [32000 + 500 * 299]),
    "friction-up": ("SRV-3", FRICTION, [(0, 0, 10)], "current", [110]),
    "friction-down": ("SRV-3", FRICTION, [(0, 0, -10)], "current", [-90]),
    "friction-at-0": ("SRV-3", FRICTION, [(0, 0, 0)], "current", [0]),
    "friction-reversed": ("SRV-3", FRICTION | {"ic_pos": -100, "ic_neg": -80}, [(0, 0, 10)],
                          "current", [90]),
    "overload": ("SRV-4", OVER, [(0, 0, 101)] * 6, "events", [0] * 5 + [ref.ILIM]),
    "overload-passes": ("SRV-4", OVER, [(0, 0, 101)] * 6, "current", [101] * 6),
    "silent-limit": ("SRV-4", OVER | {"ilimax": 0}, [(0, 0, 101)] * 6, "current", [100] * 6),
    "silence": ("SRV-4", OVER | {"ilimax": 0}, [(0, 0, 101)] * 6, "events", [0] * 6),
    "triangle": ("SRV-6", {"mode": ref.TEST1, "ilim": 3}, [(0, 0, 0)] * 14, "current",
                 [0, 1, 2, 3, 2, 1, 0, -1, -2, -3, -2, -1, 0, 1]),
    "filter": ("SRV-6", MEAN, [(0, r, 0) for r in (2048, 2051, 2054, 2057, 2057, 2057)],
               "current", [0, 1, 3, 6, 8, 9]),
}  # fmt: skip


@pytest.mark.parametrize("params, rows, column, values", [
    pytest.param(*row, id=name, marks=pytest.mark.req(req)) for name, (req, *row) in KNOWN.items()
])  # fmt: skip
def test_by_hand(params, rows, column, values):
    out = run_both(ref.Params(**params), rows)[:, COLUMNS.index(column)]
    assert out[-len(values) :].tolist() == values


@pytest.mark.req("SRV-5")
@pytest.mark.parametrize("ipole", [900, 1000, 1014, 1023])
def test_current_filter_has_unity_gain(ipole):
    p = ref.Params(mode=ref.TORQ, ilim=2047, ipole=ipole)
    for current in (2047, -2047, 100):
        out = run_both(p, [(0, 0, current)] * 20000)
        assert abs(int(out[-1, 6]) / 1024 - current) <= 1


# --- where chance seldom leads: small coefficients of both signs, limits that are exactly met ---

ERRORS = [(0, 0, e) for e in (5, -3, 1, 0, 2, -1, 7, 7)]


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


def corners():
    """Friction at rest and in motion, triangles of every small height, limits: by each side."""
    for pos, neg, u in product(range(-2, 3), repeat=3):
        p = ref.Params(mode=ref.TORQ | ref.COULCOMP, ic_pos=pos, ic_neg=neg)
        for step in (0, 1, 0xFFFF):
            yield p, [(0, 0, u), (step, 0, u), (step, 0, u)]
    for limit, ilimax in product(range(-1, 6), (0, 1)):
        yield ref.Params(mode=ref.TEST1, ilim=limit, ilimax=ilimax), [(0, 0, 0)] * 30
    for low, high in [(-3, 3), (0, 0), (2, -2), (-(2**31), LARGEST)]:
        p = ref.Params(mode=ref.POS | ref.POSCHK, plo=low, phi=high)
        yield p, [(c & 0xFFFF, 0, 0) for c in (0, 3, 4, 3, -3, -4, -5, -3, 5, -5, 0)]


@pytest.mark.req("SRV-3", "SRV-6", "DRV-10")
def test_corners():
    for p, rows in corners():
        run_both(p, rows)
