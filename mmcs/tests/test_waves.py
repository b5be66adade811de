# SPDX-License-Identifier: Apache-2.0
"""Traces: every signal of the prepared views exists in a real trace, with the width given."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from mmcs import ROOT, regs
from mmcs.view import waves
from mmcs.view.moments import first_pass
from mmcs.view.names import registers

sys.path.insert(0, str(ROOT / "tools"))
import screenshot  # noqa: E402


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    from mmcs.run.runner import simulate
    from mmcs.scenario.load import load

    path = tmp_path_factory.mktemp("trace") / "lab500.fst"
    sets = ("duration=0.02", "motion.0.at=0.004", "expect=[]")
    simulate(load("lab500", sets), trace=path, stretch=(0.004, 0.009))
    return path


def test_every_signal_of_the_view_is_in_the_trace(trace):
    import pywellen

    widths = {var.full_name: var.length for var in pywellen.Waveform(str(trace)).all_vars()}
    wanted = [s for signals in waves.GROUPS.values() for s in signals]
    found = {s.path: widths.get(s.full()) for s in wanted}
    assert found == {s.path: s.width for s in wanted}


def test_views_are_beside_the_trace(trace):
    gtkw, sucl = waves.write_views(trace)
    text = gtkw.read_text()
    assert text.startswith(f'[dumpfile] "{trace}"')
    for group, signals in waves.GROUPS.items():
        assert text.count(f"-{group}\n") == 2
        assert f"divider_add {group}\n" in sucl.read_text()
        for signal in signals:
            assert f"{signal.gtkwave()}\n" in text
    assert len(re.findall(r"^@800200$", text, flags=re.M)) == len(waves.GROUPS)
    for table in re.findall(r"^\^\d (.*)$", text, flags=re.M):
        assert Path(table).read_text()


def test_the_pass_is_whole(trace):
    """SCLOCK, acknowledge within the latency, reads, then writes, all within one interval."""
    seen = first_pass(trace, waves.MACHINE)
    us = [(time - seen.sclock) / 1e6 for time in seen]
    assert us[0] < us[1] < us[2] < us[3] < 1000 and us[1] < 130


def test_a_window_is_traced_not_the_run(trace):
    import pywellen

    clock = next(v for v in pywellen.Waveform(str(trace)).all_vars() if v.name == "sclock_o")
    times = [time for time, _ in clock.tv]
    assert times[-1] - times[0] < 5.1e9  # ps


def test_registers_by_address():
    names = registers()
    assert names[regs.WINDOW_BASE + regs.PCCSR >> 1] == "PCCSR"
    assert names[regs.WINDOW_BASE + regs.card_offset(2, regs.CARD_DAC2_HI) >> 1] == "2:DAC2_HI"
    assert len(names) == 6 + 16 * 17


@pytest.mark.skipif(bool(screenshot.missing()), reason=f"{screenshot.missing()} missing: apt-get")
def test_gtkwave_shows_the_pass(trace, tmp_path):
    """All four markers are on its screen, far apart, and many nets move between them."""
    gtkw, _ = waves.write_views(trace)
    marks, busy = _seen(trace, gtkw)
    assert len(marks) == 4 and marks[-1] - marks[0] > 300 and busy > 100
    flat = tmp_path / "flat.gtkw"
    flat.write_text(re.sub(r"^(\*|\[timestart\]).*\n", "", gtkw.read_text(), flags=re.M))
    marks, busy = _seen(trace, flat)
    assert not marks and busy < 60


def _seen(trace, gtkw):
    """Columns of the markers, and how many different columns the screen has."""
    image = np.asarray(screenshot.shoot(trace, gtkw)).astype(int)[110:, 460:1580]
    red, green, blue = image[..., 0], image[..., 1], image[..., 2]
    yellow = ((red > 180) & (green > 180) & (blue < 140)).sum(axis=0) > image.shape[0] // 4
    first = ((red > 180) & (green < 140)).sum(axis=0) > image.shape[0] // 4  # the first is red
    columns = np.flatnonzero(yellow | first)
    marks = [c for n, c in enumerate(columns) if n == 0 or c > columns[n - 1] + 2]
    nets = (green > 150) & (red < 80)
    return marks, len(np.unique(nets, axis=1).T)  # columns that differ: something moves


def test_without_display_the_commands_are_printed(tmp_path, monkeypatch, capsys):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    waves.open_viewer(tmp_path / "run.fst")
    out = capsys.readouterr().out
    assert f"gtkwave {tmp_path}/run.fst {tmp_path}/run.gtkw" in out
    assert f"surfer -c {tmp_path}/run.sucl {tmp_path}/run.fst" in out
