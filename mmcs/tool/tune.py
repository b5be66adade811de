# SPDX-License-Identifier: Apache-2.0
"""Experiments on one axis of a running machine, and gains from them: the auto-tune of mctool.

A client of the messages beside the page: the page lends it the lease. Between two samples of the
stream it sees nothing, so it asks for currents that the axis survives for that long.
"""

import select
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from mmcs import mcdef
from mmcs.device.link import Link, Samples
from mmcs.runs.metrics import step_response
from mmcs.scenario.identify import Frequency, Motor, frequency, identify
from mmcs.scenario.motor import COMPENSATED
from mmcs.scenario.synthesis import (
    Coefficients,
    Controller,
    discretize,
    margins,
    place,
    to_integers,
)
from mmcs.tool.judge import HELD_OFF, MORE_OVERSHOOT, judge, predict

ENCNOW, SETPOINT, CURRENT = 1, 7, 9  # within an axis's ten values of a row
ENABLED, STOPPED = 4, 8  # bits of a row's lines
PERIOD_MS = 2  # between messages of the stream
RAMP_LSB_S = 400.0  # of the search for the current that breaks the axis away
MOVED = 12  # counts that count as moving
PULSES = (1.6, 2.2, 3.0)  # currents of the relay, in break-away currents
RELAY_S = 4.0
REACH = 0.8  # of the range: how far the relay may let an axis run on
LEAST_MARGIN_DEG = 35.0
CHIRP_S = 0.002  # between setpoints of a chirp; what came of each is recorded with the samples
CORNER_HZ = 4.0
STEP_S = 0.4
INTEGRALS = (8.0, 24.0)  # so many times below the bandwidth is the pole of one that is tried
LONG_STEP_S = 1.2  # the integral takes its time
D_PER_COUNT = 150.0  # LSB that one count may cause through the derivative


class TuneError(Exception):
    """The experiment cannot go on; the text says why and what to do."""


@dataclass(frozen=True)
class Rows:
    t: np.ndarray
    y: np.ndarray
    w: np.ndarray  # setpoint
    u: np.ndarray  # current, LSB


class Probe:
    """One axis under experiment: commands, and every sample meanwhile.

    alive() is called often; it raises to end the experiment, whatever the axis does then."""

    period_ms = PERIOD_MS

    def __init__(self, link: Link, axis: int, alive=lambda: None):
        self.link, self.axis, self.alive = link, axis, alive
        self._rows: list[tuple[float, int, int, int]] = []
        self._setpoints = [0] * link.hello["axes"]
        self.joints = link.hello["axes"]
        self._lost = 0.0
        self._heard = time.monotonic()
        link.request("follow", events=False, period_ms=self.period_ms)
        self.wait(0.05)

    @property
    def position(self) -> int:
        return self._rows[-1][1]

    @property
    def setpoint(self) -> int:
        return self._rows[-1][2]

    @property
    def now(self) -> float:
        return self._rows[-1][0]

    def param(self) -> dict:
        return self.link.request("call", request="MGETPARAM", axis=self.axis)["param"]

    def change(self, **fields: int) -> None:
        self.link.request("change", axis=self.axis, param=fields)

    def mode(self, mode: int, flags: int = 0) -> None:
        self.change(mode=mode | flags)

    def write(self, value: float) -> None:
        self._setpoints[self.axis] = round(value)
        self.link.post("write", setpoints=self._setpoints[: self.joints])

    def wait(self, seconds: float, until=lambda: False) -> bool:
        """Lets so much time of the machine pass; True if until() came true before."""
        end = None
        while True:
            if self._rows:
                end = self.now + seconds if end is None else end
                if until():
                    return True
                if self.now >= end:
                    return False
            self._listen()

    def _listen(self) -> None:
        self.alive()
        if not select.select([self.link.fileno()], [], [], 0.05)[0]:
            if time.monotonic() - self._heard > 5.0:
                raise TuneError("the machine sends no samples; is it paused?")
            return
        message = self.link.receive()
        self._heard = time.monotonic()
        if isinstance(message, Samples):
            self._take(message)
        elif message.get("ok") is False:
            raise TuneError(message["text"])

    def _take(self, message: Samples) -> None:
        if message.lost > self._lost and self._rows:
            raise TuneError("samples were lost; is the computer too busy?")
        self._lost = message.lost
        for n in range(message.rows):
            row = message.row(n)
            values = row["axes"][self.axis]
            if not self._rows:
                self._setpoints = [axis[SETPOINT] for axis in row["axes"]]
                self.joints = row["joints"]
            self._rows.append((row["t"], values[ENCNOW], values[SETPOINT], values[CURRENT]))
            if row["lines"] & STOPPED or not row["lines"] & ENABLED:
                raise TuneError("the machine has been stopped, or is not enabled")

    def rows(self, since: float) -> Rows:
        """What came after a time."""
        table = np.array([row for row in self._rows if row[0] > since])
        return Rows(*table.T)


def break_away(probe: Probe, sign: int, most: int) -> tuple[float, int]:
    """The current, LSB, at which the axis starts to move that way, from rest in torque mode; and
    whether it counts with the current (1) or against it (-1)."""
    start, began = probe.position, probe.now
    while True:
        current = min(RAMP_LSB_S * (probe.now - began), most)
        probe.write(sign * current)
        if probe.wait(0.005, lambda: abs(probe.position - start) > MOVED):
            probe.write(0)
            return max(current, 1.0), 1 if sign * (probe.position - start) > 0 else -1
        if current >= most:
            probe.write(0)
            raise TuneError(
                f"{most} D/A units do not move the axis; is its brake on, its switch at disable, "
                "or ilim too low?"
            )


class Range:
    """The counts that are safe; to be asked at every look, wherever the axis is."""

    def __init__(self, probe: Probe, centre: int, half: float):
        self.probe, self.centre, self.half = probe, centre, half
        self.sense = 1  # -1: the axis counts against the current

    def check(self) -> None:
        if abs(self.probe.position - self.centre) > self.half:
            raise TuneError(
                f"the axis left its safe range, {self.centre - self.half:.0f} to "
                f"{self.centre + self.half:.0f}; allow a wider one"
            )

    def along(self, sign: int) -> int:
        """Counts from the centre, in the direction that a current of this sign drives to."""
        self.check()
        return sign * self.sense * (self.probe.position - self.centre)


def relay(probe: Probe, safe: Range, away: float, most: int) -> Rows:
    """Back and forth about the centre in torque mode with growing currents; what was recorded."""
    began, sign, turns = probe.now, 1, 0
    amplitudes = [min(share * away, most) for share in PULSES]
    while probe.now < began + RELAY_S or turns < 2 * len(PULSES):
        now, then = (amplitudes[n // 2 % len(PULSES)] for n in (turns, turns + 1))
        probe.write(sign * now)
        stroke(probe, safe, sign, max(1.0, now / then))
        sign, turns = -sign, turns + 1
        if turns > 400:
            break
    rows = probe.rows(began)
    brake(probe, safe, sign, now)
    return rows


def stroke(probe: Probe, safe: Range, sign: int, longer: float) -> None:
    """Waits until it is time to turn: friction helps to stop an axis, so it runs on no farther than
    it ran to get its speed, and so many times as far with a current so many times smaller."""
    lowest = [safe.along(sign)]

    def is_time() -> bool:
        at = safe.along(sign)
        lowest[0] = min(lowest[0], at)
        return at + longer * (at - lowest[0]) >= REACH * safe.half

    probe.wait(1.0, is_time)


def brake(probe: Probe, safe: Range, sign: int, current: float) -> None:
    """Brings the axis to rest: a current that way until it turns round, then none."""
    probe.write(sign * current)
    last = [probe.position]

    def turned() -> bool:
        safe.check()
        before, last[0] = last[0], probe.position
        return sign * safe.sense * (last[0] - before) > 0

    probe.wait(1.0, turned)
    probe.write(0)
    probe.wait(0.3, lambda: safe.check() or False)


def gains(
    motor: Motor, wn: float, zeta: float, t: float, slow: float = 0.0
) -> tuple[Controller, Coefficients]:
    """PD for a closed loop of wn rad/s, its derivative filtered so that a count stays quiet; with
    `slow` PID, whose integral adds a pole there and leaves the bandwidth."""
    placed = place(motor.plant, wn, zeta, slow=slow)
    tau = max(0.0, placed.d / D_PER_COUNT - t)  # backward difference: d / (tau + t) per count
    controller = replace(placed, tau=tau)
    made = to_integers(discretize(controller, "backward", t))
    return controller, made


def identify_axis(probe: Probe, half: float, most: int) -> tuple[Motor, float]:
    """The motor, and its break-away current; leaves the axis at rest in torque mode."""
    safe = Range(probe, probe.position, half)
    probe.write(0)
    probe.wait(0.05)  # the demand is 0 before the mode can act on it
    probe.mode(mcdef.MD_TORQ)
    probe.wait(0.1)
    away = 0.0
    for sign in (1, -1):
        current, safe.sense = break_away(probe, sign, most)
        away = max(away, current)
        probe.wait(0.3)  # it comes to rest
    rows = relay(probe, safe, away, most)
    return identify(rows.t, rows.y, rows.u), away


def tune(probe: Probe, wn: float, zeta: float, half: float, say=lambda text: None) -> dict:
    """Identifies, designs, sets the gains, and makes a step; everything as plain numbers."""
    param = probe.param()
    most = param["ilim"]
    t = probe.link.request("call", request="MGETINTERVAL")["value"] * 1e-6 * param["clkdivisor"]
    say("looking for the current that moves the axis, then back and forth")
    motor, away = identify_axis(probe, half, most)
    say(f"g {motor.g:.4g}, friction {motor.tc_pos:.0f}/{motor.tc_neg:.0f}: designing")
    controller, made = gains(motor, wn, zeta, t)
    margin = margins(made.discrete(), motor.plant, t)
    sign = 1 if motor.g > 0 else -1
    fields = made.named(sign) | {
        "ic_pos": sign * round(COMPENSATED * motor.tc_pos * sign),
        "ic_neg": sign * round(COMPENSATED * motor.tc_neg * sign),
    }
    fields["mode"] = mcdef.MD_POS | mcdef.COULCOMP
    probe.write(probe.position)
    probe.change(**fields)
    probe.wait(0.3)
    say("a step with the new gains")
    size = min(200.0, half / 4)
    step = make_step(probe, size)
    tried = ""
    if abs(step["steady_error_counts"]) > HELD_OFF:
        say(f"friction holds it {step['steady_error_counts']:.0f} counts off: an integral is tried")
        found, how = (controller, made, fields, step), ""
        for share in INTEGRALS:
            found, how = _with_integral(probe, found, gains(motor, wn, zeta, t, wn / share), sign)
            if abs(found[3]["steady_error_counts"]) <= HELD_OFF:
                break
        off = abs(step["steady_error_counts"])
        controller, made, fields, step = found
        now = abs(step["steady_error_counts"])
        tried = f"With an integral it {how}: none was taken."
        if controller.i:
            tried = f"An integral ends {now:.0f} counts off instead of {off:.0f}."
        margin = margins(made.discrete(), motor.plant, t)
    fresh = probe.param()
    predicted = predict(motor, fresh, t, step["size"], step["t"][-1], away)
    warnings = list(made.warnings)
    if not margin.stable:
        warnings.append("the loop is unstable with double-buffered D/As; take a lower bandwidth")
    elif margin.phase_deg < LEAST_MARGIN_DEG:
        warnings.append(
            f"phase margin {margin.phase_deg:.0f} degrees: too fast for {t * 1e6:.0f} us"
        )
    fine, verdict = judge(step, predicted)
    return {
        "motor": asdict(motor), "break_away": away, "param": fields, "before": param,
        "warnings": warnings, "gains": asdict(controller), "step": step, "predicted": predicted,
        "fine": fine, "verdict": f"{verdict} {tried}".strip(),
        "margins": {"phase_deg": margin.phase_deg, "gain_db": margin.gain_db,
                    "crossover": margin.crossover, "peak": margin.peak},
    }  # fmt: skip


def _with_integral(
    probe: Probe, held: tuple, placed: tuple[Controller, Coefficients], sign: int
) -> tuple[tuple, str]:
    """The gains with an integral, if that brings the axis nearer and does not swing; else as they
    were, and what was wrong with it."""
    pid, made = placed
    _, _, fields, step = held
    law = made.named(sign)
    probe.change(**law)
    probe.wait(0.3)
    better = make_step(probe, step["size"], LONG_STEP_S)
    off, now = (abs(s["steady_error_counts"]) for s in (step, better))
    if now < off and better["overshoot_pct"] <= step["overshoot_pct"] + MORE_OVERSHOOT:
        return (pid, made, fields | law, better), ""
    probe.change(**{name: fields[name] for name in law})
    probe.wait(0.3)
    return held, "swings" if now < off else "ends no nearer"


def make_step(probe: Probe, size: float, seconds: float = STEP_S) -> dict:
    """A step of the setpoint there and back: rise, overshoot, settling, steady error; t and y."""
    before, began = probe.setpoint, probe.now
    target = round(before + size)
    probe.write(target)
    if not probe.wait(10.0, lambda: probe.setpoint == target):
        raise TuneError("the setpoint does not arrive; another program may be writing")
    probe.wait(seconds)
    rows = probe.rows(began)
    probe.write(before)
    probe.wait(seconds)
    first = int(np.argmax(rows.w == target))
    at = rows.t[first]
    response = step_response(rows.t, rows.y, at, before, target)
    return asdict(response) | {
        "size": target - before,
        "t": (rows.t[first:] - at).tolist(),
        "y": (rows.y[first:] - before).tolist(),
    }


def chirp(probe: Probe, amplitude: float, low: float, high: float, seconds: float) -> Frequency:
    """Setpoint to position in closed loop, low to high Hz, about where the axis stands.

    Above CORNER_HZ the amplitude falls with the frequency, or the current would hit its limit."""
    centre, began = probe.position, probe.now
    rate = (high / low) ** (1 / seconds)
    while probe.now < began + seconds:
        s = probe.now - began
        turns = low * (rate**s - 1) / np.log(rate)
        share = min(1.0, CORNER_HZ / (low * rate**s))
        probe.write(centre + share * amplitude * np.sin(2 * np.pi * turns))
        probe.wait(CHIRP_S)
    probe.write(centre)
    probe.wait(0.2)
    rows = probe.rows(began)
    return frequency(rows.t, rows.w, rows.y, low, high)


def check_machine(link: Link) -> None:
    """Before the machine is touched. Raises ValueError."""


def connect(socket: Path) -> Link:
    """A client of its own with the device open for writing."""
    link = Link(path=socket)
    link.request("name", name="mctool tuner")
    link.request("open", mode="rw")
    return link
