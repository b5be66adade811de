# SPDX-License-Identifier: Apache-2.0
"""Rules of the driver on the machine in RTL, natively and on both processors. §2.3"""

import importlib.util
import shutil

import pytest

from mmcs import mcdef
from mmcs.scenario.load import load
from mmcs.session.machine import machine

COMPILERS = {"m68020": "m68k-linux-gnu-gcc", "rv32": "riscv64-unknown-elf-gcc"}
MODEL = importlib.util.find_spec("machine68k")


def cpu(name):
    missing = not shutil.which(COMPILERS[name]) or (name == "m68020" and not MODEL)
    skip = pytest.mark.skipif(missing, reason="install what is missing with: make firmware")
    return pytest.param(name, marks=[pytest.mark.slow, skip])


HOSTS = ["native", cpu("m68020"), cpu("rv32")]


def bench(host, scenario="puma560", **keys):
    sets = [f"{key}={value}" for key, value in keys.items()]
    return machine(load(scenario, ("motion=[]", "expect=[]", *sets)), host=host)


def ask(sim, fd, request, value=None):
    """An ioctl() with an int; 0 or a negative error."""
    data = b"" if value is None else int(value).to_bytes(4, "little", signed=value < 0)
    return sim.ioctl_bytes(fd, request, data)[0]


def run(sim, seconds):
    sim.run(sim.time + seconds)


@pytest.mark.req("DRV-2", "DRV-9", "DRV-10", "DIA-2")
@pytest.mark.parametrize("host", HOSTS)
def test_no_call_moves_a_count(host):
    """Three rounds of open, switches, enable and close: counter and driver show what they did."""
    with bench(host) as sim:
        run(sim, 0.005)
        before = [sim.encoder_register(axis) for axis in range(6)]
        for _ in range(3):
            fd = sim.open()
            for mode in (2, 0, 3, 0):
                ask(sim, fd, mcdef.MDIAGMODE, mode)
                run(sim, 0.005)
            assert [s["encnow"] & 0xFFFF for s in sim.read(fd)] == before
            ask(sim, fd, mcdef.MSTOP)
            sim.close(fd)
            run(sim, 0.005)
            assert [sim.encoder_register(axis) for axis in range(6)] == before
