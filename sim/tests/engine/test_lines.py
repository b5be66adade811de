# SPDX-License-Identifier: Apache-2.0
"""Lines of the buses that are held, a host that dies, writes that get lost or arrive wrong."""

import pytest
from machines import event, machine, notes, start, step_to

HELD = [
    ("vme_a_stuck0", 1 << 9), ("vme_a_stuck1", 1 << 3), ("vme_am_stuck0", 1 << 5),
    ("vme_am_stuck1", 1 << 1), ("vme_d_stuck0", 1 << 4), ("vme_d_stuck1", 1 << 7),
    ("vme_control_stuck0", 1 << 0), ("vme_control_stuck0", 1 << 3), ("vme_control_stuck1", 1 << 2),
    ("vme_control_stuck1", 1 << 6), ("pc_a_stuck0", 1 << 2), ("pc_a_stuck1", 1 << 8),
    ("pc_d_stuck0", 1 << 0), ("pc_d_stuck1", 1 << 6), ("pc_control_stuck0", 1 << 0),
    ("pc_control_stuck1", 1 << 1),
]  # fmt: skip


def busy():
    return machine(axes=4, cards=3)


def disturbed(sim, name, value):
    """A line held for two passes in the middle of a motion; what became of it, also by a way back
    to a moment at which it is held."""
    client = start(sim)
    step_to(sim, client, 100, t0=0.002)
    event(sim, 0.0050512, name, value)
    event(sim, 0.0073567, name, 0)
    sim.run(sim.time + 0.006)
    id_, until, ends = sim.snapshot(), sim.time + 0.01, set()
    for _ in range(2):
        sim.restore(id_)
        sim.run(until)
        ends.add(sim.hash())
    return ends


@pytest.mark.slow
@pytest.mark.req("API-1")
def test_held_lines_matter_are_the_same_in_every_build_and_go_into_snapshots():
    seen = set()
    for name, value in HELD:
        hashes = set()
        for kind, skip in (("speed", 1), ("speed", 0), ("trust", 0)):
            with machine(kind=kind, skip=skip) as sim:
                hashes |= disturbed(sim, name, value)
        assert len(hashes) == 1, name
        seen |= hashes
    assert len(seen) > len(HELD) // 2, "most of them change the run"


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
