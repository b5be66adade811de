# SPDX-License-Identifier: Apache-2.0
"""Bits that flip, lines that are held, a host that dies, writes that get lost or arrive wrong: what
depends on them follows."""

import re

import pytest
from machines import event, ioctl, machine, notes, start, step_to

from mmcs import regs

PCCSR, VECTOR = regs.PCCSR, regs.VECTOR


@pytest.fixture
def sim():
    with machine() as one:
        yield one


def rest(sim):
    """An enabled machine that holds still; the client."""
    client = start(sim)
    sim.run(sim.time + 0.02)
    return client


@pytest.mark.req("DAC-1")
def test_output_latch_moves_the_motor_until_the_next_update(sim):
    rest(sim)
    event(sim, 0.0, "seu_dac_output", 1 << 11, 0)
    sim.run(sim.time + 3e-4)
    assert abs(sim.true(0)["current"]) > 0.5
    assert abs(sim.true(1)["current"]) < 0.3
    sim.run(sim.time + 0.005)
    assert abs(sim.true(0)["current"]) < 0.5


@pytest.mark.req("CSR-1")
def test_registers_of_the_adaptor(sim):
    sim.bus_write(PCCSR, 0x18)
    event(sim, 0.0, "seu_pccsr", 0x01)
    sim.run(sim.time + 1e-6)
    assert sim.bus_read(PCCSR) & 0x1F == 0x19


@pytest.mark.req("INT-2")
def test_wrong_vector_is_spurious_until_the_driver_is_asked_why_it_is_quiet():
    with machine() as sim:
        client = rest(sim)
        event(sim, 0.0, "seu_vector", 0x80)
        sim.run(sim.time + 0.005)
        assert sim.stats()["spurious"] >= 3
        sim.run(sim.time + 0.1)
        assert "mc: PANIC: no interrupts" in [n["text"] for n in notes(sim, "log")]
        samples, spurious = sim.samples, sim.stats()["spurious"]
        sim.run(sim.time + 0.05)
        assert sim.samples - samples > 40 and sim.stats()["spurious"] == spurious
        ioctl(sim, client, "MENABLE")


@pytest.mark.req("INT-2")
def test_interrupts_of_a_wrong_vector_leave_time_to_others():
    """Without latency one follows the other."""
    with machine(latency_max_us=0) as sim:
        rest(sim)
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


# --- lines, host ---------------------------------------------------------------------------------


def busy():
    return machine(axes=4, cards=3)


@pytest.mark.req("VME-1")
def test_each_line_is_the_one_it_is_called():
    with busy() as sim:
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


@pytest.mark.req("HB-1")
def test_dead_host_does_nothing_and_the_heartbeats_tell():
    with busy() as sim:
        client = start(sim)
        step_to(sim, client, 400)
        sim.run(sim.time + 0.02)
        event(sim, 0.0003, "host_dead", 1)  # in the middle of a pass
        sim.run(sim.time + 0.0004)
        said, cycles, began = len(sim.notes()), sim.stats()["bus_cycles"], sim.time
        sim.run(sim.time + 0.1)
        assert sim.stats()["bus_cycles"] == cycles
        fresh = sim.notes()[said:]
        assert [n["kind"] for n in fresh] == ["panic"]  # nobody is there to log or signal
        assert 0.04 < fresh[0]["t"] - began < 0.0505
        assert sim.ioctl(client, 0) == 0


@pytest.mark.req("DRV-4")
def test_writes_get_lost_or_arrive_wrong():
    def end(*events):
        with busy() as sim:
            client = start(sim)
            sim.add_segment(axis=0, kind="ramp", t0=0.0, duration=0.02, to=40)
            sim.start_motion(client)
            for name, value in events:
                event(sim, 0.01, name, value)
            sim.run(sim.time + 0.05)
            assert not notes(sim, "error")
            return sim.log()[:, 1]  # the setpoint of axis 0

    whole = end()
    assert whole[-1] == 40
    lost = end(("writes_lost", 1000))
    assert lost[-1] < 25 and (lost == lost[-1]).sum() > 30
    flipped = end(("write_flip", 1 << 9))
    wrong = flipped != whole
    assert wrong.sum() == 1 and abs(flipped - whole).max() == 512
