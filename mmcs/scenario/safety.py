# SPDX-License-Identifier: Apache-2.0
"""The safe machine: what safety = "2026" stands for, docs/hardware/safety.md.

What the file has itself keeps its value; the rest comes from the robot file.
"""

import math

from mmcs.scenario.robot import Robot
from mmcs.scenario.scenario import Host, Scenario

GUARDS = {name for name in Host.model_fields if name.startswith("guard_")}
GUARD_US = 10_000  # that setpoints are good for; the half of it for the rest
HEARTBEAT_US = 10_000  # of the hardware's heartbeats
RUNAWAY = 4  # counts an interval: a count of doubt in each of two speeds, and as much again
WHOLE = {"hardware": "2026", "amp_panic_cut": "dynamic brake"}


def given(scenario: Scenario, key: str):
    """A key of the scenario that safety = "2026" stands for, too."""
    whole = scenario.safety == "2026" and key not in scenario.model_fields_set
    return WHOLE[key] if whole else getattr(scenario, key)


def cut(scenario: Scenario) -> int:
    """mmcs_config's amp_panic_cut."""
    ways = (False, True, "brakes first", "dynamic brake")
    return ways.index(given(scenario, "amp_panic_cut"))


def guard(scenario: Scenario, robot: Robot) -> dict:
    """The fields of mmcs_config of the driver's guard."""
    host = scenario.host
    found = host.model_dump(include=GUARDS)
    if scenario.safety == "2026":
        safe = _limits(scenario.interval_us, robot)
        found |= {key: safe[key] for key in found if key not in host.model_fields_set}
    if not found["guard_follow"]:
        found["guard_samples"] = 0
    found["guard_latched"] = given(scenario, "hardware") == "2026"
    return {key: int(value) for key, value in found.items()}


def _limits(us: int, robot: Robot) -> dict:
    braked = [m.brake_delay for m in robot.axis if m.brake_torque > 0]
    ticks = max(2, round(GUARD_US / us))
    return {
        "guard_jump": min(32767, math.ceil(robot.fastest() * us / 1.5e6)),
        "guard_follow": max((m.servo.follow for m in robot.axis), default=0),
        "guard_samples": ticks // 2,
        "guard_runaway": RUNAWAY,
        "guard_missed": ticks // 2,
        "guard_clock": True,
        "guard_lease": ticks,
        "guard_lock": True,
        "guard_readback": True,
        "guard_checked": True,
        "guard_brakes": math.ceil(1e6 * max(braked, default=0.0)) + (us if braked else 0),
    }
