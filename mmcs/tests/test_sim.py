# SPDX-License-Identifier: Apache-2.0
"""The wrapper of the simulator library: what a Python program can do with the machine by hand."""

import pytest

from mmcs.runs.machine import build_of, machine
from mmcs.runs.session import Session
from mmcs.scenario.load import load

# --- heartbeat_us: how often a host must be alive, a build of its own ---


@pytest.mark.req("HB-1", "PAN-3")
@pytest.mark.parametrize("heartbeat_us", [
    50_000, pytest.param(10_000, marks=pytest.mark.slow)])  # fmt: skip  # a whole build
def test_host_that_dies_is_panic_after_the_heartbeat(heartbeat_us):
    """Nobody asks the bus, logs or signals then. amp_panic_cut: no motor has a current."""
    setup = load("arm_move", (f"heartbeat_us={heartbeat_us}", "amp_panic_cut=true"))
    assert build_of(setup).split()[0] == ("c3" if heartbeat_us == 50_000 else "c3_beat10000")
    with machine(setup) as sim:
        session = Session(sim, setup)
        session.begin()
        sim.run(session.start + 0.15)
        died = sim.time + 0.0003
        sim.add_event(died, sim.input_names().index("host_dead"), 0, 1)
        sim.run(died + 0.0001)
        said, cycles = len(sim.notes()), sim.stats()["bus_cycles"]
        sim.run(died + 0.2)
        (told,) = sim.notes()[said:]
        assert told["kind"] == "panic" and sim.stats()["bus_cycles"] == cycles
        assert heartbeat_us - 2000 < 1e6 * (told["t"] - died) < heartbeat_us + 500
        assert all(sim.true(axis)["current"] == pytest.approx(0, abs=1e-6) for axis in range(6))
