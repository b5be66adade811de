# SPDX-License-Identifier: Apache-2.0
"""Control synthesis, §2.5: from continuous gains to the integer compensator of the driver.

The controller is C(s) = P + I/s + D s/(tau s + 1), error in counts, output in D/A units (LSB):
P in LSB/count, I in LSB/(count s), D in LSB s/count, tau in s (0: no derivative filter). Discrete
transfer functions are coefficient lists in powers of q = z^-1.

Only numpy: the libraries that convert controllers refuse or spoil the improper and integrating
ones that a servo needs, so the closed forms stand here and the libraries serve as test oracles.
"""

import math
from dataclasses import dataclass

import numpy as np

METHODS = ("backward", "bilinear", "prewarp", "matched", "ztransform", "zoh")
INT32_MAX = 2**31 - 1
SMALLEST_INTEGRAL = 20  # S*I*T below this rounds the integral away (or to something else)
GOOD_ROUNDING = 1e-3  # of the gain, up to half the Nyquist frequency


class DesignError(ValueError):
    """The combination cannot be made; the text says why and what to take instead."""


@dataclass(frozen=True)
class Controller:
    p: float
    i: float = 0.0
    d: float = 0.0
    tau: float = 0.0

    @property
    def form(self) -> str:
        name = "P" + ("I" if self.i else "") + ("D" if self.d else "")
        return name + ("f" if self.d and self.tau else "")

    def at(self, s: np.ndarray) -> np.ndarray:
        """C(s)."""
        return self.p + self.i / s + self.d * s / (self.tau * s + 1)


@dataclass(frozen=True)
class Discrete:
    """num(q)/den(q), den[0] = 1."""

    num: tuple[float, ...]
    den: tuple[float, ...]

    def at(self, z: np.ndarray) -> np.ndarray:
        q = 1 / z
        return np.polyval(self.num[::-1], q) / np.polyval(self.den[::-1], q)

    def poles(self) -> np.ndarray:
        return np.roots(self.den)


# --- continuous to discrete ------------------------------------------------------------------


def _add(a: Discrete, b: Discrete) -> Discrete:
    if a.den == b.den:
        size = max(len(a.num), len(b.num))
        return Discrete(tuple(_pad(a.num, size) + _pad(b.num, size)), a.den)
    num = np.convolve(a.num, b.den), np.convolve(b.num, a.den)
    size = max(map(len, num))
    return Discrete(
        tuple(_pad(num[0], size) + _pad(num[1], size)), tuple(np.convolve(a.den, b.den))
    )


def _pad(values, size: int) -> np.ndarray:
    return np.pad(np.asarray(values, dtype=float), (0, size - len(values)))


def _substitute(c: Controller, one: tuple[float, float], two: tuple[float, float]) -> Discrete:
    """C(s) with s = one(q)/two(q), term by term, so that an absent term leaves no factor behind."""
    n, m = np.array(one), np.array(two)
    terms = [Discrete((c.p,), (1.0,))]
    if c.i:
        terms.append(_monic(c.i * m, n))
    if c.d:
        terms.append(_monic(c.d * n, c.tau * n + m))
    total = terms[0]
    for term in terms[1:]:
        total = _add(total, term)
    return total


def _monic(num: np.ndarray, den: np.ndarray) -> Discrete:
    return Discrete(tuple(num / den[0]), tuple(np.trim_zeros(den / den[0], "b")))


def _matched(c: Controller, t: float) -> Discrete:
    """Zeros and poles to exp(sT); gain by the slowest term (DC, or the integral)."""
    p = math.exp(-t / c.tau) if c.d and c.tau else 0.0
    zeros = (
        [np.exp(r * t) for r in np.roots([c.p * c.tau + c.d, c.p + c.i * c.tau, c.i])]
        if c.i and c.d
        else []
    )
    if c.i and c.d:
        gain = c.i * t * (1 - p) / np.prod([1 - z for z in zeros]).real
        return Discrete(
            tuple(gain * np.poly(zeros).real),
            tuple(np.convolve((1, -1), (1, -p))) if p else (1.0, -1.0),
        )
    if c.i:
        if c.p == 0:
            return Discrete((c.i * t,), (1.0, -1.0))
        z0 = math.exp(-c.i * t / c.p)
        gain = c.i * t / (1 - z0)
        return Discrete((gain, -gain * z0), (1.0, -1.0))
    if c.d:
        if c.p == 0:
            raise DesignError("matched: a pure D has no gain at DC to match; take backward")
        z0 = math.exp(-c.p * t / (c.d + c.p * c.tau))
        gain = c.p * (1 - p) / (1 - z0)
        return Discrete((gain, -gain * z0), (1.0, -p) if p else (1.0,))
    return Discrete((c.p,), (1.0,))


@np.errstate(all="ignore")  # what is out of proportion becomes inf or nan: no integer is that
def discretize(c: Controller, method: str, t: float, prewarp: float = 0.0) -> Discrete:
    """D(z) for sample time t (s); prewarp is the frequency (rad/s) that must come out exactly."""
    if method not in METHODS:
        raise DesignError(f"no such method {method!r}; allowed: {', '.join(METHODS)}")
    if t <= 0:
        raise DesignError(f"the interval {t} s must be positive")
    if c.tau < 0:
        raise DesignError(f"tau = {c.tau}: a filter time constant is not negative")
    if method == "backward":
        return _substitute(c, (1 / t, -1 / t), (1.0, 0.0))
    if method == "bilinear":
        return _substitute(c, (2 / t, -2 / t), (1.0, 1.0))
    if method == "prewarp":
        if not 0 < prewarp * t < math.pi:
            raise DesignError(
                f"prewarp = {prewarp} rad/s: take one between 0 and {math.pi / t:.6g}"
            )
        k = prewarp / math.tan(prewarp * t / 2)
        return _substitute(c, (k, -k), (1.0, 1.0))
    if method == "matched":
        return _matched(c, t)
    if c.d and not c.tau:
        raise DesignError(
            f"{method}: {c.form} is improper (more zeros than poles), so the transform does not "
            "exist; give a derivative filter, or take backward or matched"
        )
    integral = Discrete((c.p,), (1.0,))
    if method == "ztransform":
        if c.d:
            raise DesignError(
                "ztransform: sampling the impulse response of a derivative filter gives a wrong DC "
                "gain (even its sign); take backward or matched"
            )
        return _add(integral, Discrete((c.i * t,), (1.0, -1.0))) if c.i else integral
    if c.i:
        integral = _add(integral, Discrete((0.0, c.i * t), (1.0, -1.0)))
    if c.d:
        k = c.d / c.tau
        integral = _add(integral, Discrete((k, -k), (1.0, -math.exp(-t / c.tau))))
    return integral


# --- integers ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Coefficients:
    """What MSETPARAM takes."""

    a: tuple[int, int, int]  # a0 a1 a2
    b: tuple[int, int, int]  # b0 b1 b2
    gain_error: float  # largest |D_int/D - 1| below half the Nyquist frequency
    warnings: tuple[str, ...]

    def discrete(self) -> Discrete:
        b0 = self.b[0]
        return Discrete(tuple(v / b0 for v in self.a), tuple(v / b0 for v in self.b))


def to_integers(d: Discrete, t: float, scale: int | None = None) -> Coefficients:
    """Scales by S = b0. Keeps an integral an integral and its gain exact to rounding.

    scale None: the smallest power of two that keeps the gain error under 0.1 %, else the best one.
    """
    if len(d.num) > 3 or len(d.den) > 3:
        raise DesignError("the compensator has order 2 at most")
    if scale is not None:
        if scale < 1 or scale > 2**30:
            raise DesignError(f"scale = {scale}: take 1 to {2**30}, best a power of two")
        return _scaled(d, t, scale)
    best = None
    for bits in range(31):
        try:
            found = _scaled(d, t, 1 << bits)
        except DesignError:
            if best is None and bits == 0:
                raise
            break
        if best is None or found.gain_error < best.gain_error:
            best = found
        if found.gain_error < GOOD_ROUNDING and not any("integral" in w for w in found.warnings):
            return found
    return best


def _scaled(d: Discrete, t: float, s: int) -> Coefficients:
    num, den = _pad(d.num, 3) * s, _pad(d.den, 3) * s
    a = [round(v) for v in num]
    b = [round(v) for v in den]
    warnings = []
    if abs(den.sum()) < 1e-9 * s:  # a pole at z = 1: it must stay there, with its gain
        b[1] = -b[0] - b[2]
        total = round(num.sum())
        a[1] = total - a[0] - a[2]
        if abs(num.sum()) < SMALLEST_INTEGRAL:
            warnings.append(
                f"S*I*T = {num.sum():.3g} rounds the integral to {total}; take a larger scale"
            )
    if max(map(abs, a + b)) > INT32_MAX:
        remedy = "a smaller scale" if s > 1 else "smaller gains"
        raise DesignError(f"scale = {s}: a coefficient exceeds 32 bits; take {remedy}")
    if sum(map(abs, a)) * 65535 > INT32_MAX:
        warnings.append(
            "a full-range error overflows 32-bit sums (a host of 1989); ours are 64-bit"
        )
    w = np.geomspace(1e-3, 0.5, 60) * math.pi / t
    z = np.exp(1j * w * t)
    made = Discrete(tuple(v / s for v in a), tuple(v / s for v in b))
    wanted = d.at(z)
    off = np.abs(made.at(z) - wanted)[wanted != 0] / np.abs(wanted[wanted != 0])
    error = float(off.max(initial=0.0))
    if error >= GOOD_ROUNDING:
        warnings.append(f"rounding changes the gain by up to {100 * error:.2g} %")
    for pole in d.poles():
        if pole.real < -0.9 and abs(pole.imag) < 1e-9:
            warnings.append(
                f"pole at z = {pole.real:.3g}: the loop rings with double-buffered D/As; "
                "take the backward difference"
            )
    return Coefficients(tuple(a), tuple(b), error, tuple(warnings))


# --- the loop with a motor ---------------------------------------------------------------------


@dataclass(frozen=True)
class Plant:
    """counts per LSB: G(s) = g / (s (s + lag)), g in counts/s^2 per LSB, lag = B/J in 1/s."""

    g: float
    lag: float = 0.0

    def discrete(self, t: float) -> Discrete:
        """Zero-order hold; exact."""
        if self.lag * t < 1e-9:
            k = self.g * t * t / 2
            return Discrete((0.0, k, k), (1.0, -2.0, 1.0))
        e = math.exp(-self.lag * t)
        k, x = self.g / self.lag**2, self.lag * t
        return Discrete((0.0, k * (x - 1 + e), k * (1 - e - x * e)), (1.0, -1 - e, e))


@dataclass(frozen=True)
class Margins:
    gain_db: float  # inf: never
    phase_deg: float
    crossover: float  # rad/s
    peak: float  # Ms, largest |sensitivity|
    poles: tuple[complex, ...]  # of the closed loop

    @property
    def stable(self) -> bool:
        return max(map(abs, self.poles)) < 1


def margins(d: Discrete, plant: Plant, t: float, delay: int = 1) -> Margins:
    """Loop with `delay` whole samples between reading and output (1: double-buffered D/A)."""
    g = plant.discrete(t)
    num = np.convolve(np.convolve(d.num, g.num), [0.0] * delay + [1.0])
    den = np.convolve(d.den, g.den)
    size = max(len(num), len(den))
    closed = _pad(num, size) + _pad(den, size)
    w = np.geomspace(1e-2, math.pi / t, 20000)
    loop = Discrete(tuple(num), tuple(den)).at(np.exp(1j * w * t))
    size_, angle = np.abs(loop), np.unwrap(np.angle(loop))
    angle -= 2 * math.pi * round((angle[0] + math.pi) / (2 * math.pi))
    cross = np.nonzero((size_[:-1] >= 1) & (size_[1:] < 1))[0]
    turn = np.nonzero((angle[:-1] >= -math.pi) & (angle[1:] < -math.pi))[0]
    return Margins(
        gain_db=float(-20 * np.log10(size_[turn].max())) if len(turn) else math.inf,
        phase_deg=float(np.degrees(angle[cross].min()) + 180) if len(cross) else math.inf,
        crossover=float(w[cross[-1]]) if len(cross) else 0.0,
        peak=float(np.max(1 / np.abs(1 + loop))),
        poles=tuple(complex(r) for r in np.roots(closed)),
    )


def place(
    plant: Plant, wn: float, zeta: float = 1.0, tau: float = 0.0, slow: float = 0.0
) -> Controller:
    """PD by pole placement: closed-loop natural frequency wn (rad/s) and damping zeta.

    With `slow` PID: the pole that the integral adds is there (rad/s), the other two stay. The
    derivative filter tau is not placed: it takes phase, which the margins show.
    """
    if wn <= 0 or zeta <= 0:
        raise DesignError("wn and zeta must be positive")
    d = (2 * zeta * wn + slow - plant.lag) / plant.g
    if d < 0:
        raise DesignError(f"friction alone damps more than zeta = {zeta:g}: raise --wn or --zeta")
    p = wn * (wn + 2 * zeta * slow) / plant.g
    return Controller(p, wn**2 * slow / plant.g, d, tau)


def count_step(d: Discrete, c: Controller) -> float:
    """By how much the derivative moves the output, D/A units, when the error moves by one count."""
    rest = c.p if c.i or not sum(d.den) else sum(d.num) / sum(d.den)
    return d.num[0] / d.den[0] - rest


def limit_step(c: Controller, most: float, method: str, t: float, prewarp: float) -> Controller:
    """The controller with the shortest derivative filter that keeps count_step within `most`."""
    if most <= 0:
        raise DesignError(f"--kick {most:g}: D/A units that one count may make, above 0")

    def made(tau: float) -> Controller:
        return Controller(c.p, c.i, c.d, tau)

    def fits(tau: float) -> bool:
        return abs(count_step(discretize(made(tau), method, t, prewarp), made(tau))) <= most

    if c.d == 0 or (method not in ("zoh", "ztransform") and fits(0.0)):
        return made(0.0)
    low, high = 0.0, t
    while not fits(high):
        low, high = high, 2 * high
        if high > 1e3 * t:
            raise DesignError(f"--kick {most:g}: not even a filter of {high:.3g} s makes that")
    while high - low > 1e-6 * t:
        middle = (low + high) / 2
        low, high = (low, middle) if fits(middle) else (middle, high)
    return made(high)


def limited_integers(
    c: Controller, most: float, method: str, t: float, prewarp: float, scale: int | None
) -> tuple[Controller, Coefficients]:
    """limit_step and to_integers, such that the integers too keep count_step within `most`.

    Rounding moves the step either way: the filter is made for a little less until it fits.
    """
    for share in (0.0, *(2.0**-n for n in range(10, 0, -1))):
        filtered = limit_step(c, most * (1 - share), method, t, prewarp)
        k = to_integers(discretize(filtered, method, t, prewarp), t, scale)
        if abs(count_step(k.discrete(), filtered)) <= most:
            return filtered, k
    raise DesignError(f"--kick {most:g}: rounding moves it by more; take a larger --scale")
