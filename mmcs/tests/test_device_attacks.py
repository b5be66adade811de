# SPDX-License-Identifier: Apache-2.0
"""What nobody should do to the server, and what an impostor does to a program."""

import itertools
import os
import resource
import select
import signal
import socket
import struct
from pathlib import Path

import pytest

from mmcs import mcdef
from mmcs.device import sockets, wire
from mmcs.device.client import Device
from mmcs.device.link import Link
from mmcs.tests.device_bench import Bench, all_are_free, descriptors
from mmcs.tests.raw import Asker, Raw, stop_line

pytestmark = pytest.mark.usefixtures("unsignalled")


def is_well(bench):
    program = Raw(bench)
    assert program.call(wire.IOCTL, mcdef.MGETNUMCARDS) == (0, b"\1\0\0\0")
    program.close()
    bench.until(lambda: not bench.server.connections)
    assert not bench.server.files
    assert bench.server.machine.request(None, {"op": "clients"}) == {"clients": []}
    assert all_are_free(bench.sim)


# --- the server ---


@pytest.mark.parametrize("op", [*range(0, 14), 1 << 31])
def test_no_request_is_too_odd(attacked, op):
    """Of every kind and length, for a file that is there and one that is not."""
    bench, program, vme = attacked
    targets = [
        (program, mcdef.MGETPARAM, 0), (program, (1 << 64) - 1, (1 << 64) - 1),
        (vme, 0x6409, 1), (vme, 0x6409, 2), (vme, 0x6409, 8), (vme, 1 << 63, 1),
    ]  # fmt: skip
    for size in (0, 1, 3, 4, 5, 8, 300, 65536):
        for target, a, b in targets:
            for file in (0, 1, target.inode):
                program._send(program.channel, op, file, a, b, b"\x7f" * size)
                program._answer(program.channel)  # there is one, whatever it is


@pytest.fixture(scope="module")
def attacked(tmp_path_factory):
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    with Bench(tmp_path_factory.mktemp("attacked")) as bench:
        program, vme = Raw(bench), Raw(bench, device=b"/dev/vme16")
        yield bench, program, vme
        program.close()
        vme.close()
        bench.until(lambda: not bench.server.connections)
        is_well(bench)
    signal.signal(signal.SIGUSR1, before)


def test_a_file_is_opened_once_and_has_an_inode(bench):
    program = Raw(bench)
    for inode, answer in ((0, -22), (program.inode, -22), (1, 0)):
        program._send(program.channel, wire.OPEN, inode, 2, 0, b"/dev/mc0")
        assert program._answer(program.channel)[0] == answer
    twice = program._connect()
    message = wire.REQUEST.pack(wire.MAGIC, wire.OPEN, 3, 2, 0, 8, os.getpid()) + b"/dev/mc0"
    twice.sendall(message)
    twice.sendall(message)
    assert program._answer(twice)[0] == 0
    assert bench.server.machine.now.opens == 3
    twice.close()
    program.close()
    is_well(bench)


def test_more_connections_than_are_served(bench):
    bench.server.most = 20
    many = []
    for _ in range(60):
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        sock.connect(str(bench.server.path))
        many.append(sock)
        bench.server.step()
    assert len(bench.server.connections) == 20
    for sock in many:
        sock.close()
    bench.until(lambda: not bench.server.connections)
    is_well(bench)


def test_no_descriptor_is_left(bench):
    """Whoever connects then is turned away; the server and the stop path live."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    many = [socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(40)]
    with stop_line(bench) as line:
        bench.server.step()
        for sock in many:
            sock.connect(str(bench.server.path))
        highest = max(map(int, os.listdir("/proc/self/fd")))
        spare = [os.dup(0) for _ in range(highest + 2 - descriptors())]
        resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors(), hard))
        try:
            for _ in range(10):
                bench.server.step()
            line.sendall(b"stop\n")
            bench.server.step()
            assert line.recv(100).startswith(b"stopped")
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
            for fd in spare:
                os.close(fd)
    for sock in many:
        sock.close()
    bench.until(lambda: not bench.server.connections)
    is_well(bench)


@pytest.mark.parametrize("why", ["interval", "vector"])
def test_an_end_comes_through_a_request_that_waits(bench, why):
    """MENABLE would wait for its first SCLOCK, 536 s away; or for one that nobody understands."""
    program = Raw(bench)
    if why == "interval":
        assert program.call(wire.IOCTL, mcdef.MSETINTERVAL, struct.pack("<I", 536_000_000))[0] == 0
    else:
        vme = Raw(bench, device=b"/dev/vme16")
        assert vme.call(wire.STORE, 0x6441, b"\x55", b=1)[0] == wire.BUS_OK
        vme.close()
    looks, genuine = [], bench.server._listen

    def listen(wait):
        looks.append(bench.sim.time)
        if len(looks) == 10:
            bench.server.stopping = True  # as SIGTERM does
        genuine(wait)

    before = bench.sim.time
    bench.server._listen = listen
    assert program.call(wire.IOCTL, mcdef.MENABLE)[0] == -5
    assert bench.sim.time - before < 0.1
    bench.server._listen, bench.server.stopping = genuine, False
    program.close()


def test_others_are_served_while_one_enables(bench):
    program, other = Raw(bench), Raw(bench)
    program._send(program.channel, wire.IOCTL, program.inode, mcdef.MENABLE, 0, b"")
    other._send(other.channel, wire.READ, other.inode, 56, 0, b"")
    answered = []
    genuine = bench.server._look

    def look():
        result = genuine()
        answered.append(bool(select.select([other.channel], [], [], 0)[0]))
        return result

    bench.sim.set_look(look)
    assert program._answer(program.channel)[0] == 0
    assert answered[-1]
    for raw in (program, other):
        raw.close()


# --- errors of our own ---


def close(client, bench):
    client.sock.close()
    bench.until(lambda: not bench.server.connections)


def test_a_deep_message_ends_nothing(bench):
    """So deep that Python just reads it, or cannot write it, or cannot read it."""
    places = ("id", "op", "request", "param", "setpoints", "flag")
    for where, depth in itertools.product(places, (100, 800, 900, 980)):
        deep = "[" * depth + "]" * depth
        op = {"setpoints": "write", "flag": "follow"}.get(where, "call")
        fields = {"id": "1", "op": f'"{op}"', "request": '"MSETPARAM"', "axis": "0", where: deep}
        fields["samples"] = fields.pop("flag", "true")
        client = Asker(bench.server)
        client.post({"id": 0, "op": "open", "mode": "rw"})
        assert client.reply()["ok"]
        client.post("{" + ",".join(f'"{name}":{value}' for name, value in fields.items()) + "}")
        if client.heard(lambda told: b'"ok":false,"errno":22' in told):
            client.post({"id": 2, "op": "read"})
            assert client.reply()["ok"]
        else:
            assert depth > 800  # no JSON, as Python sees it
        close(client, bench)
    is_well(bench)


@pytest.mark.parametrize("waits", [False, True])
@pytest.mark.parametrize("of", ["message", "program", "stream", "end"])
def test_an_error_of_the_server_ends_one_connection(bench, monkeypatch, of, waits):
    """Whatever goes wrong in serving a client, also while another one's request waits: this client
    is told and hung up on, the console has a line, others are served."""
    said, client, program = [], Asker(bench.server), Raw(bench)
    assert client.heard(lambda told: b"hello" in told)
    monkeypatch.setattr(bench.server, "say", said.append)
    fault = lambda *_: 1 // 0  # noqa: E731
    if of == "program":
        monkeypatch.setattr(bench.server.machine, "ioctl", fault)
        program._send(program.channel, wire.IOCTL, program.inode, mcdef.MSTATUS, 0, b"")
    elif of == "message":
        monkeypatch.setattr("mmcs.device.messages.Messenger.do_hello", fault)
        client.post({"op": "hello"})
    elif of == "stream":
        monkeypatch.setattr(bench.server.machine, "stream", fault)
        client.post({"op": "follow", "period_ms": 0})
    else:
        monkeypatch.setattr("mmcs.device.messages.Messenger.leave", fault)
        client.sock.close()
    if waits:
        for _ in range(3):
            assert bench.server._look() == 0
    for _ in range(6):
        bench.server.step()
    monkeypatch.undo()
    assert len(said) == 1 and "ZeroDivisionError" in said[0] and "test_device_attacks.py" in said[0]
    if of == "program":
        assert program._answer(program.channel)[0] == -wire.EIO
        program.channel = program._connect()
    elif of != "end":
        assert b"ZeroDivisionError" in client.heard(lambda told: b'"error":"EIO"' in told)
        assert not client.heard(lambda told: True)
    assert program.call(wire.IOCTL, mcdef.MGETNUMCARDS) == (0, b"\1\0\0\0")
    program.close()
    close(client, bench)
    if of != "end":
        is_well(bench)


@pytest.mark.parametrize("why", ["a folder", "a full disk"])
def test_an_export_that_cannot_be_written_is_refused(serving, why, monkeypatch):
    """Nothing that is half is left, and what was there before stands."""
    past = serving.server.path.with_suffix(".past")

    def write_half(path, data):
        path.open("wb").write(data[:100])
        raise OSError(28, "No space left on device")

    if why == "a folder":
        past.mkdir()
    else:
        past.write_text("before")
        monkeypatch.setattr(Path, "write_bytes", write_half)
    with Link(path=serving.server.path, timeout=None) as link:
        link.request("open", mode="rw")
        number = link.request("snapshot")["snapshot"]["id"]
        with pytest.raises(OSError, match="Is a directory|No space left") as no:
            link.request("export", snapshot=number)
        assert no.value.errno in (21, 28)
        assert past.is_dir() or past.read_text() == "before"
        assert not list(past.parent.glob(".*.past"))
        with pytest.raises(OSError, match="there is none of this number") as no:
            link.request("export", snapshot=number + 1_000_000)
        assert no.value.errno == 22
        assert link.request("read")["ok"]


# --- impostors ---


def test_a_socket_of_another_user_is_not_used(serving, monkeypatch):
    monkeypatch.setattr(sockets.os, "geteuid", lambda: 4711)
    for use in (Device, lambda: Link(path=serving.server.path, timeout=None)):
        with pytest.raises(OSError, match="serves this socket, not you"):
            use()
