# SPDX-License-Identifier: Apache-2.0
"""The tap of the engine: it tells everything and disturbs nothing."""

import struct

import pytest
from machines import event, everything, machine, start, step_to

from mmcs import mcdef

RUN_S = 0.25


def run(sim, looks=0):
    """A step, a PANIC by the button, an enable: what a reader may want to see."""
    client = start(sim)
    step_to(sim, client, 200)
    event(sim, 0.15, "estop", 1)
    event(sim, 0.16, "estop", 0)
    for n in range(1, max(looks, 1) + 1):
        assert sim.run(0.05 + RUN_S * n / max(looks, 1))
        if looks:
            sim.tap_rows(0, n % 3, 100)  # every sample, every second, and 0, which is refused
            sim.tap_events(0, 100)
    assert sim.ioctl(client, mcdef.MENABLE) == 0
    return everything(sim)


@pytest.mark.req("FW-2")
def test_with_and_without_the_tap_a_run_is_the_same():
    with machine() as sim:
        without = run(sim)
    with machine() as sim:
        sim.tap(64, 64)
        assert run(sim, looks=50) == without


def test_rows_hold_what_the_log_holds():
    with machine() as sim:
        sim.tap(1000, 1000)
        run(sim)
        rows, _, size = sim.tap_head()
        data, count, after, lost = sim.tap_rows(0, 1, 1000)
        assert (count, after, lost) == (rows, rows, 0)
        layout = struct.Struct("<ddii20ii4x")
        assert layout.size == size
        table = list(layout.iter_unpack(data))
        log = sim.log()
        # IRQ, stopped, enabled, brakes released, PANIC: IRQ only in the pass that the button meets
        assert {row[2] for row in table} == {0b00001, 0b00010, 0b00110, 0b10101}
        began = table[-1][1] - log[-1][0]
        kept = [row for row in table if row[1] >= began - 1e-9]
        assert len(kept) >= len(log) > 100
        for row, logged in zip(kept[-len(log) :], log, strict=True):
            for axis in (0, 1):
                _, encnow, inow, error, _, vel, errcode, setpoint, demand, _ = row[
                    4 + 10 * axis : 14 + 10 * axis
                ]
                told = [setpoint, encnow, vel, error, inow, errcode]
                assert told == list(logged[1 + 7 * axis : 7 + 7 * axis])
                assert demand == setpoint


@pytest.mark.req("HB-1", "PAN-1", "LED-2")
def test_changes_come_with_their_times():
    with machine() as sim:
        sim.tap(10, 1000)
        run(sim)
        events, _, lost = sim.tap_events(0, 1000)
        assert lost == 0 and [e["n"] for e in events] == list(range(len(events)))
        kinds = [(e["kind"], e["axis"], e["value"]) for e in events]
        enabled = kinds.index(("enabled", -1, 1))
        assert ("brake", -1, 1) in kinds[:enabled]
        assert ("mode", 0, 0x11) in kinds[:enabled]
        assert {("heartbeat", 0, 1), ("heartbeat", 1, 1)} <= set(kinds)
        panic = next(e for e in events if e["kind"] == "panic" and e["t"] > 0.1 and e["value"])
        brake = next(e for e in events if e["kind"] == "brake" and not e["value"] and e["t"] > 0.1)
        error = next(e for e in events if e["kind"] == "error")
        assert brake["t"] - panic["t"] < 1e-5 and 0 < error["t"] - panic["t"] < 1e-3
        assert error["text"] == "axis 0: hardware PANIC" and error["value"] == mcdef.MERR_PANIC
        silence = [e["t"] for e in events if e["kind"] == "heartbeat" and not e["value"]]
        assert all(0.049 < t - panic["t"] < 0.0515 for t in silence) and len(silence) == 2


def test_no_request_waits_longer_than_a_second():
    """An SCLOCK every 100 s: MENABLE would wait for the first pass."""
    with machine() as sim:
        client = sim.open(mcdef.O_RDWR)
        assert sim.ioctl(client, mcdef.MSETINTERVAL, mcdef.new_int(100_000_000)) == 0
        before = sim.time
        assert sim.ioctl(client, mcdef.MENABLE) == -5
        assert 0.9 < sim.time - before < 1.2


def test_a_wait_can_be_given_up_and_nothing_untoward_is_done_in_it():
    with machine() as sim:
        client = sim.open(mcdef.O_RDWR)
        seen = []
        sim.snapshot()

        def look():
            lib, of = sim.lib, sim.handle
            others = lib.mmcs_sim_restore(of, 0), lib.mmcs_sim_run_to(of, sim.clock + 9, 0)
            seen.append((sim.run(sim.time + 0.1), lib.mmcs_sim_snapshot(of, -1.0), *others))
            return len(seen) == 2

        sim.set_look(look)
        assert sim.ioctl(client, mcdef.MENABLE) == -5
        assert seen == [(False, -1, -1, -1)] * 2
        assert not sim.stats()["enabled"]
        sim.set_look(lambda: 0)
        assert sim.ioctl(client, mcdef.MENABLE) == 0
