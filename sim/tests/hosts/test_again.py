# SPDX-License-Identifier: Apache-2.0
"""Runs on a real processor made again: replay, snapshots, waveforms."""

import json
import re
from pathlib import Path

import needed
import pytest

from mmcs import ROOT, Session, hosts, load, machine, waves
from mmcs.tests.conftest import call

pytestmark = needed.m68020


@pytest.fixture
def mmcs(monkeypatch):
    monkeypatch.chdir(ROOT)
    return call


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run, and its hash."""
    out = tmp_path_factory.mktemp("run")
    args = ["run", "lab500", "--duration", "0.15", "--set", "expect=[]", "--host", "m68020",
            "--out", str(out)]  # fmt: skip
    status, said, problem = call(*args)
    assert status == 0, problem
    return out, re.search(r"hash (0x[0-9a-f]{16})", said)[1]


STOPPED, PROGRAM, ENTER, READ, COMPUTE, WRITE, PUBLISH = range(7)  # host_phase


@pytest.mark.req("API-1", "FW-1")
def test_stretch_with_waveforms(mmcs, run, tmp_path):
    """The trace build goes the same way; its prepared view shows code and bus on one time line:
    each pass runs through the phases, the D/As are written within the one of that name."""
    import pywellen

    out, digest = run
    assert json.loads((out / "run.mmcs").read_text())["host"] == "m68020"
    path = tmp_path / "part.fst"
    status, text, _ = mmcs("trace", out, "--at", 0.1, "--window", 3.5, "--out", path)
    assert status == 0 and f"the same hash, {digest}" in text
    signals = {v.full_name: v for v in pywellen.Waveform(str(path)).all_vars()}
    widths = {s: getattr(signals.get(s.full()), "length", None)
              for group in waves.GROUPS.values() for s in group}  # fmt: skip
    assert all(s.width == found for s, found in widths.items())
    view = path.with_suffix(".gtkw").read_text()
    assert all(s.gtkwave() in view for s in widths)

    phase = [(t, v) for t, v in signals[waves.GROUPS["firmware"][0].full()].tv]
    enters = [n for n, (_, v) in enumerate(phase) if v == ENTER]
    whole = [n for n in enters if n + 5 < len(phase)]
    assert len(whole) >= 2
    strobe = waves.Signal(f"{waves.AXIS}.dac_hi_i")
    writes = [t for t, v in signals[strobe.full()].tv if v]
    pc = list(signals[waves.GROUPS["firmware"][1].full()].tv)
    for n in whole:
        assert [v for _, v in phase[n : n + 5]] == [ENTER, READ, COMPUTE, WRITE, PUBLISH]
        assert phase[n + 5][1] in (PROGRAM, STOPPED)
        begin, end = phase[n + 3][0], phase[n + 4][0]
        assert [t for t in writes if phase[n][0] <= t < phase[n + 5][0]]
        assert all(begin < t < end for t in writes if phase[n][0] <= t < phase[n + 5][0])
        computing = {v for t, v in pc if phase[n + 2][0] <= t < begin}
        assert len(computing) > 3  # of a few hundred on the 68020, which is looked at at times
    assert STOPPED in {v for _, v in phase}


@pytest.mark.req("SW-1")
def test_replay_tells_of_another_image(mmcs, run, tmp_path):
    out, _ = run
    text = json.loads((out / "run.mmcs").read_text())
    text["image"], text["hash"] = "00000000", "0x0000000000000000"
    (tmp_path / "run.mmcs").write_text(json.dumps(text))
    status, told, _ = mmcs("replay", tmp_path)
    assert status == 1 and "recorded with the firmware image 00000000, this one is " in told
    text["host"] = "vax"
    (tmp_path / "run.mmcs").write_text(json.dumps(text))
    status, _, err = mmcs("replay", tmp_path)
    assert status == 2 and 'host = "vax": must be one of "native", "m68020"' in err


TIMES = (0.0305, 0.0403, 0.0407)  # snapshots, seconds
END = 0.055


class Halting:
    """A Sim that runs to each of these times on the way and calls there."""

    def __init__(self, sim, at, call):
        self.sim, self.at, self.call = sim, list(at), call

    def __getattr__(self, name):
        return getattr(self.sim, name)

    def play(self, script, until):
        while self.at and self.at[0] <= script.start + until:
            self.call(self.at.pop(0))
        return self.sim.play(script, until)


@pytest.mark.req("API-1", "FW-1")
@pytest.mark.parametrize(
    "sets",
    [(), ("host.wait_states=1", "host.instruction_cache=256 bytes")],
    ids=["ideal cache", "256 bytes"],
)
def test_m68020_goes_back_and_on(sets):
    """From instants of a run, also ones within a pass, another machine comes to the end of a run
    that was never interrupted."""
    setup = load("lab500", "duration=0.06", "expect=[]", *sets)

    def run(at, call):
        with machine(setup, host="m68020") as sim:
            Session(Halting(sim, at, lambda t: call(sim, t)), setup).run(lambda *_: None)
            return [sim.snapshot_bytes(s["id"]) for s in sim.snapshots()], sim.history_bytes()

    def end(sim):  # not what it took: what is at rest is found out anew
        took = ("evals", "cache_hits", "cache_misses", "cache_bytes")
        stats = {name: value for name, value in sim.stats().items() if name not in took}
        return sim.hash(), sim.clock, stats

    whole = []
    run([END], lambda sim, t: (sim.run(t), whole.append(end(sim))))
    states, past = run(TIMES, lambda sim, t: sim.snapshot(t))
    assert len(states) == len(TIMES) and len(set(states)) == len(TIMES)
    with machine(setup, host="m68020") as other:
        for state in reversed(states):
            other.restore_bytes(state, past)
            here = other.snapshot()
            for _ in range(2):
                other.restore(here)
                assert other.run(END)
                assert end(other) == whole[0]


@pytest.mark.req("SW-1", "FW-1")
def test_snapshot_fits_its_own_processor_only(monkeypatch, tmp_path):
    """Other wait states or another image are another machine, and leave it as it was."""
    setup = load("lab500", "duration=0.06", "expect=[]")
    with machine(setup, host="m68020") as sim:
        sim.run(0.02)
        state, past = sim.snapshot_bytes(sim.snapshot()), sim.history_bytes()
    slower = load("lab500", "duration=0.06", "expect=[]", "host.wait_states=1")
    config = hosts.config("m68020")
    image = tmp_path / "mc.bin"
    image.write_bytes(Path(config["firmware"]).read_bytes() + b"\0")
    for other, firmware in ((slower, config["firmware"]), (setup, str(image))):
        monkeypatch.setattr(hosts, "config", lambda _, f=firmware: config | {"firmware": f})
        with machine(other, host="m68020") as sim:
            before = sim.hash()
            with pytest.raises(ValueError, match="another machine: robot, host, its firmware"):
                sim.restore_bytes(state, past)
            assert sim.hash() == before
            assert sim.run(0.02)
