# SPDX-License-Identifier: Apache-2.0
"""Bridges to what others use, as far as they need nothing but us: the far end of LinuxCNC's HAL."""

from __future__ import annotations

import importlib.util

import pytest

from mmcs import ROOT
from mmcs.errors import RunError
from mmcs.scenario.load import load
from mmcs.session.machine import machine as make_machine


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
        with pytest.raises(RunError, match="build it anew"):
            hal.bridge.exchange(bytes(16))
