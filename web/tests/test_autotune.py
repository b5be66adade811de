# SPDX-License-Identifier: Apache-2.0
"""Auto-tune on LAB500 and on every joint of the PUMA, nobody helping: the table of the manual."""

import os

import numpy as np
import pytest
from bench import note

from mmcs.device.link import Samples
from mmcs.device.sockets import socket_path
from mmcs.tool.launch import _end, _serve
from mmcs.tool.tune import COMPENSATED, Probe, chirp, connect, tune

HALF = 2000  # counts to each side that are safe
INTERVAL_US = 1000
WANTED = 60.0  # rad/s
NEIGHBOURS = 9
LOOK_S = 0.002  # of the machine's time, as a page has it on a computer with time to spare
AXES = [("lab500", 0), *(("puma560", axis) for axis in range(6))]


class Stepped(Probe):
    """A probe for whom time passes look by look: a loaded computer is slow, not wrong."""

    period_ms = 0

    def _listen(self) -> None:
        t = self.link.request("advance", seconds=LOOK_S)["t"]
        while not self._rows or self.now < t - 1.5e-6 * INTERVAL_US:
            message = self.link.receive()
            if isinstance(message, Samples):
                self._take(message)


@pytest.fixture(scope="module")
def machines():
    """Machines by scenario, each started once."""
    running = {}

    def get(scenario: str):
        if scenario not in running:
            name = f"autotune-{os.getpid()}-{scenario}"
            socket = socket_path(name)
            running[scenario] = (_serve(scenario, name, socket), socket)
        return running[scenario][1].with_suffix(".msg")

    yield get
    for process, _ in running.values():
        _end(process)


def bandwidth(made) -> float:
    """Up to where the measured response has not fallen by 3 dB, rad/s; medians of nine
    neighbours, for friction makes single frequencies jump."""
    wide = np.pad(made.gain_db, NEIGHBOURS // 2, mode="edge")
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(wide, NEIGHBOURS), axis=1)
    below = np.flatnonzero(smooth < -3.0)
    end = int(below[0]) if len(below) else len(made.hz)
    return float(2 * np.pi * made.hz[max(end - 1, 0)])


@pytest.mark.req("TOOL-1")
@pytest.mark.parametrize("scenario,axis", AXES)
def test_the_wanted_bandwidth_is_met_within_the_safe_range(machines, scenario, axis):
    with connect(machines(scenario)) as link:
        link.request("lease", take=True)
        link.request("pace", paused=True)
        link.request("call", request="MSETINTERVAL", value=INTERVAL_US)
        link.request("call", request="MENABLE")
        probe = Stepped(link, axis)
        centre = probe.position
        made = tune(probe, WANTED, 1.0, HALF)
        met = bandwidth(chirp(probe, 30.0, 1.0, 20.0, 8.0))
        reach = max(abs(row[1] - centre) for row in probe._rows)
        probe.mode(0)
        link.request("stop")
        link.request("pace", paused=False)
    step, motor = made["step"], made["motor"]
    name = "lab500" if scenario == "lab500" else f"J{axis + 1}"
    note("autotune", name, (
        f"| {name} | {motor['g']:.0f} | {motor['tc_pos']:.0f} / {motor['tc_neg']:.0f} "
        f"| {made['break_away']:.0f} | {made['margins']['phase_deg']:.0f}° | {met:.0f} "
        f"| {step['rise_ms']:.0f} | {step['overshoot_pct']:.0f} % "
        f"| {step['steady_error_counts']:.0f} | {reach} |"
    ))  # fmt: skip
    assert reach <= HALF
    assert met >= WANTED
    assert made["margins"]["phase_deg"] > 35
    held = made["break_away"] - COMPENSATED * min(motor["tc_pos"], motor["tc_neg"])
    assert abs(step["steady_error_counts"]) <= held / abs(made["gains"]["p"]) + 1
