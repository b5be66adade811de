# SPDX-License-Identifier: Apache-2.0
"""The stop path acts in the first step that can read it, whoever talks (docs/use/protocol.md)."""

import os
import struct

import pytest

from mmcs import mcdef
from mmcs.device.programs import Program
from mmcs.device.wire import IOCTL, WRITE
from mmcs.tests.raw import Raw, holding, stop_line

ROUNDS = 2000
FLOODERS = 15
pytestmark = pytest.mark.usefixtures("unsignalled")


@pytest.fixture
def program(bench):
    """A program that holds both axes."""
    made = Raw(bench)
    holding(bench, made)
    yield made
    made.close()


@pytest.mark.req("DRV-9")
def test_a_stop_acts_in_the_first_step_that_could_read_it(bench, monkeypatch):
    """Under fifteen flooding clients, two thousand times; each time a snapshot gives back the
    machine as it was, under power and holding."""
    programs = [Raw(bench) for _ in range(FLOODERS)]
    holding(bench, programs[0])
    sim, machine = bench.sim, bench.server.machine
    with stop_line(bench) as line:
        bench.server.step()
        running = sim.snapshot()
        served, genuine = [], Program.serve
        monkeypatch.setattr(Program, "serve", lambda *a: served.append(1) or genuine(*a))
        stopped_at, stop = [], machine.stop
        machine.stop = lambda: stopped_at.append((sim.time, len(served))) or stop()
        for n in range(ROUNDS):
            if n % 100 == 0:
                for program in programs:
                    program.flood()
                assert machine.request(None, {"op": "rewind", "snapshot": running})["t"]
            else:
                sim.restore(running)
            assert sim.stats()["enabled"]
            before, served[:] = sim.time, []
            line.sendall(b"stop\n")
            stopped_at.clear()
            bench.server.step()
            assert stopped_at == [(before, 0)]  # before time passed, and before any request
            assert not sim.stats()["enabled"] and sim.stats()["stopped"]
            assert line.recv(100).startswith(b"stopped ")
            assert served  # they did flood
    for program in programs:
        program.close()


@pytest.mark.req("DRV-9")
def test_stop_is_latched_until_a_writers_enable(bench, program):
    assert program.call(WRITE, 0, struct.pack("<2i", 7, 7))[0] == 8
    with stop_line(bench) as line:
        line.sendall(b"stop\nstate\n")
        bench.server.step()
        stopped, state = line.recv(200).decode().splitlines()
        assert stopped.startswith("stopped ") and "enabled 0 stopped 1" in state
    assert program.call(WRITE, 0, struct.pack("<2i", 7, 7))[0] == -5
    assert program.call(IOCTL, mcdef.MENABLE)[0] == 0
    assert program.call(WRITE, 0, struct.pack("<2i", 7, 7))[0] == 8


@pytest.mark.req("DRV-9")
def test_a_stop_reaches_an_enable_that_waits(bench, program):
    """MENABLE waits for relay and first pass; the line is read meanwhile, and MENABLE fails."""
    assert program.call(IOCTL, mcdef.MSTOP)[0] == 0
    with stop_line(bench) as line:
        bench.server.step()
        program._send(program.channel, IOCTL, program.inode, mcdef.MENABLE, 0, b"")
        looks = []
        genuine = bench.server._listen

        def listen(wait):
            if bench.sim.run(bench.sim.time) is False:  # a request waits
                looks.append(bench.sim.time)
                if len(looks) == 3:
                    line.sendall(b"stop\n")
            genuine(wait)

        bench.server._listen = listen
        assert program._answer(program.channel)[0] == -5
        assert len(looks) > 3
        assert not bench.sim.stats()["enabled"]


@pytest.mark.req("PAN-1")
def test_the_button(bench, program):
    with stop_line(bench) as line:
        line.sendall(b"press\n")
        bench.server.step()
        assert line.recv(100).startswith(b"pressed ")
        assert bench.sim.stats()["panic_level"] == 1
        line.sendall(b"release\nsing\n")
        bench.server.step()
        answers = line.recv(200).decode().splitlines()
        assert answers[0].startswith("released ") and answers[1].startswith("what?")


def test_a_monitor_may_stop(bench, program):
    monitor = Raw(bench, os.O_RDONLY)
    assert monitor.call(IOCTL, mcdef.MENABLE)[0] == -9
    assert monitor.call(IOCTL, mcdef.MSTOP)[0] == 0
    assert not bench.sim.stats()["enabled"]
    monitor.close()


@pytest.mark.req("DRV-9")
def test_a_line_sent_before_its_connection_is_closed_still_stops(bench, program):
    """64 others come between the connection and its line, in the same step of the server."""
    with stop_line(bench) as line:
        bench.server.step()
        others = [stop_line(bench) for _ in range(64)]
        line.sendall(b"stop\n")
        bench.server.step()
        assert not bench.sim.stats()["enabled"]
        assert line.recv(100).startswith(b"stopped ")
    for sock in others:
        sock.close()
