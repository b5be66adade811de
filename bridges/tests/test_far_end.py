# SPDX-License-Identifier: Apache-2.0
"""The machine behind LinuxCNC's component, without LinuxCNC: what the component would send."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from mmcs import RunError, load, machine

FILE = Path(__file__).resolve().parents[1] / "linuxcnc/machine.py"
SPEC = importlib.util.spec_from_file_location("far_end", FILE)
far = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(far)


class Hal:
    """What mmcs.comp would send and take, for one axis."""

    def __init__(self, sim, setup):
        self.bridge = far.Bridge(sim, setup)

    def period(self, flags: int, position: float = 0.0, index: int = 0, ns: int = 1_000_000):
        first = far.HEAD.pack(far.MAGIC, flags, ns) + far.AXIS_IN.pack(position, 0.0, index, 0)
        out = self.bridge.exchange(first + bytes((far.AXES - 1) * far.AXIS_IN.size))
        _, flags, _ = far.ANSWER.unpack_from(out)
        return flags, *far.AXIS_OUT.unpack_from(out, far.ANSWER.size)


@pytest.mark.req("DRV-4", "DRV-9")
def test_hal_enables_moves_stops_and_goes_on():
    setup = load("lab500")
    with machine(setup) as sim:
        hal = Hal(sim, setup)
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
        with pytest.raises(RunError, match="MCALIB: Invalid argument"):
            hal.bridge._ask("MCALIB", far.mcdef.new_int(9))


@pytest.mark.req("PAN-1")
def test_brakes_are_on_in_the_answer_that_tells_of_panic():
    """Not a sample later."""
    opened, answers = far.ENABLE, []
    closed = opened | far.ESTOP_OK
    with machine(setup := load("lab500")) as sim:
        bridge = far.Bridge(sim, setup)
        for flags in [far.ESTOP_OK] * 5 + [closed] * 100 + [opened] * 5:
            head = far.HEAD.pack(far.MAGIC, flags, round(bridge.interval_s * 1e9))
            answer = bridge.exchange(head + bytes(far.AXES * far.AXIS_IN.size))
            answers.append(far.ANSWER.unpack_from(answer)[1])
    panic, released = far.PANIC, far.RELEASED
    assert answers[104] & (panic | released) == released
    assert [flags & (panic | released) for flags in answers[105:]] == [panic] * 5


def test_the_socket_of_hal_takes_no_file_of_the_users(tmp_path):
    kept = tmp_path / "kept"
    kept.write_text("mine")
    command = [sys.executable, str(FILE), "lab500", "--path", str(kept)]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == 2 and "is there and is no socket" in done.stderr
    assert kept.read_text() == "mine"
