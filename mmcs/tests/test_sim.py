# SPDX-License-Identifier: Apache-2.0
"""The wrapper of the simulator library: what a Python program can do with the machine by hand."""

import pytest

from mmcs.engine import hosts
from mmcs.errors import RunError
from mmcs.runs.machine import build_of, machine
from mmcs.runs.session import Session
from mmcs.scenario.load import load


@pytest.fixture
def setup():
    return load("lab500")


@pytest.fixture
def sim(setup):
    with machine(setup) as made:
        yield made


def test_build_says_what_it_is(sim):
    assert sim.build() == {"cards": 1, "clk_hz": 8_000_000}
    assert (sim.time, sim.clock) == (0.0, 0)


def test_refusals_are_one_line(setup, sim, tmp_path):
    with pytest.raises(RunError, match="the trace file cannot be made"):
        sim.trace(tmp_path / "x.fst")  # the speed build has no tracing
    with pytest.raises(RunError, match="the engine refuses a motion of axis 7"):
        sim.add_segment(axis=7, kind="step", t0=0.0, to=1.0)
    with pytest.raises(RunError, match="there is no snapshot 9"):
        sim.drop(9)
    with pytest.raises(RunError, match="the simulator library does not load"):
        machine(setup, library=tmp_path / "none.so")


def test_a_host_whose_processor_is_not_installed(monkeypatch):
    monkeypatch.setattr(hosts.shutil, "which", lambda name: name)
    monkeypatch.setattr(hosts.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(RunError, match="--host m68020 needs .* core: make firmware"):
        hosts.config("m68020")


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


def test_an_interval_beyond_the_heartbeat_is_cautioned(mmcs):
    late = ("--set", "interval_us=20000", "--set", "heartbeat_us=10000")
    assert "above the heartbeat's 10000 us" in mmcs("check", "puma560", *late)[1]
