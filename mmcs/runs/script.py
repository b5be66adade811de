# SPDX-License-Identifier: Apache-2.0
"""The script of a setup: its events, and the user's side while the motion goes on. sim/service
carries it out."""

import random

from mmcs import mcdef
from mmcs.engine.script import Script
from mmcs.errors import InputError, suggest
from mmcs.scenario.scenario import Call
from mmcs.scenario.setup import Setup

PROCESSES = ("pd", "bounce")  # as MMCS_PROCESS_... counts them


def make_script(sim, setup: Setup, calls: list[Call] | None = None) -> Script:
    """calls: in place of the scenario's."""
    scenario = setup.scenario
    script = sim.new_script(None if scenario.program else setup.driver(), setup.params)
    if scenario.event:
        _add_events(script, sim.input_names(), setup)
    for call in scenario.call if calls is None else calls:
        set_ = call.set.model_dump(exclude_none=True, exclude={"axis"}) if call.set else {}
        script.call(mcdef.sets(set_), at=call.at, request=getattr(mcdef, call.request),
                    axes=bits(_axes(call.axis, setup)), value=call.value)  # fmt: skip
    for n, process in enumerate(scenario.process):
        script.process(**process_fields(setup, n, process))
    return script


def _add_events(script: Script, names: list[str], setup: Setup) -> None:
    for place, event in enumerate(setup.scenario.event):
        if event.input not in names:
            hint = suggest(event.input, names) or "; `mmcs faults` lists them"
            key, allowed = f"event.{place}.input", f"this machine has no such input{hint}"
            raise InputError.one(setup.path, key, event.input, allowed)
        script.event(at=event.at, until=event.until, value=event.value, index=event.index,
                     input=names.index(event.input), at_power_on=event.at_power_on)  # fmt: skip


def process_fields(setup: Setup, number: int, process) -> dict:
    """Of mmcs_process, with goals of all axes, and lateness by seed."""
    axes, goals = _axes(process.axis, setup), [0.0] * setup.axes
    given = process.to if isinstance(process.to, list) else [process.to] * len(axes)
    for axis, goal in zip(axes, given, strict=True):
        goals[axis] = goal
    fields = {"kind": PROCESSES.index(process.kind), "axes": bits(axes), "at": process.at}
    if process.kind == "bounce":
        return fields | {"goals": goals, "late_us": []}
    late, turns = random.Random(f"{setup.scenario.seed}/{number}"), 0
    if process.jitter_us:
        turns = int(setup.scenario.duration * 1e6 / process.period_us) + 2
    return fields | {
        "p": process.p, "d": process.d, "period_us": process.period_us, "goals": goals,
        "late_us": [late.uniform(0.0, process.jitter_us) for _ in range(turns)],
    }  # fmt: skip


def _axes(axis, setup: Setup) -> list[int]:
    return list(range(setup.axes)) if axis == "all" else list(axis)


def bits(axes) -> int:
    return sum(1 << axis for axis in set(axes))


def summaries(script: Script, setup: Setup) -> list[dict]:
    """What the report says of each process."""
    found = []
    for process, told in zip(setup.scenario.process, script.told(), strict=True):
        acts, turns, shortest, longest = told
        if process.kind == "bounce":
            found.append({"kind": "bounce", "turns": turns})
            continue
        found.append({
            "kind": "pd",
            "wakes": acts,
            "shortest_period_us": round(shortest, 1) if acts > 1 else None,
            "longest_period_us": round(longest, 1) if acts > 1 else None,
        })  # fmt: skip
    return found
