# SPDX-License-Identifier: Apache-2.0
"""The user's side while the motion goes on: requests at times, and processes that react.

Each actor says when it wants to act next (`due`, seconds since the start of motion) and is called
at that time. Everything goes through /dev/mc0, as a program's own requests would.
"""

from __future__ import annotations

import os
import random

from mmcs import mcdef
from mmcs.errors import RunError

NEVER = float("inf")
SIGNAL_CHECK_S = 0.001  # how soon after a SIGUSR1 its handler runs, at most


def bits(axes) -> int:
    return sum(1 << axis for axis in set(axes))


def make_actors(session, client: int) -> list:
    scenario = session.setup.scenario
    actors: list = [Caller(session, client)] if scenario.call else []
    for n, process in enumerate(scenario.process):
        kind = {"pd": PdLoop, "bounce": Bouncer}[process.kind]
        actors.append(kind(session, client, process, n))
    return actors


class Caller:
    """Carries out the [[call]] entries."""

    def __init__(self, session, client: int):
        self.session, self.client = session, client
        self.calls = sorted(session.setup.scenario.call, key=lambda call: call.at)
        self.params = mcdef.new_params(session.setup.params)

    @property
    def due(self) -> float:
        return self.calls[0].at if self.calls else NEVER

    def act(self) -> None:
        call, session = self.calls.pop(0), self.session
        axes = range(session.setup.axes) if call.axis == "all" else call.axis
        set_ = call.set.model_dump(exclude_none=True, exclude={"axis"}) if call.set else {}
        fields = {"request": getattr(mcdef, call.request), "axes": bits(axes), "value": call.value}
        results, states = session.sim.call(self.client, self.params, fields, mcdef.sets(set_))
        session.refused += [(call.request, -result) for result in results if result < 0]
        for axis in axes if call.request == "MCALIB" else ():
            session.pots.setdefault(axis, (states[axis]["adcvai"], states[axis]["encnow"]))


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
        goals = [round(self.goals.get(axis, 0)) for axis in range(self.session.setup.axes)]
        result = sim.bounce(self.client, bits(self.axes), goals, self.session.setpoints)
        if result < 0:
            raise RunError(f"the scenario's process: {os.strerror(-result)}")
        self.turns += result

    def summary(self) -> dict:
        return {"kind": "bounce", "turns": self.turns}
