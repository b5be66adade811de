# SPDX-License-Identifier: Apache-2.0
"""Three processes at once, §2.3: a controller, a monitor, and one that kills both at random."""

import os
import sys

import pytest

from mmcs.tests.device_bench import PROGRAMS, all_are_free, compile_program, descriptors

LONG = os.environ.get("MMCS_LONG") == "1"
HEARTBEAT_S = 0.050


class SafetyWatch:
    """After every last close that the server sees: how long until PANIC, and is the motor idle."""

    def __init__(self, bench):
        self.bench, self.checked, self.slowest = bench, 0, 0.0
        self.hang_up, bench.server._hang_up = bench.server._hang_up, self.watched

    def watched(self, connection):
        before = len(self.bench.server.files)
        self.hang_up(connection)
        if before and not self.bench.server.files:
            self.measure()

    def measure(self):
        sim = self.bench.sim
        closed = sim.time
        while not sim.stats()["panic_level"]:
            assert sim.time - closed <= HEARTBEAT_S + 0.0005, "no PANIC after the last close"
            assert sim.run(sim.time + 0.0001)
        self.slowest = max(self.slowest, sim.time - closed)
        self.checked += 1
        assert sim.run(sim.time + 0.002)
        assert all(abs(sim.true(axis)["current"]) < 0.01 for axis in (0, 1))


@pytest.mark.req("DRV-2", "DRV-9", "HB-2")
def test_controller_monitor_and_killer(bench):
    """No hang, no leak, PANIC within 50 ms of each last close. MMCS_LONG=1: two thousand rounds."""
    seed, rounds = int(os.environ.get("MMCS_SEED", "5")), 2000 if LONG else 25
    program = compile_program(PROGRAMS / "controller.c")
    watch, before = SafetyWatch(bench), descriptors()
    killer = bench.start(sys.executable, PROGRAMS / "killer.py", program, seed, rounds)
    out, status = bench.finish(killer)
    assert status == 0, out
    bench.until(lambda: not bench.server.connections)
    figures = (
        f"seed {seed}: {out.strip()}, {watch.checked} last closes, PANIC at most "
        f"{1e3 * watch.slowest:.1f} ms later, {bench.sim.time:.1f} s of the machine"
    )
    print(figures)
    assert out.startswith(f"{rounds} rounds") and watch.checked > 0
    assert descriptors() <= before + 2  # to and from the killer
    assert all_are_free(bench.sim)
