# SPDX-License-Identifier: Apache-2.0
"""Bits that flip, lines that are held, writes that get lost or arrive wrong: what depends on them
follows, where no fault scenario shows it."""

import re

import pytest
from machines import event, machine, notes, start


@pytest.mark.req("INT-2")
def test_interrupts_of_a_wrong_vector_leave_time_to_others():
    """Without latency one follows the other."""
    with machine(latency_max_us=0) as sim:
        start(sim)
        sim.run(sim.time + 0.02)
        event(sim, 0.0, "seu_vector", 0x80)
        sim.run(sim.time + 0.0012)
        assert sim.stats()["spurious"] >= 3


@pytest.mark.req("API-1")
def test_an_assertion_that_an_upset_breaks_is_told_and_ends_nothing():
    """A one-shot that runs with no clock left: no trigger can bring it there."""
    with machine(kind="trust") as sim:
        event(sim, 0.0, "seu_heartbeat", 1, 0)
        assert sim.run(sim.time + 0.002)
        told = [n["text"] for n in notes(sim, "assert")]
        assert len(told) == 1 and re.match("after an upset: .*u_heartbeat.PulseHasClocks", told[0])


@pytest.mark.req("VME-1")
def test_each_line_is_the_one_it_is_called():
    with machine() as sim:
        sim.open(2)
        own = sim.bus_read(0x441)  # the vector
        event(sim, 0.0, "vme_d_stuck1", 1 << 4)
        sim.run(sim.time + 1e-5)
        assert sim.bus_read(0x441) == own | 1 << 4
        event(sim, 0.0, "vme_d_stuck1", 0)
        event(sim, 0.0, "pc_d_stuck0", 0xFF)  # of no concern to the adaptor's own registers
        sim.run(sim.time + 1e-5)
        assert sim.bus_read(0x441) == own
        event(sim, 0.0, "vme_control_stuck1", 1)  # AS*: nobody is addressed
        sim.run(sim.time + 1e-5)
        with pytest.raises(TimeoutError):
            sim.bus_read(0x441)
        event(sim, 0.0, "vme_control_stuck1", 0)
        event(sim, 0.0, "vme_am_stuck0", 63)
        sim.run(sim.time + 1e-5)
        with pytest.raises(TimeoutError):
            sim.bus_read(0x441)
        event(sim, 0.0, "vme_am_stuck0", 0)
        sim.run(sim.time + 1e-5)
        assert sim.bus_read(0x441) == own


@pytest.mark.req("DRV-4")
def test_writes_get_lost_or_arrive_wrong():
    ends = []
    for name, value in (("writes_lost", 0), ("writes_lost", 5), ("write_flip", 1 << 9)):
        with machine() as sim:
            client = start(sim)
            sim.add_segment(axis=0, kind="ramp", t0=0.0, duration=0.02, to=40)
            sim.start_motion(client)
            event(sim, 0.01, name, value)
            sim.run(sim.time + 0.05)
            assert not notes(sim, "error")
            ends.append(sim.log()[:, 1])  # the setpoint of axis 0
    whole, lost, flipped = ends
    assert whole[-1] == lost[-1] == 40 and (lost != whole).sum() == (lost < whole).sum() == 5
    assert (flipped != whole).sum() == 1 and abs(flipped - whole).max() == 512
