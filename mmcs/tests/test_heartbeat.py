# SPDX-License-Identifier: Apache-2.0
"""heartbeat_us: the length of the one-shots that a host must keep alive, and a build of its own."""

import pytest

from mmcs.engine.build import library_path
from mmcs.runs.machine import build_of, machine
from mmcs.runs.session import Session
from mmcs.scenario.load import load


@pytest.mark.req("HB-1", "PAN-3")
@pytest.mark.parametrize("heartbeat_us", [50_000, 10_000])
def test_host_that_dies_is_panic_after_the_heartbeat(heartbeat_us):
    """amp_panic_cut: then no motor has a current."""
    setup = load("arm_move", (f"heartbeat_us={heartbeat_us}", "amp_panic_cut=true"))
    with machine(setup) as sim:
        session = Session(sim, setup)
        session.begin()
        sim.run(session.start + 0.15)
        died = sim.time
        sim.add_event(died, sim.input_names().index("host_dead"), 0, 1)
        sim.run(died + 0.2)
        told = next(n["t"] for n in sim.notes() if n["kind"] == "panic" and n["t"] > died)
        assert heartbeat_us - 2000 < 1e6 * (told - died) < heartbeat_us + 500
        assert all(sim.true(axis)["current"] == pytest.approx(0, abs=1e-6) for axis in range(6))


def test_each_heartbeat_is_a_build_with_an_identity_of_its_own():
    paths = {library_path(3, "speed", heartbeat_us=us) for us in (10_000, 20_000, 50_000)}
    assert len(paths) == 3 and library_path(3, "speed") in paths
    short, usual = load("lab500", ("heartbeat_us=10000",)), load("lab500")
    assert build_of(short).split()[0] == "c1_beat10000" and build_of(usual).split()[0] == "c1"


def test_an_interval_beyond_the_heartbeat_is_cautioned(mmcs):
    late = ("--set", "interval_us=20000", "--set", "heartbeat_us=10000")
    assert "above the heartbeat's 10000 us" in mmcs("check", "puma560", *late)[1]
