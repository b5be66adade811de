# SPDX-License-Identifier: Apache-2.0
"""The server itself: its socket, its name, its death."""

import socket

import pytest

from mmcs import mcdef
from mmcs.device import server
from mmcs.device.sockets import Name
from mmcs.device.wire import IOCTL
from mmcs.errors import InputError
from mmcs.tests.device_bench import Bench, Clock
from mmcs.tests.raw import Raw


def test_socket_is_private_and_the_name_taken_once(mc0):
    mc0 = mc0.parent / "there" / mc0.name  # neither is the folder above it
    first = Name(mc0)
    first.listen(".sock")
    assert mc0.stat().st_mode & 0o777 == 0o600
    with pytest.raises(InputError, match="a server of this name is running"):
        Name(mc0)
    first.release()
    assert not mc0.exists()


def test_what_a_dead_server_left_is_taken_over_and_nothing_else(mc0):
    name = Name(mc0)
    socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET).bind(str(mc0))
    name.listen(".sock").close()
    name.release()
    mc0.write_text("somebody's work")
    name = Name(mc0)
    with pytest.raises(InputError, match="is not a socket"):
        name.listen(".sock")
    assert mc0.read_text() == "somebody's work"
    name.release()


@pytest.mark.parametrize("make", ["755", "750", "701", "link", "file"])
def test_a_folder_that_is_not_ours_alone_is_refused(tmp_path, mc0, make):
    folder = mc0.parent
    if make.isdigit():
        folder.mkdir(mode=int(make, 8))
    elif make == "link":
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        folder.symlink_to(tmp_path / "elsewhere")
    else:
        folder.write_text("")
    with pytest.raises(InputError, match="not yours alone|not a folder"):
        Name(mc0)


@pytest.mark.req("DRV-9")
def test_real_time_and_standstill(tmp_path, monkeypatch):
    clock = Clock()
    monkeypatch.setattr(server, "time", clock)
    with Bench(tmp_path, speed=0.5) as bench:
        clock.now += 10
        bench.server.step()
        assert bench.sim.time <= 1.001 * server.CHUNK_MAX_S  # those ten seconds are not run after
        bench.python("import os; os.open('/dev/mc0', 2); input()")
        bench.until(lambda: bench.server.files)
        began, simulated = clock.now, bench.sim.time
        for _ in range(40):
            clock.now += 0.01
            for _ in range(8):
                bench.server.step()
            due = 0.5 * (clock.now - began)
            assert due <= bench.sim.time - simulated <= due + 1.001 * server.CHUNK_MAX_S
        clock.now += 60  # somebody stopped the server: the minute is not run after
        simulated = bench.sim.time
        for _ in range(8):
            bench.server.step()
        assert bench.sim.time - simulated <= 1.001 * server.CHUNK_MAX_S


def test_enable_in_a_paused_machine_says_what_it_waits_for(bench, monkeypatch):
    """Once, after a second."""
    clock, said, program = Clock(), [], Raw(bench)
    monkeypatch.setattr(server, "time", clock)
    monkeypatch.setattr(bench.server, "say", said.append)
    bench.server.machine.now.paused, began = True, bench.sim.time
    program._send(program.channel, IOCTL, program.inode, mcdef.MENABLE, 0, b"")
    for passes, lines in ((0, 0), (0.9, 0), (0.2, 1), (5, 1)):
        clock.now += passes
        for _ in range(2):
            bench.server.step()
        assert len(said) == lines and bench.sim.time == began
    assert "MENABLE waits: the machine is paused" in said[0]
    bench.server.machine.now.paused = False
    assert program._answer(program.channel) == (0, b"") and bench.sim.stats()["enabled"]
    program.close()
