# SPDX-License-Identifier: Apache-2.0
"""A served machine inside the test, and programs that use it (§2.3)."""

import os
import subprocess
import sys
import threading
from contextlib import contextmanager

from mmcs import ROOT
from mmcs.device.execute import DEVICE, LIBRARY, cflags, environment, serve_program
from mmcs.device.server import Server
from mmcs.engine.build import ensure_library
from mmcs.engine.sim import Sim
from mmcs.runs.machine import machine
from mmcs.scenario.load import load
from mmcs.scenario.robot_header import header
from tools.compiled import compiled, written

PROGRAMS = ROOT / "sim" / "tests" / "device"
EXAMPLES = ROOT / "firmware" / "examples"
PORT = ROOT / "firmware" / "ports" / "linux" / "user.c"  # the driver in the program itself

FLAGS = ("-Wall", "-Wextra", "-O1", f"-I{ROOT / 'firmware/include'}",
         f"-I{ROOT / 'firmware/examples'}", f"-I{DEVICE / 'include'}")  # fmt: skip

# Set by test_sanitizers.py for a run of its own: everything with sanitizers.
SANITIZED = os.environ.get("MMCS_SANITIZE") == "1"

SCENARIO = """
description = "Two bench motors on one card"
robot = "two.toml"
cards = 1
duration = 1.0
skip = true
"""


_LAB = (ROOT / "sim" / "robots" / "lab500.toml").read_text()
ROBOT = written("two.toml", _LAB.replace('name = "LAB500"', 'name = "LAB500"\ncopies = 2'))


def write_scenario(folder):
    (folder / "two.toml").write_text(ROBOT.read_text())
    path = folder / "device.toml"
    path.write_text(SCENARIO)
    return path


def make_sim(folder, sets=()) -> Sim:
    setup = load(str(write_scenario(folder)), sets)
    library = ensure_library(1, "asan" if SANITIZED else "speed")
    return machine(setup, library=library)


def compile_program(source, *flags):
    """A program of our own, or one of 1989 with the flags that `mmcs exec --cflags` prints."""
    seen = [ROOT / "firmware" / "include" / "mcdef.h", LIBRARY]  # where it was in 1989, and by whom
    return compiled(source.stem, ["gcc", *(flags or FLAGS)], [source], ["-lpthread", "-lm"], seen)


def compile_1989(source):
    return compile_program(source, *cflags())


def compile_example(source):
    """An example of C, of 1989 or of today, for a robot of two bench motors."""
    if source.stem in ("bounce", "readregs"):
        return compile_1989(source)
    if source == PORT:
        driver = sorted((ROOT / "firmware" / "mc").glob("*.c"))
        flags = [*FLAGS, f"-I{ROOT / 'firmware' / 'mc'}"]
        return compiled("user", ["gcc", *flags], [source, *driver], ["-lpthread", "-lm"])
    table = written("robot.h", header(str(ROBOT), 1000)).parent
    return compile_program(source, *FLAGS, f"-I{table}")


class Clock:
    """A clock on the wall that only the test moves, in place of the module time."""

    now = 1000.0

    def monotonic(self):
        return self.now


class Bench:
    """The server runs in the test's own thread: step by step while something is waited for."""

    def __init__(self, folder, speed=None):
        self.sim = make_sim(folder)
        self.server = Server(self.sim, folder / "mc0.sock", speed)
        self.env = environment(self.server.path, SANITIZED)
        self.children = []

    def start(self, *command):
        child = subprocess.Popen(
            [str(c) for c in command], env=self.env, text=True, stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        self.children.append(child)
        return child

    def python(self, text):
        return self.start(sys.executable, "-c", text)

    def go_on(self, child):
        """A line for a program that waits for one."""
        child.stdin.write("\n")
        child.stdin.flush()

    def until(self, ready):
        """Serves until ready() holds, however long the programs take."""
        while not ready():
            self.server.step()

    def finish(self, child):
        """Serves until the program has ended; its output and status."""
        self.until(lambda: child.poll() is not None)
        return child.stdout.read(), child.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for child in self.children:
            child.kill()
            child.wait()
            child.stdout.close()
            child.stdin.close()
        self.server.close()
        self.sim.destroy()


@contextmanager
def lockstep_server(folder, sets=(), **options):
    """A server in lock-step, from power-on."""
    with make_sim(folder, sets) as sim:
        server = Server(sim, folder / "mc0.sock", None, lockstep=True, **options)
        try:
            yield server
        finally:
            server.close()


@contextmanager
def running(server):
    """The server runs in a thread of its own."""
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        yield server
    finally:
        server.stopping = True
        thread.join()
        server.stopping = False


def run_in_lockstep(folder, *command, sets=()):
    """A run of a program from power-on, in lock-step: its status, and the machine's hash."""
    folder.mkdir(mode=0o700, exist_ok=True)
    with lockstep_server(folder, sets) as server:
        return serve_program(server, [str(c) for c in command]), server.sim.hash()


def output_in_lockstep(folder, *command, sets=()):
    """The same: what the program prints, its status, the hash."""
    out = folder / "out"
    shell = ["sh", "-c", f'exec "$@" > {out}', "sh", *command]
    status, hash_ = run_in_lockstep(folder / "m", *shell, sets=sets)
    return out.read_text(), status, hash_


def descriptors():
    return len(os.listdir("/proc/self/fd"))


def all_are_free(sim):
    """Every open of the driver's sixteen."""
    clients = [sim.open(2) for _ in range(16)]
    for client in clients:
        sim.close(client)
    return sorted(clients) == list(range(16))
