# SPDX-License-Identifier: Apache-2.0
"""What a program sees when the machine, its server, the wall clock or its samples let it down."""

import sys

import pytest

from mmcs.device import pace as pacing
from mmcs.device.execute import cflags, serve_program
from mmcs.device.pace import Pace
from mmcs.device.server import Server
from mmcs.tests.device_bench import Bench, Clock, lockstep_server
from tools.compiled import ran

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


class Sim:
    time = 0.0


def test_lost_time_is_not_made_up(monkeypatch):
    """The computer was away for a while: afterwards a second still takes a second."""
    clock, sim = Clock(), Sim()
    monkeypatch.setattr(pacing, "time", clock)
    pace = Pace(sim, sim, 1.0)  # which has both
    clock.now += 0.9
    began, simulated = clock.now, 0.0
    while clock.now < began + 1.0:
        if pace.is_due():
            sim.time += 0.002
            simulated += 0.002
            clock.now += 0.0005  # a chunk takes less than it lasts
        else:
            clock.now += 0.0005
    assert simulated == pytest.approx(1.0, abs=0.03)


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


def test_flags_of_1989_and_of_today(tmp_path):
    old, new = tmp_path / "old.c", tmp_path / "new.cpp"
    old.write_text("extern int errno;\nmain() { errno = 3; return errno != 3; }\n")
    new.write_text("#include <sys/mcdef.h>\nint main() { return MC_FSCALE != 1024; }\n")
    for compiler, source, flags in (("gcc", old, cflags()), ("g++", new, cflags(modern=True))):
        done = ran(compiler, *flags, source, "-o", tmp_path / "a.out")
        assert (done.returncode, done.stderr) == (0, "")
        assert ran(tmp_path / "a.out").returncode == 0
