# SPDX-License-Identifier: Apache-2.0
"""Machines for the tests of the engine: a LAB500 motor on every axis, and a program's calls."""

import itertools
from contextlib import contextmanager

from mmcs import Sim, ensure_library, mcdef, setup_file
from mmcs.engine.sim import build_id, load_library

CLK_HZ = 8_000_000
# A small motor with a 500-line encoder; one D/A unit is 1.465 mA.
LAB500 = {
    "inertia": 8.3e-6, "viscous": 2e-6, "coulomb_pos": 4e-3, "coulomb_neg": 4e-3,
    "stiction_pos": 5e-3, "stiction_neg": 5e-3, "km": 25.9e-3, "resistance": 0.61,
    "v_supply": 24.0, "amp_gain": 0.3, "amp_max": 3.0, "amp_tau": 2e-4, "gear": 1.0,
    "pot_v_per_rad": 0.5, "counts_per_rev": 2000, "index_per_rev": 1,
}  # fmt: skip
PD = {"mode": "position", "flags": ["coulcomp"], "a0": 7309, "a1": -7027, "b0": 64,
      "ic_pos": 84, "ic_neg": 84, "ilim": 2047}  # fmt: skip


def made(library, config, motors, links=()) -> Sim:
    """A machine of fields of mmcs_config, mmcs_motor and mmcs_link."""
    setup = setup_file.write(build_id(load_library(library)), "test", clk_hz=CLK_HZ,
                             config=[config], motor=motors, link=links)  # fmt: skip
    return Sim(library, setup)


@contextmanager
def machine(axes=2, cards=1, motor=None, kind="speed", **config):
    settings = {
        "cards": cards, "axes": axes, "seed": 1, "skip": 1, "cpu_us_per_axis": 71.7,
        "latency_max_us": 100.0, "bus_timeout_us": 16.0, **config,
    }  # fmt: skip
    motors = [{**LAB500, **(motor or {})}] * axes
    with made(ensure_library(cards, kind), settings, motors) as sim:
        yield sim


def ioctl(sim, client, name, arg=None):
    result = sim.ioctl(client, getattr(mcdef, name), None if arg is None else arg)
    assert result == 0, f"{name}: {result}"


def start(sim, interval_us=1000, param=None):
    """Opens, configures and enables every axis; returns the client."""
    client = sim.open(mcdef.O_RDWR)
    assert client >= 0
    ioctl(sim, client, "MSETNUMJOINTS", mcdef.new_int(sim.axes))
    ioctl(sim, client, "MSETINTERVAL", mcdef.new_int(interval_us))
    ioctl(sim, client, "MDACMODE", mcdef.new_int(1))
    for axis in range(sim.axes):
        values = mcdef.new_param(axis)
        ioctl(sim, client, "MGETPARAM", values)
        mcdef.fill_param(values, {**PD, **(param or {})})
        ioctl(sim, client, "MSETPARAM", values)
    ioctl(sim, client, "MENABLE")
    sim.write(client, [0] * sim.axes)
    return client


def step_to(sim, client, counts, axis=0, t0=0.01):
    sim.add_segment(axis=axis, kind="step", t0=t0, duration=0.0, to=counts)
    sim.start_motion(client)


def input_number(sim, name):
    return sim.input_names().index(name)


def event(sim, after_s, name, value, index=0):
    sim.add_event(sim.time + after_s, input_number(sim, name), index, value)


def notes(sim, kind):
    return [note for note in sim.notes() if note["kind"] == kind]


def everything(sim):
    """All that happened; not what it took: what is at rest, or known, is found out anew."""
    took = ("evals", "cache_hits", "cache_misses", "cache_bytes")
    stats = {name: value for name, value in sim.stats().items() if name not in took}
    return sim.hash(), sim.log().tobytes(), sim.notes(), stats, sim.checkpoints()


def pairwise_diff(values):
    return [b - a for a, b in itertools.pairwise(values)]
