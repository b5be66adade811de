# SPDX-License-Identifier: Apache-2.0
"""Control synthesis, §2.5: from continuous gains to the integer compensator of the driver.

The controller is C(s) = P + I/s + D s/(tau s + 1), error in counts, output in D/A units (LSB):
P in LSB/count, I in LSB/(count s), D in LSB s/count, tau in s (0: no derivative filter). Discrete
transfer functions are coefficient lists in powers of q = z^-1.

D(z) and integers are made in sim/service, for the page as well; the loop with a motor is looked at
here. The libraries that convert controllers refuse or spoil the improper and integrating ones that
a servo needs, so they serve as test oracles only.
"""

import math
from dataclasses import dataclass

import numpy as np

from mmcs import service
from mmcs.service import DesignError


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


def discretize(c: Controller, method: str, t: float, prewarp: float = 0.0) -> Discrete:
    """D(z) for sample time t (s); prewarp is the frequency (rad/s) that must come out exactly."""
    made = service.design_discrete([c.p, c.i, c.d, c.tau], method, t, prewarp)
    return Discrete(tuple(made["num"]), tuple(made["den"]))


# --- integers ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Coefficients:
    """What MSETPARAM takes."""

    a: tuple[int, int, int]  # a0 a1 a2
    b: tuple[int, int, int]  # b0 b1 b2
    gain_error: float  # largest |D_int/D - 1| below half the Nyquist frequency
    warnings: tuple[str, ...]

    def named(self, sign: int = 1) -> dict[str, int]:
        """By the names of struct mc_param; sign: -1 for an axis that counts the other way."""
        law = {f"a{n}": sign * v for n, v in enumerate(self.a)}
        return law | {f"b{n}": v for n, v in enumerate(self.b)}

    def discrete(self) -> Discrete:
        b0 = self.b[0]
        return Discrete(tuple(v / b0 for v in self.a), tuple(v / b0 for v in self.b))


def to_integers(d: Discrete, scale: int | None = None) -> Coefficients:
    """Scales by S = b0. Keeps an integral an integral and its gain exact to rounding.

    scale None: the smallest power of two that keeps the gain error under 0.1 %, else the best one.
    """
    made = service.design_integers(list(d.num), list(d.den), scale)
    a, b, warnings = (tuple(made[key]) for key in ("a", "b", "warnings"))
    return Coefficients(a, b, made["gain_error"], warnings)


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


def _pad(values, size: int) -> np.ndarray:
    return np.pad(np.asarray(values, dtype=float), (0, size - len(values)))


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


def step_response(d: Discrete, plant: Plant, t: float, samples: int) -> np.ndarray:
    """Closed loop, linear, double-buffered, unit setpoint; counts at each sample."""
    g = plant.discrete(t)
    num = np.convolve(np.convolve(d.num, g.num), (0.0, 1.0))
    den = np.convolve(d.den, g.den)
    size = max(len(num), len(den))
    num = _pad(num, size)
    den = _pad(den, size) + num
    y = np.zeros(samples)
    for k in range(samples):
        past = sum(den[n] * y[k - n] for n in range(1, min(k + 1, size)))
        y[k] = (num[: k + 1].sum() - past) / den[0]
    return y


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
        k = to_integers(discretize(filtered, method, t, prewarp), scale)
        if abs(count_step(k.discrete(), filtered)) <= most:
            return filtered, k
    raise DesignError(f"--kick {most:g}: rounding moves it by more; take a larger --scale")
