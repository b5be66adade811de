# SPDX-License-Identifier: Apache-2.0
"""What goes into programmable logic is read by the synthesis tool, hierarchy and all."""

import sys

import pytest

from fpga import build
from tools.compiled import ran


@pytest.mark.slow  # some ten seconds
@pytest.mark.req("SW-1")
def test_all_tops_elaborate():
    done = ran(sys.executable, "fpga/build.py", "--elaborate")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("write", [False, True])
def test_the_page_is_written_only_when_asked(monkeypatch, tmp_path, write):
    monkeypatch.setattr(build, "OUT", tmp_path)
    asked = []
    monkeypatch.setattr(build, "committed", asked.append)
    monkeypatch.setattr(build, "need", lambda *tools: None)
    monkeypatch.setattr(build, "build", lambda target: "a row")
    page = tmp_path / "fpga.md"
    page.write_text("old")
    monkeypatch.setattr(build, "splice", lambda text, name, new: new)
    monkeypatch.setattr(build, "PAGE", page)
    monkeypatch.setattr(build, "table", lambda built: "new\n")
    monkeypatch.setattr(
        build.sys, "argv", ["build.py", build.TARGETS[0].name, *["--write"] * write]
    )
    assert build.main() == 0
    assert bool(asked) == write, "sources that are changed may be built, not put down"
    assert ("new" in page.read_text()) == write
