# SPDX-License-Identifier: Apache-2.0
"""Unmodified programs use the devices: lifetimes, signals, pointers, the mapped window."""

import itertools
import os
import random
import re
import signal
import time

import pytest

from mmcs import mcdef
from mmcs.tests.device_bench import (
    EXAMPLES,
    PROGRAMS,
    all_are_free,
    compile_1989,
    compile_program,
    descriptors,
)

LATE_S = 0.1  # of wire.c: no answer for so long, and signals are let through
LONG = os.environ.get("MMCS_LONG") == "1"


@pytest.mark.req("DRV-1", "DRV-5", "DRV-6")
def test_bounce_of_1989(bench):
    """Old-style main, absolute include, signal, sigpause(), ioctl with two arguments."""
    events = 440 if LONG else 24  # LONG: 60 s of the machine
    child = bench.start(compile_1989(EXAMPLES / "bounce.c"), "-t1", f"-n{events}")
    out, status = bench.finish(child)
    found = re.search(r"(\d+) limit events, (\d+) interrupts, 0 missed", out)
    assert status == 0 and found, out
    handled, interrupts = int(found[1]), int(found[2])
    raised = [
        [int(n["text"].split()[1], 16) for n in bench.sim.notes() if of_axis(n, axis)]
        for axis in (0, 1)
    ]
    notes = [note["kind"] for note in bench.sim.notes()]
    # whatever the simulator saw happen, the program has handled
    assert handled == sum(map(len, raised)) >= events
    assert len(raised[0]) > 5 and len(raised[1]) > 5
    # and in time: the motor turned round, so the limits of an axis take turns
    for axis, codes in enumerate(raised):
        assert set(codes) == {axis << 8 | mcdef.MERR_PLO, axis << 8 | mcdef.MERR_PHI}
        assert all(one != next_ for one, next_ in itertools.pairwise(codes))
    # one signal for each sample with an event; both axes may share it, and one that comes between
    # the handler's read() and MCLEARERROR signals a second time, as often as the program is slow
    assert 0.5 * handled <= notes.count("signal") <= 2 * handled
    # statistics: an interrupt every millisecond; every two until the program has set its interval
    stats = bench.sim.stats()
    assert interrupts <= stats["interrupts"] <= 1e3 * bench.sim.time
    assert stats["interrupts"] >= 500 * bench.sim.time - 100
    assert [stats[n] for n in ("missed", "overruns", "panics", "spurious", "bus_errors")] == [0] * 5
    assert notes.count("log") == 0
    assert not LONG or bench.sim.time >= 60
    print(f"{handled} limit events, {notes.count('signal')} signals, {interrupts} interrupts, "
          f"{bench.sim.time:.2f} s")  # fmt: skip


def of_axis(note, axis):
    return note["kind"] == "error" and note["axis"] == axis


@pytest.mark.req("API-1")
def test_mapped_window(bench):
    out, status = bench.finish(bench.start(compile_program(PROGRAMS / "window.c")))
    assert status == 0, out
    lines = out.splitlines()
    assert lines[:7] == [
        "where asked 1", "beyond A16 1", "byte 18", "word ff18", "word written 18",
        "long ff18ff18", "read-modify-write 1f",
    ]  # fmt: skip
    assert lines[7:59] == ["SIGSEGV"] * 52
    assert lines[59:] == ["still 1f"]


@pytest.mark.req("API-1")
def test_injected_bus_error_is_sigbus(bench):
    names = bench.sim.input_names()
    text = """
import ctypes, mmap, os, signal
fd = os.open("/dev/vme16", os.O_RDWR)
libc = ctypes.CDLL(None)
libc.mmap.restype = ctypes.c_void_p
libc.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t] + [ctypes.c_int] * 3 + [ctypes.c_long]
at = libc.mmap(None, 4096, 3, 1, fd, 0x6000)
while True:
    ctypes.c_uint8.from_address(at + 0x409).value
"""
    child = bench.python(text)
    bench.until(lambda: len(bench.server.files) == 1)
    for _ in range(50):
        bench.server.step()
    bench.sim.add_event(bench.sim.time, names.index("bus_error"), 0, 1)
    out, status = bench.finish(child)
    assert status == -signal.SIGBUS, (out, status)


@pytest.mark.req("DRV-4", "DRV-9")
def test_dup_and_fork_keep_the_file(bench):
    text = """
import fcntl, os, struct, sys
fd = os.open("/dev/mc0", os.O_RDWR)
second = os.dup(fd)
os.close(fd)
if os.fork() == 0:
    assert len(os.read(second, 56)) == 56
    sys.stdin.readline()
    assert os.write(second, struct.pack("2i", 0, 0)) == 8
    print("child done", flush=True)
    os._exit(0)
os._exit(0)
"""
    child = bench.python(text)
    bench.until(lambda: child.poll() is not None)
    assert len(bench.server.files) == 1  # the child of the fork has it
    child.stdin.close()  # and ends now
    bench.until(lambda: not bench.server.files)
    assert child.stdout.read() == "child done\n"


@pytest.mark.req("DRV-5")
def test_an_open_that_is_answered_late_leaves_the_signal_mask_alone(bench):
    text = """
import os, signal
print("opens", flush=True)
os.open("/dev/mc0", os.O_RDWR)
print(signal.pthread_sigmask(signal.SIG_BLOCK, []))
"""
    child = bench.python(text)
    assert child.stdout.readline() == "opens\n"
    time.sleep(3 * LATE_S)  # nobody serves it
    assert bench.finish(child) == ("set()\n", 0)


@pytest.mark.req("DRV-5")
def test_signal_reaches_those_who_hold_the_file(bench):
    """Parent and child of a fork get SIGUSR1; a program started without the file, and a monitor,
    do not (the default action would end them)."""
    text = """
import fcntl, os, signal, time
from mmcs import ROOT, mcdef
hold, release = os.pipe()
got = []
signal.signal(signal.SIGUSR1, lambda *_: got.append(1))
watch = os.open("/dev/mc0", os.O_RDONLY)
fd = os.open("/dev/mc0", os.O_RDWR)
other = os.fork()  # has the file until it becomes another program: descriptors close on exec
if other == 0:
    os.dup2(hold, 0)
    os.execvp("cat", ["cat"])  # until the others have had their signal
while open(f"/proc/{other}/comm").read() != "cat\\n":
    time.sleep(0.01)
child = os.fork()
if child == 0:
    os.close(watch)
else:
    made, f = mcdef.new_param(0), mcdef.make_ffi()
    param = bytearray(f.buffer(made)[:])
    fcntl.ioctl(fd, mcdef.MGETPARAM, param)
    f.buffer(made)[:] = bytes(param)
    made.mode = mcdef.MD_POS | mcdef.POSCHK | mcdef.SOFTERR
    made.plo, made.phi = 100, 200
    fcntl.ioctl(fd, mcdef.MSETPARAM, bytes(f.buffer(made)))
    try:
        fcntl.ioctl(fd, mcdef.MENABLE)
    except InterruptedError:  # a call that takes long lets the signal through
        assert got
while not got:
    time.sleep(0.01)
print("signalled", flush=True)
if child == 0:
    os._exit(0)
os.waitpid(child, 0)
os.close(release)
print("other", os.waitpid(other, 0)[1])
"""
    out, status = bench.finish(bench.python(text))
    assert (out, status) == ("signalled\nsignalled\nother 0\n", 0)


@pytest.mark.req("DRV-2", "DRV-9", "HB-2")
def test_three_processes_killed_at_random(bench):
    """Controller and monitor die by SIGKILL at any moment, also before they have opened the device,
    and come again; no hang, no leak, and PANIC within 50 ms of each last close."""
    program = compile_program(PROGRAMS / "controller.c")
    seed = int(os.environ.get("MMCS_SEED", "11"))
    print("seed", seed)
    chance, sim, before = random.Random(seed), bench.sim, descriptors()
    for turn in range(2000 if LONG else 6):
        pair = [bench.start(program, role) for role in ("controller", "monitor")]
        if turn % 3:
            bench.until(lambda: len(bench.server.files) == 2)
        for _ in range(chance.randrange(200)):
            bench.server.step()
        chance.shuffle(pair)
        for child in pair:
            assert child.poll() is None, child.stdout.read()
            child.kill()
            child.wait()
            for _ in range(chance.randrange(20)):
                bench.server.step()
        bench.until(lambda: not bench.server.files)
        closed = sim.time
        assert sim.run(closed + 0.052)
        assert sim.stats()["panic_level"] == 1
        assert all(abs(sim.true(axis)["current"]) < 0.01 for axis in (0, 1))
        bench.until(lambda: not bench.server.connections)
        for child in pair:
            child.stdin.close()
            child.stdout.close()
        bench.children.clear()
    assert descriptors() == before and all_are_free(sim)


@pytest.mark.req("DRV-3", "DRV-4")
def test_threads_share_a_descriptor(bench):
    """Each thread has a channel of its own to the server: answers do not get mixed."""
    out, status = bench.finish(bench.start(compile_program(PROGRAMS / "threads.c")))
    assert (out, status) == ("200 rounds\n", 0)
    bench.until(lambda: not bench.server.files)
    bench.until(lambda: not bench.server.connections)
