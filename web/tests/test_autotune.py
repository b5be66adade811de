# SPDX-License-Identifier: Apache-2.0
"""Auto-tune on LAB500 and on every joint of the PUMA, nobody helping: the table of the manual."""

import os
import re

import numpy as np
import pytest
from bench import note

from mmcs.device.sockets import socket_path
from mmcs.place import ROBOTS
from mmcs.tool.launch import _end, _serve
from mmcs.tool.tune import Probe, TuneError, chirp, connect, tune

HALF = 2000  # counts to each side that are safe
NEIGHBOURS = 9
US, WANTED = 1000, 60.0  # rad/s
# scenario, axis, interval, bandwidth, keys of another LAB500, what is not met
STICKY = {"stiction_pos": 0.01, "stiction_neg": 0.01}
ROUGH = {"coulomb_pos": 0.012, "coulomb_neg": 0.003, "stiction_pos": 0.03, "stiction_neg": 0.012}
RE25 = {"inertia": 1e-6, "rotor_inertia": 1e-6, "km": 0.0235, "coulomb_pos": 7e-4,
        "coulomb_neg": 7e-4, "stiction_pos": 1e-3, "stiction_neg": 1e-3}  # fmt: skip
CASES = {
    "lab500": ("lab500", 0, US, WANTED, {}, ""),
    **{f"J{n + 1}": ("puma560", n, US, WANTED, {}, "" if n else "counts off") for n in range(6)},
    "much friction": ("", 0, US, WANTED, ROUGH, "counts off"),
    "2.5 times static friction": ("", 0, US, WANTED, STICKY, ""),
    "tenfold inertia": ("", 0, US, WANTED, {"inertia": 8.3e-5}, "settles in"),
    "100 lines": ("", 0, US, WANTED, {"counts_per_rev": 400}, ""),
    "RE 25, 2000 µs": ("", 0, 2000, 50.0, RE25, "counts off"),
}


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    """The messages of a machine by the name of a case, each started once."""
    running = {}

    def get(name: str):
        scenario, _, _, _, keys, _ = CASES[name]
        if not scenario:
            folder = tmp_path_factory.mktemp("robot")
            robot, scenario = folder / "robot.toml", folder / "scenario.toml"
            text = (ROBOTS / "lab500.toml").read_text()
            for key, value in keys.items():
                text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text, count=1)
            robot.write_text(text)
            scenario.write_text(
                f'description = "a motor"\nrobot = "{robot}"\ncards = 1\nduration = 1.0\n'
            )
        if scenario not in running:
            socket = socket_path(f"autotune-{os.getpid()}-{len(running)}")
            running[scenario] = (_serve(str(scenario), socket.stem, socket), socket)
        return running[scenario][1].with_suffix(".msg")

    yield get
    for process, _ in running.values():
        _end(process)


def started(link, name: str) -> Probe:
    _, axis, interval_us, *_ = CASES[name]
    link.request("lease", take=True)
    link.request("call", request="MSETINTERVAL", value=interval_us)
    link.request("call", request="MENABLE")
    probe = Probe(link, axis, look_wall_s=0.0)
    probe.begin()
    return probe


def reach(probe: Probe, centre: int) -> int:
    return max(abs(row[1] - centre) for row in probe._rows)


def bandwidth(made) -> float:
    """Up to where the measured response has not fallen by 3 dB, rad/s; medians of nine
    neighbours, for friction makes single frequencies jump."""
    wide = np.pad(made.gain_db, NEIGHBOURS // 2, mode="edge")
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(wide, NEIGHBOURS), axis=1)
    below = np.flatnonzero(smooth < -3.0)
    end = int(below[0]) if len(below) else len(made.hz)
    return float(2 * np.pi * made.hz[max(end - 1, 0)])


@pytest.mark.req("TOOL-1")
@pytest.mark.parametrize("name", CASES)
def test_what_is_asked_is_met_or_refused_within_the_safe_range(machines, name):
    *_, wanted, _, unmet = CASES[name]
    with connect(machines(name)) as link:
        probe = started(link, name)
        centre, before = probe.position, probe.param()
        made = tune(probe, wanted, 1.0, HALF)
        met = bandwidth(chirp(probe, 30.0, 1.0, 20.0, 8.0)) if made["fine"] else None
        farthest, left = reach(probe, centre), probe.param()
        probe.change(mode=0)
        link.request("stop")
        probe.release()
    step, motor = made["step"], made["motor"]
    note("autotune", name, (
        f"| {name} | {motor['g']:.0f} | {motor['tc_pos']:.0f} / {motor['tc_neg']:.0f} "
        f"| {made['break_away']:.0f} | {made['margins']['phase_deg']:.0f}° "
        f"| {f'{met:.0f}' if met else 'refused'} "
        f"| {step['rise_ms']:.0f} | {step['overshoot_pct']:.0f} % "
        f"| {step['steady_error_counts']:.0f} | {farthest} |"
    ))  # fmt: skip
    assert farthest <= HALF
    assert unmet in made["verdict"] and made["fine"] == (not unmet), made["verdict"]
    if made["fine"]:
        assert met >= wanted
        assert left.items() >= made["param"].items()
    else:
        assert left == before


@pytest.mark.req("TOOL-1")
def test_an_axis_that_leaves_its_range_is_braked(machines):
    """Without current a motor of little friction would run on for many turns."""
    with connect(machines("RE 25, 2000 µs")) as link:
        probe = started(link, "RE 25, 2000 µs")
        centre, half = probe.position, 20  # less than one look of the ramp
        with pytest.raises(TuneError, match="left its safe range"):
            tune(probe, 50.0, 1.0, half)
        assert abs(probe.speed()) < 1000 and reach(probe, centre) < 20 * half
        link.request("stop")
        probe.release()


@pytest.mark.req("TOOL-1")
def test_an_experiment_that_cannot_begin_leaves_no_machine_paused(machines):
    with connect(machines("lab500")) as link:
        link.request("lease", take=True)
        probe = Probe(link, 0, look_wall_s=0.0)
        with pytest.raises(TuneError, match="is not enabled"):
            probe.begin()
        probe.release()
        assert not link.request("hello")["paused"]
