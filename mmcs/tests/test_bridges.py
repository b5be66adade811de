# SPDX-License-Identifier: Apache-2.0
"""Bridges to what others use, as far as they need nothing that is not here anyway."""

import importlib.util
import json
import sys

import pytest

from mmcs import ROOT
from mmcs.errors import RunError
from mmcs.runs.machine import machine as make_machine
from mmcs.scenario.load import load
from tools.compiled import ran


def bridge_file(name: str):
    spec = importlib.util.spec_from_file_location("bridge", ROOT / "bridges" / name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Hal:
    """What mmcs.comp would send and take, for one axis."""

    def __init__(self, sim, setup):
        self.far = bridge_file("linuxcnc/machine.py")
        self.bridge = self.far.Bridge(sim, setup)

    def period(self, flags: int, position: float = 0.0, index: int = 0, ns: int = 1_000_000):
        m = self.far
        first = m.HEAD.pack(m.MAGIC, flags, ns) + m.AXIS_IN.pack(position, 0.0, index, 0)
        out = self.bridge.exchange(first + bytes((m.AXES - 1) * m.AXIS_IN.size))
        _, flags, _ = m.ANSWER.unpack_from(out)
        return flags, *m.AXIS_OUT.unpack_from(out, m.ANSWER.size)


@pytest.mark.req("DRV-4", "DRV-9")
def test_hal_enables_moves_stops_and_goes_on():
    setup = load("lab500", ())
    with make_machine(setup) as sim:
        hal = Hal(sim, setup)
        far = hal.far
        on = far.ENABLE | far.ESTOP_OK
        assert hal.period(far.ESTOP_OK)[0] == far.PANIC
        for _ in range(300):
            flags, position, *_ = hal.period(on, 50.0)
        assert flags == far.ENABLED | far.RELEASED and abs(position - 50) <= 6
        for _ in range(60):
            flags, _, _, _, fault, _ = hal.period(far.ENABLE, 50.0)
        assert flags == far.FAULT | far.PANIC, "the contact is open: brakes"
        hal.period(far.ESTOP_OK)
        for _ in range(300):
            flags, position, *_ = hal.period(on, 150.0)
        assert flags == far.ENABLED | far.RELEASED and abs(position - 150) <= 6
        with pytest.raises(RunError, match="2000000 ns and the scenario.s interval_us 1000"):
            hal.period(on, ns=2_000_000)
        with pytest.raises(RunError, match="build the component again"):
            hal.bridge.exchange(bytes(16))


@pytest.mark.req("TOOL-1")
def test_a_run_as_mcap():
    import io

    import numpy as np
    from mcap.reader import make_reader

    from mmcs.view.mcap_file import from_run
    from mmcs.view.runs import Run

    log = np.arange(30, dtype=float).reshape(2, 15) / 4
    made = from_run(Run(ROOT, {}, log))
    found = list(make_reader(io.BytesIO(made)).iter_messages())
    assert sorted({channel.topic for _, channel, _ in found}) == ["/axis/0", "/axis/1"]
    assert len(found) == 4 and found[0][2].log_time == 0
    assert json.loads(found[-1][2].data)["angle_rad"] == log[1, 14]


def test_the_socket_of_hal_takes_no_file_of_the_users(tmp_path):
    kept = tmp_path / "kept"
    kept.write_text("mine")
    done = ran(sys.executable, "bridges/linuxcnc/machine.py", "lab500", "--path", kept)
    assert done.returncode == 2 and "is there and is no socket" in done.stderr
    assert kept.read_text() == "mine"
