# SPDX-License-Identifier: Apache-2.0
"""What a page does that only looks on, beside a program that moves: nothing (§3)."""

import struct

import pytest

from mmcs import mcdef
from mmcs.device.wire import WRITE
from mmcs.tests.device_bench import Bench
from mmcs.tests.raw import Asker, Raw

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


def ask(page, requests):
    for request in requests:
        page.post({"id": 1, **request})
    for _ in requests:
        assert (reply := page.reply())["ok"], reply


def moved(folder, watched):
    """An axis turns round and round, and its limit signals; the hash, bus cycles, signals."""
    folder.mkdir(mode=0o700)
    with Bench(folder) as bench:
        program, sim = Raw(bench), bench.sim
        bench.server.machine.now.paused = True  # time passes as the test says, steps or no steps
        page = Asker(bench.server) if watched else None
        if page:
            ask(page, AT_FIRST)
        (driver,) = (f.client.driver for f in bench.server.files.values() if f.client.writes)
        param = mcdef.new_param(0)
        mcdef.fill_param(param, {"a0": 100, "b0": 1, "clkdivisor": 1, "ilim": 1024, "adc_a": 1,
                                 "phi": 150, "mode": "velocity",
                                 "flags": ["softerr", "poschk"]})  # fmt: skip
        assert sim.ioctl(driver, mcdef.MSETPARAM, param) == 0
        assert sim.ioctl(driver, mcdef.MENABLE) == 0
        assert program.call(WRITE, 0, struct.pack("<2i", 10, 0))[0] == 8
        for n in range(100):
            assert sim.run(0.2 + 0.01 * n)
            if page:
                ask(page, AGAIN)
            bench.server.signal()  # time passed by the test's hand, not by a step
        signals = [note["t"] for note in sim.notes() if note["kind"] == "signal"]
        return sim.hash(), sim.stats()["bus_cycles"], signals


@pytest.mark.req("TOOL-1")
def test_a_page_that_looks_on_changes_nothing(tmp_path, unsignalled):
    """Every bus cycle and sample, every signal: as without the page."""
    alone, beside = (moved(tmp_path / name, name == "beside") for name in ("alone", "beside"))
    assert alone == beside and alone[2]
