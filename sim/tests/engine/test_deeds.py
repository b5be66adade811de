# SPDX-License-Identifier: Apache-2.0
"""What is done to a machine is done to another from the same state: the same future, to the bit."""

import random

import pytest
from machines import event, machine, start

from mmcs import mcdef


@pytest.mark.req("API-1")
def test_deeds_lead_another_machine_the_same_way():
    """Requests, also refused ones, bus cycles, events, motions; with some left out it differs."""
    rng = random.Random(1989)
    with machine() as sim, machine() as other:
        client = start(sim)
        sim.run(sim.time + 0.002)
        lib, begun = sim.lib, sim.clock
        lib.mmcs_sim_keep_deeds(sim.handle)
        sim.snapshot()
        deeds = [
            lambda: sim.write(client, [rng.randrange(-500, 500), 7]),
            lambda: sim.read(client),
            lambda: sim.ioctl(client, mcdef.MSETENC, mcdef.new_int(rng.randrange(2))),
            lambda: sim.ioctl(client, mcdef.MSETINTERVAL, mcdef.new_int(3)),
            lambda: sim.ioctl(client, mcdef.MENABLE),
            lambda: lib.mmcs_sim_stop(sim.handle),
            lambda: sim.bus_read(0x001),
            lambda: sim.bus_write(0x041, rng.randrange(256)),
            lambda: event(sim, sim.time + 0.0005, "pot_noise", rng.random()),
            lambda: sim.close(sim.open(mcdef.O_RDONLY)),
        ]
        sim.add_segment(axis=1, kind="table", t0=0.0, duration=0.05, table=[0, 40, 10])
        sim.start_motion(client)
        clocks = []
        for deed in deeds + rng.choices(deeds, k=40):
            clocks.append(sim.clock)
            deed()
            sim.run(sim.time + rng.randrange(3) / 1000)
        assert lib.mmcs_sim_known(sim.handle) == begun
        assert lib.mmcs_sim_again(other.handle, sim.handle, begun - 1) == -1
        assert lib.mmcs_sim_again(other.handle, sim.handle, sim.clock) == 0
        assert other.future() == sim.future()
        assert lib.mmcs_sim_again(other.handle, sim.handle, clocks[0]) == 0
        assert lib.mmcs_sim_repeat(other.handle, sim.handle, clocks[12], sim.clock) == 0
        assert other.future() != sim.future()
        assert lib.mmcs_sim_copy(other.handle, sim.handle) == 0
        assert other.future() == sim.future()


@pytest.mark.req("API-1")
def test_an_interrupt_that_waits_at_the_end_of_a_deed_waits_for_another_too():
    """It rises within a bus cycle by hand, and no time passes until the next: served after it."""
    with machine() as sim, machine() as other:
        start(sim)
        sim.lib.mmcs_sim_keep_deeds(sim.handle)
        sim.snapshot()
        sampled, waited = sim.lib.mmcs_sim_samples(sim.handle), sim.clock
        while sim.clock < waited + 32_000:  # some servo periods
            sim.bus_read(0x001)
        sim.run(sim.time)  # no time passes
        assert sim.lib.mmcs_sim_samples(sim.handle) == sampled
        assert sim.lib.mmcs_sim_again(other.handle, sim.handle, sim.clock) == 0
        assert (other.clock, other.future()) == (sim.clock, sim.future())
        sim.run(sim.time + 0.001)
        assert sim.lib.mmcs_sim_samples(sim.handle) > sampled
