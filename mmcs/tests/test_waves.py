# SPDX-License-Identifier: Apache-2.0
"""Traces: every signal of the prepared views exists in a real trace, with the width given."""

import re

import pytest

from mmcs.view import waves


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    from mmcs.run.runner import simulate
    from mmcs.scenario.load import load

    path = tmp_path_factory.mktemp("trace") / "lab500.fst"
    simulate(load("lab500", ("duration=0.02", "motion=[]", "expect=[]")), trace=path)
    return path


def test_every_signal_of_the_view_is_in_the_trace(trace):
    import pywellen

    widths = {var.full_name: var.length for var in pywellen.Waveform(str(trace)).all_vars()}
    wanted = [s for signals in waves.GROUPS.values() for s in signals]
    found = {s.path: widths.get(s.full()) for s in wanted}
    assert found == {s.path: s.width for s in wanted}


def test_views_are_beside_the_trace(tmp_path):
    gtkw, sucl = waves.write_views(tmp_path / "run.fst")
    text = gtkw.read_text()
    assert text.startswith(f'[dumpfile] "{tmp_path}/run.fst"')
    for group, signals in waves.GROUPS.items():
        assert text.count(f"-{group}\n") == 2
        assert f"divider_add {group}\n" in sucl.read_text()
        for signal in signals:
            assert f"{signal.gtkwave()}\n" in text
    assert len(re.findall(r"^@800200$", text, flags=re.M)) == len(waves.GROUPS)


def test_without_display_the_commands_are_printed(tmp_path, monkeypatch, capsys):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    waves.open_viewer(tmp_path / "run.fst")
    out = capsys.readouterr().out
    assert f"gtkwave {tmp_path}/run.fst {tmp_path}/run.gtkw" in out
    assert f"surfer -c {tmp_path}/run.sucl {tmp_path}/run.fst" in out
