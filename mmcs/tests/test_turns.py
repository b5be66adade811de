# SPDX-License-Identifier: Apache-2.0
"""Lock-step at the server's end (sim/device/turns.h): whoever listens, the run is the same."""

import os
import subprocess
import time
from types import SimpleNamespace

import pytest

from mmcs.device import server
from mmcs.device.programs import Program
from mmcs.device.server import Server
from mmcs.device.turns import Core, Turns
from mmcs.tests.device_bench import output_in_lockstep, run_in_lockstep
from mmcs.tests.test_lockstep import EXAMPLES_RUN, PYTHON, example

STOPS = """
import mmcs
with mmcs.Device() as dev:
    dev.enable()
    for n in range(50):
        dev.wait()
        dev.write([n])
    dev.stop()
    try:
        dev.write([1])
    except OSError as error:
        print(error.strerror)
    try:
        dev.write([1, 2, 3])
    except OSError as error:
        print(error.strerror)
"""


# States that came with a sample: as read() would give them, whatever is asked in between.
READS = """
import os, time
import mmcs
from mmcs import mcdef as mc
with mmcs.Device() as dev, mmcs.Device(flags=os.O_RDONLY) as other:
    other.close()
    dev.set_param(0, {**dev.get_param(0), "mode": mc.MD_VEL | mc.POSCHK | mc.SOFTERR,
                      "plo": 5, "phi": 9})
    dev.enable()
    for n in range(60):
        number = dev.wait()
        if n % 7 == 1:
            dev.write([20])
        print(number, dev.read(1 + (n > 30)))
        if n % 11 == 2:
            dev.set_encoder(0, n % 13)
            time.sleep(0.0004)
        if n % 5 == 0:
            print(dev.read(2), dev.status().sample)
        if any(s.errcode for s in dev.read()):
            dev.clear_error()
            print("cleared", dev.read())
"""


# write()s that do without an answer: in force before all else that the program, its threads, its
# children and the next program in its place do, and when it ends.
WRITES = """
import array, fcntl, os, struct, sys, threading, time
import mmcs
from mmcs import mcdef as mc
from mmcs.device.wire import MWAIT
fd = int(sys.argv[1]) if len(sys.argv) > 1 else os.open("/dev/mc0", os.O_RDWR)
def write(*values):
    os.write(fd, struct.pack("<2i", *values))
def wait(number=array.array("I", [0])):
    fcntl.ioctl(fd, MWAIT, number)
def show(what):
    wait()
    states = list(struct.iter_unpack("<7i", os.read(fd, 56)))
    print(what, [error + feedback for _, _, _, error, feedback, *_ in states], flush=True)
def ready():
    for n in range(3):
        wait(), write(n, n)
    wait()
if len(sys.argv) == 1:
    with mmcs.Device() as dev:
        for axis in range(2):
            dev.set_param(axis, {**dev.get_param(axis), "mode": mc.MD_POS})
        dev.enable()
    ready(), write(50, 60), show("one")
    ready(), write(51, 61), write(52, 62), show("two")
    ready(), write(53, 63), fcntl.ioctl(fd, mc.MSETPOINT, struct.pack("<2i", 0, 70)), show("call")
    def other():
        ready(), write(54, 64)
    for n in range(2):
        thread = threading.Thread(target=other)
        thread.start(), thread.join()
        show("thread")
    ready(), write(55, 65)
    if os.fork() == 0:
        show("child"), os._exit(0)
    show("parent")
    os.wait()
    ready(), write(56, 66), time.sleep(0.0025), show("sleep")
    os.set_inheritable(fd, True)
    ready(), write(57, 67), write(58, 68), os.execv(sys.executable, [*sys.orig_argv, str(fd)])
show("exec"), ready(), write(59, 69)
"""


GENUINE = Program.serve, Server.close


@pytest.mark.parametrize(
    "what", [*EXAMPLES_RUN, STOPS, READS, WRITES],
    ids=[*(path.name for path in EXAMPLES_RUN), "stops", "reads", "writes"],
)  # fmt: skip
def test_a_run_is_the_same_whoever_listens(what, tmp_path, monkeypatch):
    """Beside nothing or a busy loop; many turns at once or one at a time: the same output, the
    same hash."""
    command = [*PYTHON, what] if isinstance(what, str) else example(what)
    name = getattr(what, "name", "")
    serve, close, runs, calls, asked = *GENUINE, [], [], []

    def count(self):
        asked.append((self.lockstep.now.requests + len(calls), self.sim.samples))
        close(self)

    monkeypatch.setattr(Program, "serve", lambda *a: calls.append(1) or serve(*a))
    monkeypatch.setattr(Server, "close", count)
    for turns, busy in ((64, "exit"), (1, "while :; do :; done")):
        monkeypatch.setattr(server, "TURNS", turns)
        if turns == 1:  # who becomes a line is one before it goes on
            late = lambda t, *a: time.sleep(0.01) or t.__getattr__("line")(*a)  # noqa: E731
            monkeypatch.setattr(Turns, "line", late, raising=False)
        out = tmp_path / "out"
        shell = "" if name == "sine.py" else "exec"  # the shell waits, or is the program
        words = ["sh", "-c", f'{shell} "$@" > {out}; exit', "sh", *command]
        with subprocess.Popen(["nice", "sh", "-c", busy]) as beside:
            status, hash_ = run_in_lockstep(tmp_path / "m", *words)
            beside.kill()
        runs.append((status, hash_, out.read_text()))
    assert runs[0] == runs[1] and runs[0][0] == 0
    if name == "sine.c":  # a sample costs one request, for which it waits
        requests, samples = asked[0]
        assert samples > 900 and requests < 1.1 * samples
    if what == WRITES:
        assert "parent [55, 65]" in runs[0][2] and "exec [58, 68]" in runs[0][2]
    if what == READS:
        assert "cleared" in runs[0][2]
    if what == STOPS:
        assert "stopped, MENABLE first" in runs[0][2] and "than the servo controls" in runs[0][2]


CORES = """
import os, threading, mmcs
def tell():
    print(len(os.sched_getaffinity(0)), flush=True)
with mmcs.Device(flags=os.O_RDONLY) as dev:
    dev.wait(), tell()
    thread = threading.Thread(target=tell)
    thread.start(), thread.join()
    if os.fork() == 0:
        tell(), os._exit(0)
    os.wait()
"""


def test_server_and_programs_share_a_core(tmp_path):
    """To wake a process on another core costs more than what the calls of a sample do."""
    before = os.sched_getaffinity(0)
    assert output_in_lockstep(tmp_path, *PYTHON, CORES)[:2] == ("1\n1\n1\n", 0)
    assert os.sched_getaffinity(0) == before
    child = subprocess.Popen(["sleep", "60"])
    core = Core(SimpleNamespace(pids=lambda: [child.pid]))
    core.leave()
    core.share(1.0)
    shared = os.sched_getaffinity(0)
    assert os.sched_getaffinity(child.pid) == shared and len(shared) == 1
    core.leave()
    assert os.sched_getaffinity(child.pid) == os.sched_getaffinity(0) == before
    child.kill(), child.wait()
    core.share(2.0), core.leave()  # it has ended
