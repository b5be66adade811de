# SPDX-License-Identifier: Apache-2.0
"""Bridges to what others use, as far as they need nothing that is not here anyway."""

import importlib.util
import json
import re
import socket
import struct
import sys
from typing import ClassVar

import pytest

from mmcs import ROOT, mcdef
from mmcs.device.link import HEAD, Samples
from mmcs.errors import InputError, RunError
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


@pytest.mark.req("SYN-1")
def test_a_linear_plant_moves_as_the_machine_does(tmp_path):
    """A step of the D/A, friction taken out of the robot: within one part in a hundred."""
    import control
    import numpy as np

    from mmcs import ROBOTS
    from mmcs.bridge.linear import state_space

    text = (ROBOTS / "lab500.toml").read_text()
    for name in ("coulomb_pos", "coulomb_neg", "stiction_pos", "stiction_neg"):
        text = re.sub(rf"^{name} = \d.*$", f"{name} = 0.0", text, flags=re.M)
    (tmp_path / "free.toml").write_text(text)
    scenario = tmp_path / "run.toml"
    scenario.write_text(
        f'extends = "{ROOT}/sim/scenarios/basic/lab500.toml"\nrobot = "free.toml"\nexpect = []\n'
        'motion = []\n[[servo]]\naxis = 0\nmode = "torque"\nflags = []\nilim = 2047\n'
    )
    setup = load(str(scenario), ())
    with make_machine(setup) as sim:
        client = sim.open()
        sim.ioctl(client, mcdef.MSETINTERVAL, mcdef.new_int(1000))
        param = mcdef.new_param(0)
        mcdef.fill_param(param, setup.params[0])
        assert sim.ioctl(client, mcdef.MSETPARAM, param) == 0
        assert sim.ioctl(client, mcdef.MENABLE, None) == 0
        sim.write(client, [40])
        sim.run(sim.time + 0.0011)  # the next pass writes it
        begin = sim.true(0)
        sim.run(sim.time + 0.1)
        turned = sim.true(0)["count"] - begin["count"]
    plant = state_space(str(scenario))
    t = np.linspace(0, 0.101, 1012)
    counts = control.forced_response(plant, t, np.full(len(t), 40 * 10 / 2048)).outputs
    assert turned > 200
    assert counts[-11] * 0.97 < turned < counts[-1] * 1.03
    sampled = state_space(str(scenario), interval_s=0.001)
    assert sampled.dt == 0.001 and len(sampled.poles()) == len(plant.poles())
    with pytest.raises(InputError, match="axis"):
        state_space("lab500", axis=2)


@pytest.mark.req("TOOL-1")
def test_what_plotjuggler_is_sent():
    """Each datagram one JSON object with its time, as PlotJuggler's own example client does."""
    from mmcs.bridge.live import message, send

    fields = ["adcvai", "encnow", *"abcdefg", "current"]
    row = {"t": 1.25, "lines": 6, "axes": [list(range(10)), list(range(10, 20))]}
    got = json.loads(message(row, fields))
    assert got["timestamp"] == 1.25 and got["mmcs"]["axis1"]["encnow"] == 11
    assert got["mmcs"]["lines"] == {"panic": 0, "brakes_released": 1, "enabled": 1, "stopped": 0,
                                    "irq": 0}  # fmt: skip

    class Machine:
        hello: ClassVar = {"sample": {"fields": fields}}

        def request(self, op, **how):
            assert (op, how) == ("follow", {"every": 2, "events": False})

        def receive(self):
            head = HEAD.pack(b"S1\0\0", 3, 80, 1, 1, 0.0, 0.0)
            line = struct.pack("<ddii10i1i", 7, 0.5, 1, 1, *range(10), 0).ljust(80, b"\0")
            return Samples(head + 3 * line)

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as juggler:
        juggler.bind(("127.0.0.1", 0))
        assert send(Machine(), juggler.getsockname(), every=2, samples=4) == 4
        seen = [json.loads(juggler.recv(4096)) for _ in range(4)]
    assert seen[3]["timestamp"] == 0.5 and seen[3]["mmcs"]["axis0"]["current"] == 9


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
