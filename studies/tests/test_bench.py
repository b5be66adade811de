# SPDX-License-Identifier: Apache-2.0
"""`make bench`: its page has every row, and what it measures are the motions that it names."""

import sys

import pytest

from studies import bench
from tools.compiled import ran


def test_page_has_what_a_bound_is_of():
    told = bench.PAGE.read_text()
    optional = ("hits", "page")  # a cache that tells, node
    for name in bench.BOUNDS:
        assert f"| {name} |" in told or name.startswith(optional), name


def test_rows_are_medians_of_the_rounds():
    name = "6 axes, full joint speed"
    assert bench.row(name, [[3.0, 2.0], [8.0, 4.0], [9.0, 6.0]]) == (
        f"| {name} | 4.00x | 8.00x | 2.00 (1.50 to 2.00) | ≥ 1, aim 1.8 |"
    )
    name = "campaign, CPU of a fault"
    assert bench.row(name, [[0.02, None]]) == f"| {name} | – | 0.02 s | – | ≤ 0.65, aim 0.35 |"


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


def test_a_program_that_fails_is_told():
    with pytest.raises(SystemExit, match="nonsense"):
        bench.cpu([sys.executable, "-c", "raise SystemExit('nonsense')"])


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
