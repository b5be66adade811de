# SPDX-License-Identifier: Apache-2.0
"""Motor and friction from a recording, and a measured frequency response (§2.5 needs both).

The motor, at the servo's own units: dv/dt = g (u - tc_pos [v > 0] + tc_neg [v < 0]) - lag v,
v in counts/s, u in D/A units (LSB). Gravity and a drive's offset are in tc_pos and, with the other
sign, in tc_neg.
"""

import math
from dataclasses import dataclass

import numpy as np

from mmcs.scenario.synthesis import Plant

SLOWEST_SHARE = 0.05  # of the greatest speed: below it friction is not the one of motion
LEAST_ROWS = 200
LEAST_FIT = 0.5  # of the accelerations' variance, explained
SURE = 0.9  # a coherence
SPAN = 4  # samples to each side over which speed and acceleration are taken


class IdentifyError(ValueError):
    """The recording does not tell; the text says why and what to do."""


@dataclass(frozen=True)
class Motor:
    g: float  # counts/s^2 per LSB; negative: the encoder counts against the current
    lag: float  # 1/s, viscous friction over inertia
    tc_pos: float  # LSB, Coulomb friction while the count rises
    tc_neg: float  # LSB, the same while it falls, positive
    fit: float  # share of the accelerations' variance explained, 1: all

    @property
    def plant(self) -> Plant:
        return Plant(abs(self.g), max(self.lag, 0.0))


def identify(t: np.ndarray, y: np.ndarray, u: np.ndarray) -> Motor:
    """From torque-mode rows: times s, counts, and the current in force from each row on, LSB.

    Least squares over local quadratics: where the motor moves one way and the current stands
    throughout the window, position is one parabola and its curvature the acceleration.
    """
    t, y, u = (np.asarray(x, dtype=float) for x in (t, y, u))
    if len(t) < LEAST_ROWS:
        raise IdentifyError(f"{len(t)} samples are too few; record at least {LEAST_ROWS}")
    dt = float(np.median(np.diff(t)))
    v, a, still = _motion(y, u, dt)
    fast = np.abs(v) > SLOWEST_SHARE * np.max(np.abs(v), initial=0.0)
    one_way = np.sign(v)
    take = still & fast & (np.abs(v) > 2.0 / (SPAN * dt))
    if take.sum() < LEAST_ROWS / 2:
        raise IdentifyError("the axis hardly moves; allow more current or a wider range")
    if len(set(one_way[take])) < 2:
        raise IdentifyError("the axis moves one way only; both are needed")
    up, down = (one_way[take] > 0).astype(float), (one_way[take] < 0).astype(float)
    columns = np.column_stack([u[take], -up, down, -v[take]])
    found, *_ = np.linalg.lstsq(columns, a[take], rcond=None)
    g, c_pos, c_neg, lag = map(float, found)
    left = a[take] - columns @ found
    fit = 1.0 - float(left.var() / a[take].var())
    if abs(g) < 1e-9 or fit < LEAST_FIT:
        raise IdentifyError(
            f"the motion does not follow the current (fit {fit:.2f}): is the axis blocked, its "
            "brake on, or its current at the limit?"
        )
    return Motor(g, lag, c_pos / g, c_neg / g, fit)


def _motion(y: np.ndarray, u: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed, acceleration, and where the current stood throughout the window that they are from."""
    n, k = len(y), np.arange(-SPAN, SPAN + 1) * dt
    fit = np.linalg.pinv(np.column_stack([np.ones_like(k), k, k**2]))
    v, a, still = np.zeros(n), np.zeros(n), np.zeros(n, dtype=bool)
    windows = np.lib.stride_tricks.sliding_window_view(y, len(k))
    v[SPAN : n - SPAN] = windows @ fit[1]
    a[SPAN : n - SPAN] = 2 * (windows @ fit[2])
    # the current of row m acts from m on: rows m-SPAN-1 to m+SPAN must have the same
    wide = np.lib.stride_tricks.sliding_window_view(u, len(k) + 1)
    still[SPAN + 1 : n - SPAN] = np.ptp(wide, axis=1) == 0
    return v, a, still


@dataclass(frozen=True)
class Frequency:
    """A measured frequency response: what is not sure is left out."""

    hz: np.ndarray
    gain_db: np.ndarray
    phase_deg: np.ndarray
    coherence: np.ndarray


def frequency(t: np.ndarray, w: np.ndarray, y: np.ndarray, low: float, high: float) -> Frequency:
    """y over w by averaged cross spectra S_wy/S_ww (Welch, Hann, half overlap), low to high in Hz.

    Only where the coherence is at least SURE: friction makes slow frequencies lie.
    """
    dt = float(np.median(np.diff(t)))
    n = min(len(t), 1 << int(math.log2(max(4.0, 4.0 / (low * dt)))))
    if n < 16 or len(t) < n:
        raise IdentifyError(f"the recording is too short for {low:g} Hz")
    window = np.hanning(n)
    starts = range(0, len(t) - n + 1, n // 2)
    spectra = [
        (np.fft.rfft((w[s : s + n] - w[s : s + n].mean()) * window),
         np.fft.rfft((y[s : s + n] - y[s : s + n].mean()) * window))
        for s in starts
    ]  # fmt: skip
    ww = sum(abs(fw) ** 2 for fw, _ in spectra)
    yy = sum(abs(fy) ** 2 for _, fy in spectra)
    wy = sum(fw.conj() * fy for fw, fy in spectra)
    hz = np.fft.rfftfreq(n, dt)
    with np.errstate(divide="ignore", invalid="ignore"):
        response, coherence = wy / ww, np.nan_to_num(abs(wy) ** 2 / (ww * yy))
    take = (hz >= low) & (hz <= high) & (coherence >= SURE) & (ww > 1e-6 * ww.max())
    if len(spectra) < 2:
        raise IdentifyError("one window only: a coherence needs at least two; record longer")
    picked = response[take]
    return Frequency(
        hz[take],
        20 * np.log10(abs(picked)),
        np.degrees(np.unwrap(np.angle(picked))),
        coherence[take],
    )
