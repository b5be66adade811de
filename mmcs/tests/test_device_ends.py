# SPDX-License-Identifier: Apache-2.0
"""What a program sees when the machine, its server, the wall clock or its samples let it down."""

import sys

import pytest

from mmcs.device.execute import serve_program
from mmcs.device.server import Server
from mmcs.tests.device_bench import Bench, lockstep_server

NO_SAMPLES = """
import mmcs
with mmcs.Device() as dev:
    dev.wait()
    try:
        while True:
            dev.wait()
    except OSError as error:
        print(error.errno, dev.stats()["total"] > 10)
"""


def test_mwait_ends_when_no_sample_comes(tmp_path):
    """In lock-step, too."""
    with lockstep_server(tmp_path) as server:
        sim, out = server.sim, tmp_path / "out"
        sim.add_event(0.1, sim.input_names().index("irq_lost"), 0, 1)
        command = ["sh", "-c", f'exec "$0" -c "$1" > {out}', sys.executable, NO_SAMPLES]
        assert (serve_program(server, command), out.read_text()) == (0, "5 True\n")
        assert 2.5 < sim.time < 2.8


@pytest.mark.parametrize("speed", [1000.0, None])
def test_the_wall_goes_on_without_programs(tmp_path, speed):
    with Bench(tmp_path, speed) as bench:
        for _ in range(3):
            bench.server.step()
        before = bench.sim.time
        if speed is None:
            for _ in range(3):
                bench.server.step()
            assert bench.sim.time == before
        else:
            bench.until(lambda: bench.sim.time > before + 0.01)


RESTARTED = """
import errno, os, sys
import mmcs
dev = mmcs.Device()
fd = os.open("/dev/mc0", os.O_RDWR)
print("open", flush=True)
sys.stdin.readline()
for call in (dev.stop, dev.stats, lambda: dev.write([1]), lambda: os.read(fd, 28)):
    try:
        call()
        print("nothing")
    except OSError as error:
        print(error.errno == errno.EIO)
"""


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("again", [False, True])
def test_a_dead_server_is_eio(bench, again):
    """Also when another one listens in its place."""
    child = bench.python(RESTARTED)
    bench.until(lambda: len(bench.server.files) == 2)
    assert child.stdout.readline() == "open\n"
    bench.server.close()
    if again:
        bench.server = Server(bench.sim, bench.server.path, None)
    bench.go_on(child)
    while again and child.poll() is None:
        bench.server.step()
    child.wait()
    assert child.stdout.read().split() == ["True"] * 4
    if not again:
        bench.server = Server(bench.sim, bench.server.path, None)
