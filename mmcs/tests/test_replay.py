# SPDX-License-Identifier: Apache-2.0
"""Time travel for the user: records, replays, waveforms afterwards."""

import base64
import json
import re
import shutil
import zlib
from collections import defaultdict

import numpy as np
import pytest

from mmcs.runs import record as records
from mmcs.runs.record import NAME
from mmcs.scenario.load import load
from mmcs.tests.conftest import GOOD, call, good, one_clear_line

EVENT = """
[[event]]
at = 0.12
input = "estop"
value = 1
until = 0.2

[[call]]
at = 0.22
request = "MENABLE"

[[expect]]
kind = "event"
event = "panic"
"""
TABLE = '\n[[motion]]\naxis = 0\nkind = "table"\nat = 0.25\nduration = 0.03\nfile = "way.csv"\n'


def hash_of(text):
    return re.search(r"hash (0x[0-9a-f]{16})", text)[1]


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """A run with an event, a call and a table; the scenario is gone afterwards."""
    folder, out = tmp_path_factory.mktemp("scenario"), tmp_path_factory.mktemp("results")
    path = folder / "test.toml"
    path.write_text(GOOD + EVENT + TABLE)
    (folder / "way.csv").write_text("200\n210\n200\n")
    args = ["run", path, "--out", out, "--seed", 3]
    said = good(call(*args))
    shutil.rmtree(folder)
    return out, hash_of(said)


@pytest.fixture
def ran(original, tmp_path):
    """A copy of that run's folder, and its hash."""
    out = tmp_path / "results"
    shutil.copytree(original[0], out)
    return out, original[1]


def edit(folder, change):
    """Changes the scenario inside a record."""
    file = folder / NAME
    text = json.loads(file.read_text())
    change(text)
    file.write_text(json.dumps(text))


# --- records -----------------------------------------------------------------------------------


@pytest.mark.req("API-1")
def test_record_alone_reproduces_the_run(mmcs, ran, tmp_path):
    out, digest = ran
    assert (out / NAME).stat().st_size < 12_000
    alone = tmp_path / "elsewhere.mmcs"
    alone.write_bytes((out / NAME).read_bytes())
    for name in (out, out / NAME, alone):
        said = good(mmcs("replay", name), silent=True)
        assert f"reproduced, hash {digest}" in said and "build" not in said
    edit(out, lambda text: text.update(build="c1 0123456789abcdef"))
    said = good(mmcs("replay", out), silent=True)
    assert f"hash {digest}" in said and "recorded by build c1 0123456789abcdef" in said


@pytest.mark.req("API-1")
def test_replay_tells_where_it_first_differs(mmcs, ran):
    """The setpoint of one table changes by one count at 0.25 s."""
    out, digest = ran

    def other_way(text):
        files = json.loads(zlib.decompress(base64.b64decode(text["files"])))
        name = next(n for n in files if n.startswith("table"))
        files[name] = "200\n213\n200\n"
        text["files"] = base64.b64encode(zlib.compress(json.dumps(files).encode())).decode()
        text["version"], text["build"] = "0.0.9", "c1 0123456789abcdef"

    edit(out, other_way)
    status, text, _ = mmcs("replay", out)
    assert status == 1
    assert "differs, hash 0x" in text and f"instead of {digest}" in text
    assert "recorded by version 0.0.9" in text
    assert "recorded by build c1 0123456789abcdef, this is c1 " in text
    first, last = map(int, re.search(r"first at servo samples (\d+) to (\d+)", text).groups())
    log = np.loadtxt(out / "log.csv", delimiter=",", skiprows=1)
    sample = int(np.flatnonzero(log[:, 0] > 0.25)[0])
    assert last - first < 64 and first - 5 < sample <= last  # a few came before the motion


@pytest.mark.req("API-1")
def test_difference_that_no_sample_shows(ran):
    """The console of the driver costs no time; a later bus timer shows in the bus cycles alone."""
    record = records.read_record(str(ran[0]))
    points = record.points
    assert len(points) >= 5
    bent = [(*p[:3], p[3] ^ (n >= 2)) for n, p in enumerate(points)]
    where = records.first_difference(record, bent)
    assert where.startswith(f"between servo samples {points[1][0]} and {points[2][0]}")
    assert "bus cycles" in where
    assert records.first_difference(record, points) is None
    assert records.first_difference(record, points[:3]).endswith("never comes")


# --- waveforms afterwards ----------------------------------------------------------------------


FAULTS = """
[[event]]
at = 0.01
input = "seu_index_latch"
value = 1

[[event]]
at = 0.02
input = "irq_lost"
value = 1
until = 0.046

[[event]]
at = 0.02
input = "adc_stuck"
value = 1

[[event]]
at = 0.0455
input = "dac_stuck1"
value = 8
"""


def seen(path, begin_ps, end_ps):
    """Of every signal: the value when the stretch begins, and every change in it."""
    import pywellen

    before, inside = {}, defaultdict(list)

    def change(t, net, value):  # of any net, in the order of time
        if t <= begin_ps:
            before[str(net)] = value
        elif t <= end_ps:
            inside[str(net)].append((t, value))

    wave = pywellen.Waveform(str(path))
    wave.stream_changes(change, None)
    nets = {var.full_name.removeprefix("TOP.mmcs."): str(var.signal_id) for var in wave.all_vars()}
    return {name: (before.get(net), inside[net]) for name, net in nets.items()}


@pytest.mark.req("API-1")
def test_stretch_equals_the_same_stretch_of_a_traced_run(mmcs, scenario, tmp_path):
    """Begun behind an upset, with one fault standing, one that ends and one
    that begins in the stretch; what bus checkers remember is no part of the machine."""
    path = scenario(GOOD.split("[[expect]]")[0].replace("at = 0.05", "at = 0.002") + FAULTS)
    out, full, part = tmp_path / "out", tmp_path / "full.fst", tmp_path / "part.fst"
    _, text, err = mmcs("run", path, "--duration", 0.05, "--out", out, "--trace", full)
    assert "trace" in text, text + err
    good(mmcs("trace", out, "--at", 0.046, "--window", 3, "--out", part))
    nowhere = tmp_path / "no" / "x.fst"
    answer = mmcs("trace", out, "--at", 0.046, "--out", nowhere)
    one_clear_line(answer, start=f"{nowhere}: its folder does not exist\n")
    start_s = json.loads((out / "report.json").read_text())["motion_start_s"]
    # A few clocks inside the stretch, so that both files hold it.
    begin, end = ((start_s + t) * 1e12 + 8e6 for t in (0.04451, 0.04749))
    ours, theirs = seen(part, begin, end), seen(full, begin, end)
    differ = {name for name in theirs if ours.get(name) != theirs[name]}
    assert all(re.match(r"u_\w+_checker[.]", name) for name in differ), differ
    assert len(theirs) > 1000 and sum(len(inside) > 3 for _, inside in ours.values()) > 200
    assert part.stat().st_size < full.stat().st_size


@pytest.mark.req("API-1")
def test_stretch_before_the_motion_begins_at_power_on(mmcs, ran, tmp_path):
    out, digest = ran
    wave = tmp_path / "w.fst"
    text = good(mmcs("trace", out, "--at", -0.0005, "--window", 1, "--out", wave))
    assert f"the same hash, {digest}" in text and wave.stat().st_size > 10_000


@pytest.mark.req("API-1")
def test_trace_around_an_event_of_the_report(mmcs, ran, tmp_path):
    out, digest = ran
    text = good(mmcs("trace", out, "--at", "fault", "--window", 1))
    assert f"the same hash, {digest}" in text
    wave = next(out.glob("test_0.12*.fst"))
    assert wave.with_suffix(".gtkw").exists() and wave.stat().st_size > 10_000
    stretch = re.search(r"([\d.]+) to ([\d.]+) s of motion", text)
    assert float(stretch[1]) < 0.12 < float(stretch[2])


@pytest.mark.req("API-1")
def test_trace_of_a_scenario_runs_it_and_begins_at_its_first_event(mmcs, scenario):
    path = scenario(GOOD.split("[[expect]]")[0] + FAULTS)
    text = good(mmcs("trace", path, "--window", 1))
    first = load(str(path)).moment()
    assert "is run first" in text and f"{first:.6f} to {first + 1e-3:.6f} s of motion" in text
    assert list((path.parent / "runs" / "test").glob("test_*.fst"))


def test_trace_after_an_edit_tells_that_the_build_differs(mmcs, ran, monkeypatch):
    out, _ = ran
    seen = ("sample 3", "recorded by build c1 a, this is c1 b")
    monkeypatch.setattr("mmcs.runs.replay.trace", lambda *_: seen)
    monkeypatch.setattr("mmcs.view.waves.write_views", lambda path: None)
    status, text, _ = mmcs("trace", out)
    assert status == 1 and "not the same run; it differs first at sample 3\n" in text
    assert "  recorded by build c1 a, this is c1 b: `mmcs run` it again" in text
