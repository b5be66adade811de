# SPDX-License-Identifier: Apache-2.0
"""The user's side while the motion goes on: requests at times, and processes that react.

Each actor says when it wants to act next (`due`, seconds since the start of motion) and is called
at that time. Everything goes through /dev/mc0, as a program's own requests would.
"""

from __future__ import annotations

import random

from mmcs import mcdef
from mmcs.errors import RunError

NEVER = float("inf")
SIGNAL_CHECK_S = 0.001  # how soon after a SIGUSR1 its handler runs, at most


def make_actors(session, client: int) -> list:
    scenario = session.setup.scenario
    actors: list = [Caller(session, client)] if scenario.call else []
    for n, process in enumerate(scenario.process):
        kind = {"pd": PdLoop, "bounce": Bouncer}[process.kind]
        actors.append(kind(session, client, process, n))
    return actors


class Caller:
    """Carries out the [[call]] entries; before MCALIB it reads the potentiometer."""

    def __init__(self, session, client: int):
        self.session, self.client = session, client
        self.calls = sorted(session.setup.scenario.call, key=lambda call: call.at)
        self.params = [dict(values) for values in session.setup.params]

    @property
    def due(self) -> float:
        return self.calls[0].at if self.calls else NEVER

    def act(self) -> None:
        call = self.calls.pop(0)
        setup, sim = self.session.setup, self.session.sim
        request = getattr(mcdef, call.request)
        if call.request in ("MCALIB", "MSETENC"):
            if call.request == "MCALIB":
                states = sim.read(self.client, setup.axes)
            axes = range(setup.axes) if call.axis == "all" else call.axis
            for axis in axes:
                if call.request == "MCALIB":
                    seen = (states[axis]["adcvai"], states[axis]["encnow"])
                    self.session.pots.setdefault(axis, seen)
                    argument = axis
                else:
                    argument = axis | (call.value & 0xFFFF) << 8
                self._ioctl(call.request, request, mcdef.new_int(argument))
        elif call.request == "MSETPARAM":
            given = call.set.model_dump(exclude_none=True, exclude={"axis"})
            for axis in range(setup.axes) if call.axis == "all" else call.axis:
                self.params[axis] |= given
                param = mcdef.new_param(axis)
                mcdef.fill_param(param, self.params[axis])
                self._ioctl(call.request, request, param)
        elif call.request in ("MDACMODE", "MSETINTERVAL"):
            self._ioctl(call.request, request, mcdef.new_int(call.value))
        else:
            if call.request == "MCLEARERROR":  # clears what a read has shown
                sim.read(self.client, setup.axes)
            self._ioctl(call.request, request, None)

    def _ioctl(self, name: str, request: int, argument) -> None:
        result = self.session.sim.ioctl(self.client, request, argument)
        if result < 0:
            self.session.refused.append((name, -result))


class _Process:
    def __init__(self, session, client: int, process, number: int):
        self.session, self.client, self.process = session, client, process
        axes, setup = process.axis, session.setup
        self.axes = list(range(setup.axes)) if axes == "all" else axes
        goals = process.to if isinstance(process.to, list) else [process.to] * len(self.axes)
        self.goals = dict(zip(self.axes, goals, strict=True))
        self.random = random.Random(f"{setup.scenario.seed}/{number}")

    def write(self, values: dict[int, int]) -> None:
        setpoints = self.session.setpoints
        for axis, value in values.items():
            setpoints[axis] = value
        if self.session.sim.write(self.client, setpoints) < 0:
            raise RunError("write of the setpoints by the scenario's process failed")


class PdLoop(_Process):
    """A position loop in a user's process: it is late by its jitter, and sees the last sample."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.turn, self.due, self.wakes = 0, 0.0, []

    def act(self) -> None:
        states = self.session.sim.read(self.client, max(self.axes) + 1)
        now = self.session.sim.time - self.session.start
        self.wakes.append(now)
        demand = {}
        for axis in self.axes:
            goal = self.goals[axis] if now >= self.process.at else 0.0
            state = states[axis]
            u = self.process.p * (goal - state["encnow"]) - self.process.d * state["vel"]
            demand[axis] = max(-2047, min(2047, round(u)))
        self.write(demand)
        self.turn += 1
        late = self.random.uniform(0.0, self.process.jitter_us)
        self.due = (self.turn * self.process.period_us + late) * 1e-6

    def summary(self) -> dict:
        periods = [(b - a) * 1e6 for a, b in zip(self.wakes, self.wakes[1:], strict=False)]
        return {
            "kind": "pd",
            "wakes": len(self.wakes),
            "shortest_period_us": round(min(periods), 1) if periods else None,
            "longest_period_us": round(max(periods), 1) if periods else None,
        }


class Bouncer(_Process):
    """On SIGUSR1: read the states, clear what they showed, turn the axes at a limit round."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.due, self.turns, self.going = self.process.at, 0, False

    def act(self) -> None:
        sim = self.session.sim
        self.due += SIGNAL_CHECK_S
        if not self.going:
            self.going = True
            self.write({axis: round(goal) for axis, goal in self.goals.items()})
            return
        if not sim.signals(self.client):
            return
        states = sim.read(self.client, self.session.setup.axes)
        sim.ioctl(self.client, mcdef.MCLEARERROR)
        back = {}
        for axis in self.axes:
            flags = states[axis]["errcode"] & 0xFF
            speed = abs(round(self.goals[axis]))
            if flags & mcdef.MERR_PHI and flags & mcdef.MERR_PLO == 0:
                back[axis] = -speed
            elif flags & mcdef.MERR_PLO and flags & mcdef.MERR_PHI == 0:
                back[axis] = speed
        if back:
            self.turns += 1
            self.write(back)

    def summary(self) -> dict:
        return {"kind": "bounce", "turns": self.turns}
