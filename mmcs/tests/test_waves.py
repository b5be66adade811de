# SPDX-License-Identifier: Apache-2.0
"""Traces: every signal of the prepared views exists in a real trace, with the width given."""

import re

import numpy as np
import pytest
import pywellen

from mmcs.errors import RunError
from mmcs.runs.machine import machine
from mmcs.runs.record import make_record, read_record, write_record
from mmcs.runs.replay import stretch
from mmcs.runs.replay import trace as trace_again
from mmcs.runs.report import make_report, write_report
from mmcs.runs.runner import simulate
from mmcs.runs.session import Session
from mmcs.scenario.load import load
from mmcs.view import watched, waves
from mmcs.view.moments import first_missed, first_pass, variables

SETS = ("duration=0.02", "motion.0.at=0.004", "expect=[]")


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trace")
    write_record(make_record(simulate(load("lab500", SETS)), "native"), folder)
    path = folder / "lab500.fst"
    assert trace_again(read_record(str(folder)), path, 0.004, 0.009) == (None, "")
    return path


def test_every_signal_of_the_view_is_in_the_trace(trace):
    widths = {var.full_name: var.length for var in pywellen.Waveform(str(trace)).all_vars()}
    wanted = [s for signals in waves.GROUPS.values() for s in signals]
    found = {s.path: widths.get(s.full()) for s in wanted}
    assert found == {s.path: s.width for s in wanted}


def test_the_pass_is_whole(trace):
    """SCLOCK, acknowledge within the latency, reads, then writes, all within one interval."""
    seen = first_pass(variables(trace), waves.MACHINE)
    us = [(time - seen.sclock) / 1e6 for time in seen]
    assert us[0] < us[1] < us[2] < us[3] < 1000 and us[1] < 130


PS_PER_CLK, BEFORE_CLKS = 125_000, 63  # a trace counts from the reset before power-on


def _watched() -> np.ndarray:
    """What the same run's nets do in a machine without traces."""
    setup = load("lab500", SETS)
    with machine(setup, skip=False) as sim:
        sim.watch(watched.nets())
        Session(sim, setup).run()
        return sim.changes()


def test_nets_watched_clock_by_clock_are_those_of_the_trace(trace):
    """Each net that a page draws: the same values at the same clocks, over 5 ms of motion."""
    traced = {var.full_name: var for var in pywellen.Waveform(str(trace)).all_vars()}
    sclock = traced[f"{waves.MACHINE}.sclock_o"].tv
    first, last = ([t for t, _ in sclock][n] // PS_PER_CLK - BEFORE_CLKS for n in (0, -1))
    changes = _watched()
    signals = [s for group, found in waves.GROUPS.items() if group != "firmware" for s in found]
    busy = 0
    for number, signal in enumerate(signals):
        mask = (1 << signal.width) - 1
        seen = [(int(c), int(v) & mask) for c, n, v in changes if n == number]
        kept = _settled(
            (t // PS_PER_CLK - BEFORE_CLKS, int(v)) for t, v in traced[signal.full()].tv
        )
        assert _from(seen, first, last) == _from(kept, first, last), signal.path
        busy += len(_from(seen, first, last)) > 2
    assert busy > 20


def _settled(values) -> list[tuple[int, int]]:
    """The last value of each clock."""
    return list(dict(values).items())


def _from(values: list[tuple[int, int]], first: int, last: int) -> list[tuple[int, int]]:
    """Changes after a clock up to another, behind the value that it began with."""
    before = [(first, v) for c, v in values if c <= first][-1:]
    made = [*before, *((c, v) for c, v in values if first < c <= last)]
    return [made[0], *(b for a, b in zip(made, made[1:], strict=False) if a[1] != b[1])]


def test_a_machine_that_skips_has_nothing_to_watch():
    setup = load("lab500", SETS)
    with machine(setup, skip=True) as sim, pytest.raises(RunError, match="sees? each clock"):
        sim.watch(watched.nets()[:1])
    with machine(setup, skip=False) as sim:
        for name in ("u_adaptor.nobody_o", f"{waves.CARD}.pc_a_i", "", "."):
            with pytest.raises(RunError, match="no register or port"):
                sim.watch([name])
        assert sim.notes() == []


def test_a_missed_sclock_is_found_by_its_kind_and_marked(tmp_path):
    """A host that takes no interrupt for 8 ms: SCLOCKs come while the latch is set."""
    stall = 'event=[{at=0.005, input="host_stall", value=8}]'
    result = simulate(load("lab500", (*SETS, stall)))
    missed = [note for note in result.notes if note["kind"] == "missed"]
    count = result.stats["missed"]
    assert count and [note["text"] for note in missed] == [f"{count} SCLOCKs never served"]
    write_record(make_record(result, "native"), tmp_path)
    write_report(make_report(result, "native"), tmp_path)
    record = read_record(str(tmp_path))
    begin, end = stretch(record, "missed", 5)
    assert begin < missed[0]["t"] < end
    wave = tmp_path / "missed.fst"
    assert trace_again(record, wave, begin, end)[0] is None
    at = first_missed(variables(wave), waves.MACHINE)
    assert at is not None
    gtkw, _ = waves.write_views(wave)
    text = gtkw.read_text()
    assert f" {at} -1" in text
    assert "\n-A SCLOCK, B acknowledge, C first read, D last D/A write, E missed, F PANIC\n" in text
    assert 0 < at - opens_at(text) < 2_000_000_000


def opens_at(view: str) -> int:
    return int(re.search(r"^\[timestart\] (\d+)$", view, re.M)[1])
