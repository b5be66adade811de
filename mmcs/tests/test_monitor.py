# SPDX-License-Identifier: Apache-2.0
"""What a page does that only looks on, beside a program that bounces: nothing (§3)."""

import signal
import struct

import pytest

from mmcs import mcdef
from mmcs.device.wire import IOCTL, READ, WRITE
from mmcs.tests.device_bench import Bench
from mmcs.tests.raw import Asker, Raw

LIMIT, SPEED = 150, (10, -15)
# As web/machine.js, panel.js and the views ask when a page opens, and while it is looked at.
AT_FIRST = (
    {"op": "name", "name": "mctool"}, {"op": "follow", "past": 8000, "period_ms": 0},
    {"op": "open", "mode": "r"}, {"op": "machine"},
)  # fmt: skip
AGAIN = (
    {"op": "call", "request": "MGETINTERVAL"}, {"op": "call", "request": "MGETSTATS"},
    {"op": "call", "request": "MGETPARAM", "axis": 0}, {"op": "read"}, {"op": "inputs"},
    {"op": "call", "request": "MGETPARAM", "axis": 1}, {"op": "snapshots"}, {"op": "clients"},
)  # fmt: skip


class Looker(Asker):
    """A page's requests."""

    def ask(self, requests=AT_FIRST):
        for request in requests:
            self.post({"id": 1, **request})
        for _ in requests:
            assert (reply := self.reply())["ok"], reply


def set_up(bench, program):
    """As bounce.c: two axes in velocity mode between limits."""
    for axis in (0, 1):
        param = mcdef.new_param(axis)
        mcdef.fill_param(param, {"a0": 100, "b0": 1, "clkdivisor": 1, "ilim": 1024, "adc_a": 1,
                                 "plo": -LIMIT, "phi": LIMIT, "mode": "velocity",
                                 "flags": ["softerr", "poschk"]})  # fmt: skip
        assert program.call(IOCTL, mcdef.MSETPARAM, bytes(mcdef.make_ffi().buffer(param)))[0] == 0
    (driver,) = (f.client.driver for f in bench.server.files.values() if f.client.writes)
    assert bench.sim.ioctl(driver, mcdef.MENABLE) == 0  # the machine is paused: a call would wait


def bounced(program, setpoints):
    """As the handler of SIGUSR1; how many limits it saw."""
    size, data = program.call(READ, 56)
    assert size == 56
    assert program.call(IOCTL, mcdef.MCLEARERROR)[0] == 0
    events = 0
    for axis in (0, 1):
        code = struct.unpack_from("<7i", data, 28 * axis)[6]
        if code & (mcdef.MERR_PLO | mcdef.MERR_PHI):
            events += 1
            setpoints[axis] = abs(setpoints[axis]) * (1 if code & mcdef.MERR_PLO else -1)
    assert program.call(WRITE, 0, struct.pack("<2i", *setpoints))[0] == 8
    return events


def bounce(folder, watched):
    folder.mkdir(mode=0o700)
    with Bench(folder) as bench:
        program = Raw(bench)
        bench.server.machine.now.paused = True  # time passes as the test says, steps or no steps
        page = Looker(bench.server) if watched else None
        if page:
            page.ask()
        bench.sim.run(0.01)
        set_up(bench, program)
        setpoints, events, signals = list(SPEED), 0, []
        signal.signal(signal.SIGUSR1, lambda *_: signals.append(1))  # the program is this process
        program.call(WRITE, 0, struct.pack("<2i", *setpoints))
        for n in range(500):
            assert bench.sim.run(0.2 + 0.002 * n)
            if page and n % 5 == 0:
                page.ask(AGAIN)
            bench.server.signal()  # time passed by the test's hand, not by a step
            if signals:
                signals.clear()
                events += bounced(program, setpoints)
        return events, bench.sim.hash(), bench.sim.stats()["bus_cycles"]


@pytest.mark.req("TOOL-1")
def test_a_page_that_looks_on_changes_nothing(tmp_path):
    """Every bus cycle and sample, every limit that was seen: as without the page."""
    before = signal.getsignal(signal.SIGUSR1)
    alone, beside = bounce(tmp_path / "a", watched=False), bounce(tmp_path / "b", watched=True)
    signal.signal(signal.SIGUSR1, before)
    assert alone == beside
    assert alone[0] >= 4
