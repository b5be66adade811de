# SPDX-License-Identifier: Apache-2.0
"""Fixtures: the command as a user calls it, scenario files, a server to do things to."""

import re
import signal
import threading

import pytest
from click.testing import CliRunner

from mmcs import ROOT
from mmcs.cli.app import main
from mmcs.lab.sheets import LABS
from mmcs.tests.device_bench import Bench

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


@pytest.fixture
def bench(tmp_path):
    """A server that the test steps; programs are this process, so SIGUSR1 is ignored."""
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    with Bench(tmp_path) as made:
        yield made
    signal.signal(signal.SIGUSR1, before)


@pytest.fixture
def serving(bench, monkeypatch):
    """The same server, running in a thread."""
    thread = threading.Thread(target=bench.server.run)
    monkeypatch.setenv("MMCS_SOCKET", str(bench.server.path))
    thread.start()
    yield bench
    bench.server.stopping = True
    thread.join()


@pytest.fixture
def own_sheets(tmp_path):
    """The sheet of a teacher's own that the book shows."""
    folder = tmp_path / "sheets" / "01_gain"
    folder.mkdir(parents=True)
    page = (LABS / "README.md").read_text()
    for name, body in re.findall(r"^```\w+ (\w+\.\w+)\n(.*?)^```", page, re.M | re.S):
        (folder / name).write_text(body)
    (folder / "sheet.md").write_text("# A gain\n")
    return tmp_path / "sheets"
