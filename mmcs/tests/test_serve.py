# SPDX-License-Identifier: Apache-2.0
"""The server itself: its socket, its name, its death."""

import os
import signal
import socket
import subprocess
import sys

import pytest

from mmcs import ROOT
from mmcs.device import server as serve
from mmcs.device.execute import environment
from mmcs.device.server import listen, socket_path
from mmcs.errors import InputError
from mmcs.tests.device_bench import SANITIZED, Bench, write_scenario


def test_socket_is_private_and_the_name_taken_once(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    path = socket_path("mc0")
    first = listen(path)
    assert path.stat().st_mode & 0o777 == 0o600
    with pytest.raises(InputError, match="a server of this name is running"):
        listen(path)
    first.close()
    listen(path).close()  # what a dead server left is taken over


def test_open_directory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    (tmp_path / f"mmcs-{os.getuid()}").mkdir(mode=0o755)
    with pytest.raises(InputError, match="not yours alone"):
        listen(socket_path("mc0"))


def test_rubbish_is_hung_up(tmp_path):
    with Bench(tmp_path) as bench, socket.socket(socket.AF_UNIX) as rude:
        rude.connect(str(bench.server.path))
        rude.sendall(b"GET / HTTP/1.0\r\n" + b"x" * 100)
        for _ in range(5):
            bench.server.step()
        assert rude.recv(10) == b""
        assert len(bench.server.selector.get_map()) == 1


class Clock:
    """A clock on the wall that only the test moves."""

    now = 1000.0

    def monotonic(self):
        return self.now


@pytest.mark.req("DRV-9")
def test_real_time_and_standstill(tmp_path, monkeypatch):
    clock = Clock()
    monkeypatch.setattr(serve, "time", clock)
    with Bench(tmp_path, speed=0.5) as bench:
        clock.now += 10
        bench.server.step()
        assert bench.sim.time == 0  # nobody holds the device
        bench.python("import os; os.open('/dev/mc0', 2); input()")
        bench.until(lambda: bench.server.files)
        began, simulated = clock.now, bench.sim.time
        for _ in range(40):
            clock.now += 0.01
            for _ in range(8):
                bench.server.step()
            due = 0.5 * (clock.now - began)
            assert due <= bench.sim.time - simulated <= due + 1.001 * serve.CHUNK_MAX_S
        clock.now += 60  # somebody stopped the server: the minute is not run after
        simulated = bench.sim.time
        for _ in range(8):
            bench.server.step()
        assert bench.sim.time - simulated <= 1.001 * serve.CHUNK_MAX_S


@pytest.mark.req("DRV-3")
def test_killed_server_gives_eio(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    command = [sys.executable, "-m", "mmcs", "serve", str(write_scenario(tmp_path))]
    text = """
import os
fd = os.open("/dev/mc0", os.O_RDWR)
print("open", flush=True)
try:
    while os.read(fd, 56): pass
except OSError as error:
    print(error.errno, flush=True)
"""
    for _ in range(2):  # the second takes over the socket that the first one left
        server = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        client = None
        try:
            assert "serving" in server.stdout.readline()
            env = environment(socket_path("mc0"), SANITIZED)
            client = subprocess.Popen(
                [sys.executable, "-c", text], env=env, stdout=subprocess.PIPE, text=True
            )
            assert client.stdout.readline() == "open\n"
            server.send_signal(signal.SIGKILL)
            assert client.communicate()[0] == "5\n"
        finally:  # a failure above must not leave anything to wait for
            for process in filter(None, (server, client)):
                process.kill()
                process.wait()
                process.stdout.close()
