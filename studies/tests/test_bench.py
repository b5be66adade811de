# SPDX-License-Identifier: Apache-2.0
"""`make bench`: its page has every row, and what it measures are the motions that it names."""

import re
import shutil
import sys

import pytest

from studies import bench, replay
from tools.compiled import ran


def test_rows_are_medians_of_the_rounds():
    name = "times as fast as Verilator"
    assert bench.row(name, [90.0, 101.6, 100.2]) == (
        f"| {name} | 100 | 90 to 102 | ≥ 80, aim 150 |"
    )
    name = "campaign, CPU of a fault"
    assert bench.row(name, [0.02]) == f"| {name} | 0.02 s |  | ≤ 0.65, aim 0.35 |"


@pytest.mark.slow
def test_an_answer_of_another_simulator_is_compared(tmp_path, monkeypatch):
    """A record that lacks an answer is not what Icarus answers."""
    if not shutil.which("iverilog"):
        pytest.skip("iverilog is missing: sudo apt-get install iverilog")
    monkeypatch.setattr(replay, "FOLDER", tmp_path)
    monkeypatch.setattr(replay, "SIMULATED_S", {"Icarus": 0.001})
    replay.record(bench.make_setup(3, True, "typical"))
    replay.build_icarus()
    assert replay.speed("Icarus") > 0
    record = tmp_path / "record.txt"
    lines = record.read_text().splitlines()
    later = (n for n, line in enumerate(lines) if re.match(rf"[1-9]\d* {replay.ANSWER} ", line))
    wrong = next(later)
    record.write_text("\n".join([*lines[:wrong], *lines[wrong + 1 :]]))
    with pytest.raises(SystemExit, match="Icarus has other answers at"):
        replay.speed("Icarus")


@pytest.mark.parametrize(("load", "least"), [("typical", 3000), ("full", 2500)])
def test_a_load_moves_and_repeats(load, least):
    machine = bench.Load(3, True, load)
    machine.sim.restore(machine.snapshot)
    before, ends = [machine.sim.true(n)["count"] for n in range(6)], []
    for _ in range(2):
        machine.sim.restore(machine.snapshot)
        machine.sim.run(machine.end)
        ends.append([machine.sim.true(n)["count"] for n in range(6)])
    assert ends[0] == ends[1]
    assert all(abs(a - b) >= least for a, b in zip(ends[0], before, strict=True)), ends[0]


def test_programs_make_the_scenarios_motion(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "FOLDER", tmp_path)
    bench.LockStep()
    scenario = tmp_path / "sines.toml"
    run = [sys.executable, "-m", "mmcs", "exec", "--lockstep", "--scenario", scenario]
    for program in ([tmp_path / "sines"], [sys.executable, tmp_path / "sines.py"]):
        out = tmp_path / "out"
        done = ran(*run, "--out", out, "--", *program, "250")
        assert done.returncode == 0, done.stderr
        rows = (out / "log.csv").read_text().splitlines()
        encoder = rows[0].split(",").index("encoder_5")
        assert abs(max(int(row.split(",")[encoder]) for row in rows[1:]) - 400) < 20
