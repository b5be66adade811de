# SPDX-License-Identifier: Apache-2.0
"""The picture of a design: Bode, step response, closed-loop poles."""

import math
from pathlib import Path

import numpy as np

from mmcs.scenario.synthesis import Coefficients, Controller, Discrete, Plant, margins
from mmcs.screen import pyplot


def step_response(d: Discrete, plant: Plant, t: float, samples: int) -> np.ndarray:
    """Closed loop, linear, double-buffered, unit setpoint; counts at each sample."""
    g = plant.discrete(t)
    num = np.convolve(np.convolve(d.num, g.num), (0.0, 1.0))
    den = np.convolve(d.den, g.den)
    size = max(len(num), len(den))
    num = np.pad(num, (0, size - len(num)))
    den = np.pad(den, (0, size - len(den))) + num
    y = np.zeros(samples)
    for k in range(samples):
        past = sum(den[n] * y[k - n] for n in range(1, min(k + 1, size)))
        y[k] = (num[: k + 1].sum() - past) / den[0]
    return y


def write_plot(path: Path, c: Controller, k: Coefficients, plant: Plant, t: float) -> None:
    plt = pyplot()
    d, g = k.discrete(), plant.discrete(t)
    m = margins(d, plant, t)
    w = np.geomspace(1.0, math.pi / t, 500)
    z = np.exp(1j * w * t)
    loop = d.at(z) * g.at(z) / z
    figure, axes = plt.subplots(2, 2, figsize=(9, 6.5), layout="constrained")
    gain, phase, step, poles = axes.flat
    gain.semilogx(w, 20 * np.log10(np.abs(loop)), label="loop")
    gain.semilogx(w, 20 * np.log10(np.abs(d.at(z) / c.at(1j * w))), "--", label="D(z)/C(s)")
    gain.axhline(0, color="0.7", lw=0.8)
    gain.set(title="gain, dB", xlabel="rad/s")
    gain.legend()
    phase.semilogx(w, np.degrees(np.unwrap(np.angle(loop))))
    phase.axhline(-180, color="0.7", lw=0.8)
    phase.set(title=f"phase, deg (margin {m.phase_deg:.0f})", xlabel="rad/s")
    samples = 200
    step.step(np.arange(samples) * t * 1e3, step_response(d, plant, t, samples), where="post")
    step.set(title="step, linear motor", xlabel="ms")
    angle = np.linspace(0, 2 * math.pi, 200)
    poles.plot(np.cos(angle), np.sin(angle), color="0.7", lw=0.8)
    poles.plot([p.real for p in m.poles], [p.imag for p in m.poles], "x")
    poles.set(title="closed-loop poles", aspect="equal")
    figure.savefig(path)
    plt.close(figure)
