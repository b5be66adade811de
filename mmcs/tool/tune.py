# SPDX-License-Identifier: Apache-2.0
"""Experiments on one axis of a running machine, and gains from them: the auto-tune of mctool.

A client of the messages beside the page: the page lends it the lease. The machine is paused, and
goes on from look to look, so that a busy computer is slow, not late.
"""

import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from mmcs import mcdef
from mmcs.device.link import Link, Samples
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
from mmcs.tool.judge import Verdict, Wish, judge, predict, step_figures

ENCNOW, SETPOINT, CURRENT = 1, 7, 9  # within an axis's ten values of a row
ENABLED, STOPPED = 4, 8  # bits of a row's lines
LOOK_S = 0.002  # of the machine's time between two looks
RAMP_LSB_S = 400.0  # of the search for the current that breaks the axis away
MOVED = 12  # counts that count as moving
PULSES = (1.6, 2.2, 3.0)  # currents of the relay, in break-away currents
RELAY_S, MOST_TURNS = 4.0, 400
REACH = 0.8  # of the range: how far the relay may let an axis run on
STILL_S = 0.05  # an axis that counts nothing for so long is at rest
REST_S = 2.0  # the longest wait for it
BRAKE_ROWS = 50  # in which the greatest current is taken for the one that gave an axis its speed
CHIRP_S = 0.002  # between setpoints of a chirp; what came of each is recorded with the samples
CORNER_HZ = 4.0
STEP_S = 0.4
# What is tried: so many times the bandwidth, and so many times below it the pole of an integral (0:
# none). A stiffer loop holds against more friction, and settles sooner than an integral does.
TRIES = ((1.0, 0.0), (1.4, 0.0), (2.0, 0.0), (1.0, 8.0), (1.0, 24.0))
LONG_STEP_S = 1.2  # the integral takes its time
LEAST_MARGIN_DEG = 25.0  # of a loop that is tried, but for the one asked for
D_PER_COUNT = 150.0  # LSB that one count may cause through the derivative


class TuneError(Exception):
    """The experiment cannot go on; the text says why and what to do."""


class LeftRange(TuneError):
    """The axis is out of its safe range, and to be braked."""


@dataclass(frozen=True)
class Rows:
    t: np.ndarray
    y: np.ndarray
    w: np.ndarray  # setpoint
    u: np.ndarray  # current, LSB


class Range:
    """The counts that are safe about a centre, half of them to each side."""

    def __init__(self, centre: int, half: float):
        self.centre, self.half = centre, half
        self.sense = 1  # -1: the axis counts against the current

    def check(self, position: int) -> None:
        if abs(position - self.centre) > self.half:
            low, high = self.centre - self.half, self.centre + self.half
            raise LeftRange(
                f"the axis left its safe range, {low:.0f} to {high:.0f}, and was braked; "
                "allow a wider one"
            )


class Probe:
    """One axis under experiment: commands, and every sample meanwhile.

    alive() is called often; it raises to end the experiment, whatever the axis does then. With
    `safe` set, every look holds the position against it."""

    def __init__(self, link: Link, axis: int, alive=lambda: None, look_wall_s: float = LOOK_S):
        """look_wall_s: the least that a look may take, s; 0 hurries."""
        self.link, self.axis, self.alive, self.look_wall_s = link, axis, alive, look_wall_s
        self.safe: Range | None = None
        self.late_s = LOOK_S  # until what is written acts
        self._rows: list[tuple[float, int, int, int]] = []
        self._setpoints = [0] * link.hello["axes"]
        self.joints = link.hello["axes"]
        self._lost = 0.0
        self._pauses = False
        self._due = time.monotonic()
        self.interval_s = 0.0  # between samples, from begin() on

    def begin(self) -> None:
        """Pauses the machine, which release() ends, also after an error of this."""
        if not self.link.request("hello")["enabled"]:  # there may be no samples to tell it
            raise TuneError("the machine has been stopped, or is not enabled")
        self.interval_s = self.link.request("call", request="MGETINTERVAL")["value"] * 1e-6
        self._pauses = not self.link.hello["paused"]
        self.link.request("pace", paused=True)
        self.link.request("follow", events=False, period_ms=0)
        self.wait(0.05)

    def release(self) -> None:
        """Lets time run as before begin()."""
        if self._pauses:
            self.link.request("pace", paused=False)

    @property
    def position(self) -> int:
        return self._rows[-1][1]

    @property
    def setpoint(self) -> int:
        return self._rows[-1][2]

    def speed(self) -> float:
        """Counts/s, over the last two intervals."""
        (t, y, *_), (t2, y2, *_) = self._rows[-1], self._rows[max(-3, -len(self._rows))]
        return (y - y2) / (t - t2) if t > t2 else 0.0

    @property
    def now(self) -> float:
        return self._rows[-1][0]

    def param(self) -> dict:
        return self.link.request("call", request="MGETPARAM", axis=self.axis)["param"]

    def change(self, **fields: int) -> None:
        self.link.request("change", axis=self.axis, param=fields)

    def write(self, value: float) -> None:
        self._setpoints[self.axis] = round(value)
        self.link.post("write", setpoints=self._setpoints[: self.joints])

    def wait(self, seconds: float, until=lambda: False) -> bool:
        """Lets so much time of the machine pass; True if until() came true before."""
        end = None
        while True:
            if self._rows:
                end = self.now + seconds if end is None else end
                if (came := until()) or self.now >= end:
                    return came
            self._listen()

    def _listen(self) -> None:
        """A look: the machine goes on by LOOK_S, no faster than time itself."""
        self.alive()
        time.sleep(max(0.0, self._due - time.monotonic()))
        self._due = max(self._due, time.monotonic() - LOOK_S) + self.look_wall_s
        until = self.link.request("advance", seconds=LOOK_S)["t"]
        while not self._rows or self.now < until - 1.5 * self.interval_s:
            message = self.link.receive()
            if isinstance(message, Samples):
                self._take(message)
            elif message.get("ok") is False:
                raise TuneError(message["text"])
        if self.safe:
            self.safe.check(self.position)

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


def relay(probe: Probe, away: float, most: int) -> Rows:
    """Back and forth about the centre in torque mode with growing currents; what was recorded."""
    began, sign, turns = probe.now, 1, 0
    amplitudes = [min(share * away, most) for share in PULSES]
    while turns <= MOST_TURNS and (probe.now < began + RELAY_S or turns < 2 * len(PULSES)):
        now, then = (amplitudes[n // 2 % len(PULSES)] for n in (turns, turns + 1))
        probe.write(sign * now)
        stroke(probe, sign, now / then)
        sign, turns = -sign, turns + 1
    rows = probe.rows(began)
    halt(probe)
    return rows


def stroke(probe: Probe, sign: int, weaker: float) -> None:
    """Waits until it is time to turn: the axis may come to rest at REACH of the range.

    Friction helps to stop an axis, so with the same current it stops at least as fast as it got its
    speed, with one `weaker` times smaller so many times slower. Speed and run-up are measured; for
    one look and two samples, until the turn acts, it gains speed."""
    safe, late = probe.safe, probe.late_s
    way = sign * safe.sense
    lowest = [way * (probe.position - safe.centre)]

    def is_time() -> bool:
        at, v = way * (probe.position - safe.centre), way * probe.speed()
        lowest[0] = min(lowest[0], at)
        run = at - lowest[0]
        if v <= 0 or run <= 0:
            return False
        a = v * v / (2 * run)
        rest = at + v * late + a * late**2 / 2 + weaker * (v + a * late) ** 2 / (2 * a)
        return rest >= REACH * safe.half

    probe.wait(1.0, is_time)


def halt(probe: Probe) -> None:
    """Brings an axis in torque mode to rest: a current against its motion, of the size that it last
    had, until the axis would turn round before the next command acts; then none."""
    safe, probe.safe = probe.safe, None
    end, v = probe.now + REST_S, probe.speed()
    way, v = np.sign(v), abs(v)
    current = max(abs(u) for *_, u in probe._rows[-BRAKE_ROWS:])
    probe.write(-way * safe.sense * max(current, 1))
    while v > MOVED / STILL_S and probe.now < end:
        probe.wait(LOOK_S)
        before, v = v, way * probe.speed()
        if v <= (before - v) * probe.late_s / LOOK_S:
            break
    rest(probe)
    probe.safe = safe


def rest(probe: Probe) -> None:
    """Without current, until the axis counts nothing for STILL_S; REST_S at most."""
    probe.write(0)
    end = probe.now + REST_S
    while probe.now < end:
        at = probe.position
        if not probe.wait(STILL_S, lambda at=at: probe.position != at):
            return


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


def identify_axis(probe: Probe, most: int) -> tuple[Motor, float]:
    """The motor, and its break-away current; leaves the axis at rest in torque mode."""
    probe.write(0)
    probe.change(mode=mcdef.MD_TORQ)
    probe.wait(0.1)
    away = 0.0
    for sign in (1, -1):
        current, probe.safe.sense = break_away(probe, sign, most)
        away = max(away, current)
        rest(probe)
    rows = relay(probe, away, most)
    return identify(rows.t, rows.y, rows.u), away


def tune(probe: Probe, wn: float, zeta: float, half: float, say=lambda text: None) -> dict:
    """Identifies, designs, and makes a step with each set of gains until one does what is wished;
    where none does the axis gets its old parameters back. Everything as plain numbers."""
    before = probe.param()
    t = probe.interval_s * before["clkdivisor"]
    probe.late_s = LOOK_S + 2 * t
    probe.safe = Range(probe.position, half)
    try:
        say("looking for the current that moves the axis, then back and forth")
        motor, away = identify_axis(probe, before["ilim"])
        say(f"g {motor.g:.4g}, friction {motor.tc_pos:.0f}/{motor.tc_neg:.0f}: designing")
        wish = Wish(wn, zeta, t)
        made = _first_good(probe, motor, wish, min(200.0, half / 4), say)
    except LeftRange:
        probe.change(mode=mcdef.MD_TORQ)  # no sample passes before the current is a braking one
        halt(probe)
        raise
    finally:
        probe.safe = None
    controller, param, step, verdict = made
    if not verdict.met:
        probe.write(probe.position)
        probe.change(**{name: value for name, value in before.items() if name != "which"})
    predicted = predict(motor, before | param, t, step["size"], step["t"][-1], away)
    return {
        "motor": asdict(motor), "break_away": away, "param": param, "before": before,
        "gains": asdict(controller), "step": step, "predicted": predicted,
        "fine": verdict.met, "verdict": verdict.text,
        "margins": {"phase_deg": verdict.margins.phase_deg},
    }  # fmt: skip


def _first_good(probe: Probe, motor: Motor, wish: Wish, size: float, say) -> tuple:
    """(controller, parameters, step, verdict) of the first gains that do what is wished, else of
    the best of them: a PD, and where it ends off with integrals."""

    def rank(step: dict, verdict: Verdict) -> tuple:
        return len(verdict.unmet), abs(step["steady_error_counts"])

    best, sign = None, 1 if motor.g > 0 else -1
    fixed = {
        "ic_pos": round(COMPENSATED * motor.tc_pos),
        "ic_neg": round(COMPENSATED * motor.tc_neg),
        "mode": mcdef.MD_POS | mcdef.COULCOMP,
    }
    for faster, slower in TRIES:
        wn, slow = faster * wish.wn, wish.wn / slower if slower else 0.0
        controller, law = gains(motor, wn, wish.zeta, wish.t, slow)
        if best and margins(law.discrete(), motor.plant, wish.t).phase_deg < LEAST_MARGIN_DEG:
            continue
        param = law.named(sign) | fixed
        probe.write(probe.position)
        probe.change(**param)
        probe.wait(0.3)
        say(f"a step with {wn:.0f} rad/s{', and an integral' if slow else ''}")
        step = make_step(probe, size, LONG_STEP_S if slow else STEP_S)
        verdict = judge(step, wish, motor, probe.param())
        if best is None or rank(step, verdict) < rank(*best[2:]):
            best = controller, param, step, verdict
        if verdict.met or verdict.unmet == ("overshoot",):
            break
    return best


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
    figures = step_figures(rows.t[first:], rows.y[first:] - before, target - before)
    return figures | {"u": rows.u[first:].tolist()}


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


def connect(socket: Path) -> Link:
    """A client of its own with the device open for writing."""
    link = Link(path=socket)
    link.request("name", name="mctool tuner")
    link.request("open", mode="rw")
    return link
