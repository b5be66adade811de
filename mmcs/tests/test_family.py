# SPDX-License-Identifier: Apache-2.0
"""Each example program beside each kind of neighbour under each fault that a program can see, in
lock-step: nothing moves that was not asked, nobody who must know is not told (§2.3.4).

A sample of the pairs runs in `make test`, all of them with MMCS_FAMILY=all (`make test-all`)."""

import itertools
import os
import subprocess
import sys

import pytest

from mmcs.device.execute import environment
from mmcs.tests.device_bench import lockstep_server
from mmcs.tests.test_lockstep import EXAMPLES_RUN, example

FAULT_S, END_S, AFTER_S = 0.5, 1.1, 0.15

# Of a neighbour: it has the device open all the time, and says when it is signalled.
NEIGHBOUR = """
import os, signal, sys, time
import mmcs
told = open(sys.argv[2], "a", buffering=1)
kind = sys.argv[1]
signal.signal(signal.SIGUSR1, lambda *_: told.write("signal\\n"))
with mmcs.Device(flags=os.O_RDONLY if kind == "monitor" else os.O_RDWR) as dev:
    for turn in range(600):
        time.sleep(0.0037)
        try:
            if any(s.errcode for s in dev.read()):
                told.write("errcode\\n")
                if kind == "writer":
                    dev.clear_error()  # what it has read: others must be told all the same
        except OSError as error:
            told.write(f"error {error.errno}\\n")
        if kind == "killed" and turn == 100:
            os.kill(os.getpid(), signal.SIGKILL)
        if kind == "stopped" and turn == 100:
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
            time.sleep(2.0)
"""
NEIGHBOURS = ("none", "monitor", "writer", "killed", "stopped")
# name of the input, its value, and for how long, one after the other (None: for ever)
LENGTHS_S = (0.001, 0.02, 0.055, 0.07, 0.2, 1.0)
FAULTS = {
    "button": ("estop", 1, [None]),
    "cable for a moment": ("cable", 0, LENGTHS_S),
    "power for a moment": ("pc_power", 0, LENGTHS_S),
    "bus error": ("bus_error", 40, [None]),
    "SYSRESET*": ("sysreset", 1, LENGTHS_S),
    "no interrupts": ("irq_lost", 1, LENGTHS_S[3:]),  # nobody notices a shorter one
}
# Those that move from before the fault to the end; the others are over, or stop by themselves.
PROGRAMS = {p.name: p for p in EXAMPLES_RUN if p.name in ("bounce.c", "sine.c", "sine.py")}
ALL = [
    (*pair, fault, FAULTS[fault][2][number % len(FAULTS[fault][2])])
    for number, pair in enumerate(itertools.product(PROGRAMS, NEIGHBOURS))
    for fault in FAULTS
]
PAIRS = ALL if os.environ.get("MMCS_FAMILY") == "all" else ALL[::7]


def run(folder, command, neighbour, fault, length):
    """What happened: signals by process, notes, hash, whether power is on, how far joints are from
    where the shutdown left them, and how many samples came once the fault was over for a while."""
    told = folder / "told"
    with lockstep_server(folder) as server:
        sim, (name, value, _) = server.sim, FAULTS[fault]
        number = sim.input_names().index(name)
        sim.add_event(FAULT_S, number, 0, value)
        if length is not None:
            sim.add_event(FAULT_S + length, number, 0, 0 if value else 1)
        over = FAULT_S + (length or 0) + AFTER_S / 2
        end, samples = max(END_S, over + AFTER_S / 2), None
        env = environment(server.path, lockstep=True)
        words = [[str(c) for c in command]]
        if neighbour != "none":
            words.insert(0, [sys.executable, "-c", NEIGHBOUR, neighbour, str(told)])
        with (folder / "out").open("w") as out:
            children = []
            try:
                for line in words:
                    children.append(subprocess.Popen(line, env=env, stdout=out, stderr=out))
                    server.lockstep.expect(children[-1].pid)
                program = children[-1]
                while sim.time < end and any(c.pid in server.lockstep.pids() for c in children):
                    server.step()
                    if samples is None and sim.time >= over:
                        samples = sim.samples
                program.poll()
                enabled = sim.stats()["enabled"]  # while who is still there has it open
            finally:
                for child in children:
                    child.kill()
                    child.wait()
        heard = [n for n in sim.notes() if n["kind"] == "signal" and n["t"] >= FAULT_S]
        return {
            "signals": [n["t"] for n in heard], "clients": {n["text"] for n in heard},
            "enabled": enabled, "status": program.returncode,
            "notes": [n["text"] for n in sim.notes() if n["kind"] == "log"],
            "samples": sim.samples - (samples or 0), "end": end,
            "resting": abs(sim.true(1)["angle"]), "hash": sim.hash(),
            "told": told.read_text() if told.exists() else "", "time": sim.time,
        }  # fmt: skip


@pytest.mark.req("DRV-5", "DRV-13")
@pytest.mark.parametrize(
    "name, neighbour, fault, length", PAIRS, ids=lambda v: str(v).replace(" ", "_")
)
def test_beside_a_neighbour_under_a_fault(name, neighbour, fault, length, tmp_path):
    got = run(tmp_path, example(PROGRAMS[name]), neighbour, fault, length)
    # who must know: every writer there is, by a signal, soon; and the console says why
    assert got["signals"] and got["signals"][0] < FAULT_S + 0.08, got
    assert len(got["clients"]) == 1 + (neighbour in ("writer", "stopped")), got
    assert any("PANIC" in line for line in got["notes"]), got
    # nothing goes on by itself: power stays off, and setpoints of before are refused
    assert not got["enabled"], got
    if name != "bounce.c":  # whose second axis moves, too
        assert got["status"] not in (None, 0), got  # EIO, or SIGUSR1 without a handler
        assert got["resting"] == pytest.approx(0, abs=0.01), got
    if neighbour in ("monitor", "writer"):  # who has it open to the end: the machine lives again
        assert got["time"] >= got["end"] and got["samples"] > 10, got
    if neighbour == "writer":
        assert "signal" in got["told"] and "errcode" in got["told"], got
    if neighbour == "monitor" and got["time"] > FAULT_S + 0.1:
        assert "signal" not in got["told"] and "errcode" in got["told"], got
