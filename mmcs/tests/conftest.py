# SPDX-License-Identifier: Apache-2.0
"""Fixtures: the command as a user calls it, scenario files, a server to do things to."""

import re
import signal

import pytest
from click.testing import CliRunner

from mmcs import ROOT
from mmcs.cli.app import main
from mmcs.device.sockets import socket_path
from mmcs.runs.session import Session
from mmcs.tests.device_bench import Bench, running

GOOD = """
description = "a test"
robot = "lab500"
cards = 1
duration = 0.3

[[motion]]
axis = 0
kind = "step"
at = 0.05
to = 200
"""


def call(*args):
    """The command's (status, stdout, stderr)."""
    result = CliRunner().invoke(main, [str(a) for a in args])
    return result.exit_code, result.stdout, result.stderr


def good(answer, silent=False):
    """What the command says that did what was asked; silent: and nothing on stderr."""
    status, out, err = answer
    assert status == 0 and not (silent and err), (status, out, err)
    return out


def cluster(workers):
    """A scheduler of Dask with workers of one thread each."""
    distributed = pytest.importorskip("distributed")
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
        silence_logs=50,
    )  # fmt: skip


def one_clear_line(answer, *words, start="", status=2, begun=False):
    """What was asked ends in one line: from `start` on, if that is told, and with these words.
    begun: it has said something before."""
    got, out, err = answer
    assert got == status and (begun or not out), (out, err)
    assert err.startswith(f"mmcs: {start}") and err.count("\n") == 1 and err.endswith("\n"), err
    assert "Traceback" not in err and err[:-1].isprintable(), err
    for word in words:
        assert word in err, err


def put(text, line):
    """The text with a line in place of that of the same key, or one line more."""
    made, found = re.subn(rf"^{line.partition(' ')[0]} = .*", lambda _: line, text, flags=re.M)
    return made if found else f"{text}{line}\n"


@pytest.fixture
def mmcs(monkeypatch):
    """call(), at the top of the checkout."""
    monkeypatch.chdir(ROOT)
    return call


@pytest.fixture
def scenario(tmp_path):
    """Writes a scenario file and gives its path."""

    def write(text=GOOD, name="test.toml"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


class _Altered:
    """A Sim with some answers of its own."""

    def __init__(self, sim, answers):
        self.__dict__ |= {"sim": sim} | answers

    def __getattr__(self, name):
        return getattr(self.sim, name)


@pytest.fixture
def answers(monkeypatch):
    """What the machine of a run answers otherwise: functions by the names of Sim's."""
    own, begin = {}, Session.__init__
    altered = lambda self, sim, *a, **k: begin(self, _Altered(sim, own), *a, **k)  # noqa: E731
    monkeypatch.setattr(Session, "__init__", altered)
    return own


@pytest.fixture
def unsignalled():
    """This process is a program of the server: it ignores SIGUSR1."""
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGUSR1, before)


@pytest.fixture
def bench(tmp_path):
    """A server that the test steps."""
    with Bench(tmp_path) as made:
        yield made


@pytest.fixture
def serving(unsignalled, bench, monkeypatch):
    """The same server, running in a thread."""
    monkeypatch.setenv("MMCS_SOCKET", str(bench.server.path))
    with running(bench.server):
        yield bench


@pytest.fixture
def mc0(tmp_path, monkeypatch):
    """The path of the socket of mc0, in a folder of the test's own."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return socket_path("mc0")
