# SPDX-License-Identifier: Apache-2.0
"""What was asked of an axis, and whether its step does it; if not, what would help."""

from dataclasses import asdict, dataclass

import numpy as np

from mmcs.runs.metrics import Response, step_response
from mmcs.scenario.identify import Motor
from mmcs.scenario.predict import step as predicted_step
from mmcs.scenario.synthesis import Discrete, Margins, margins

HELD_OFF = 2.0  # counts, or so much of the step: as settling has it (mmcs/runs/metrics.py)
HELD_SHARE = 0.02
NEAR, NEAR_MS = 1.4, 10.0  # a rise or a settling may take so much longer than asked
MORE_OVERSHOOT = 5.0  # per cent of the step, beyond what the damping gives
AT_LIMIT = 0.25  # of the rise
LEAST_MARGIN_DEG = 40.0
COARSE = 100.0  # D/A units for one count


@dataclass(frozen=True)
class Wish:
    wn: float  # rad/s
    zeta: float
    t: float  # s between servo samples of the axis

    def figures(self, size: float = 1000.0) -> dict:
        """The step of two poles of this bandwidth and damping."""
        root = np.sqrt(complex((self.zeta * 1.0001) ** 2 - 1))
        one, two = self.wn * (-self.zeta + root), self.wn * (-self.zeta - root)
        t = np.linspace(0, 12 / abs(one.real), 4000)
        y = 1 - ((two * np.exp(one * t) - one * np.exp(two * t)) / (two - one)).real
        return asdict(step_response(t, size * y, 0.0, 0.0, size))


@dataclass(frozen=True)
class Verdict:
    unmet: tuple[str, ...]  # of rise, overshoot, settling, error
    text: str
    margins: Margins

    @property
    def met(self) -> bool:
        return not self.unmet


def predict(motor: Motor, param: dict, t: float, size: float, seconds: float, away: float) -> dict:
    """The step that the motor's numbers promise, with limit and friction."""
    rows = max(2, int(min(seconds, 4.0) / t))
    y = predicted_step(motor, param, t, round(size), rows, away)
    return step_figures(np.arange(rows) * t, y, round(size))


def step_figures(t: np.ndarray, y: np.ndarray, size: float) -> dict:
    """Of a step from 0 at t[0]: times s, counts, and the figures of Response."""
    at = t - t[0]
    figures = asdict(step_response(at, y, 0.0, 0.0, size))
    return figures | {"size": size, "t": at.tolist(), "y": y.tolist()}


def judge(step: dict, wish: Wish, motor: Motor, param: dict) -> Verdict:
    """Whether a step (step_figures, and u: its currents, D/A units) with these parameters does what
    was asked, in a sentence, and one on what would help."""
    asked, size = Response(**wish.figures()), abs(step["size"])
    unmet = {}
    rise, over, settle, off = (step[k] for k in asdict(asked))
    if rise is None:
        unmet["rise"] = "the step does not arrive"
    elif rise > NEAR * asked.rise_ms + NEAR_MS:
        unmet["rise"] = f"it rises in {rise:.0f} ms instead of {asked.rise_ms:.0f}"
    if over > asked.overshoot_pct + MORE_OVERSHOOT:
        unmet["overshoot"] = f"it overshoots by {over:.0f} % instead of {asked.overshoot_pct:.0f}"
    if abs(off) > max(HELD_OFF, HELD_SHARE * size):
        unmet["error"] = f"it ends {abs(off):.0f} counts off"
    elif settle is None or settle > NEAR * asked.settle_ms + NEAR_MS:
        took = "never settles" if settle is None else f"settles in {settle:.0f} ms"
        unmet["settling"] = f"it {took} instead of {asked.settle_ms:.0f}"
    law = (param[f"a{n}"] * np.sign(motor.g) / param["b0"] for n in range(3))
    den = (param[f"b{n}"] / param["b0"] for n in range(3))
    margin = margins(Discrete(tuple(law), tuple(den)), motor.plant, wish.t)
    if not unmet:
        text = f"As asked: rise {rise:.0f} ms, overshoot {over:.0f} %, settled in {settle:.0f} ms."
        return Verdict((), text, margin)
    advice = _advice(unmet, step, wish, margin, param)
    return Verdict(tuple(unmet), f"Not as asked: {', '.join(unmet.values())}. {advice}", margin)


def _advice(unmet: dict, step: dict, wish: Wish, margin: Margins, param: dict) -> str:
    """The first thing that would help, as a sentence."""
    y, u = np.array(step["y"]), np.array(step["u"])
    rising = u[: int(np.argmax(y * np.sign(step["size"]) >= 0.9 * abs(step["size"]))) or len(u)]
    if "rise" in unmet and np.mean(np.abs(rising) >= 0.98 * param["ilim"]) > AT_LIMIT:
        return f"The current is at ilim {param['ilim']}: raise it, or ask a lower bandwidth."
    if unmet.keys() & {"overshoot", "settling"} and margin.phase_deg < LEAST_MARGIN_DEG:
        return (f"The phase margin is {margin.phase_deg:.0f} degrees: sample more often than every "
                f"{1e6 * wish.t:.0f} us, or ask a lower bandwidth.")  # fmt: skip
    count = abs(param["a0"] / param["b0"])
    if count > COARSE and param["b1"] and "error" not in unmet:
        return (f"The encoder is too coarse: one count moves the current by {count:.0f} D/A units, "
                "though the derivative is filtered.")  # fmt: skip
    if "error" in unmet:
        return ("Friction holds it. A stiffer loop ends nearer; that takes a shorter interval or a "
                "finer encoder.")  # fmt: skip
    return "Ask a lower bandwidth, or more damping."
