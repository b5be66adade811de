# SPDX-License-Identifier: Apache-2.0
"""The pages that studies write: today's rows, and what is made of figures that are given."""

import itertools
import json
import os
import re
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock, patch

import pandas
import pytest

from mmcs.sweeps.classes import DANGEROUS, LATE, MASKED
from studies import bench, campaign, carried_out, replay
from tools.compiled import ran
from tools.golden import plain, same


def as_ever(name, tmp_path, *made):
    """What a program made, and called, is as before."""
    text = "\n".join(map(str, made)).replace(sys.executable, "python")
    same(name, plain(text, tmp_path), Path(__file__).with_name("golden.txt"))


def test_bench_writes_what_it_measures(tmp_path):
    """A machine of n cards takes 10 n MB, whoever has started one before."""
    told, used = Mock(), [50.0]
    told.speed.side_effect = told.rtl.side_effect = (n * n for n in itertools.count(2.0))
    told.out.side_effect = (('{"cpu_s": 8}' if n % 2 else "3", n * n) for n in itertools.count(1))

    def load(cards, *_):
        used[0] += 10 * cards
        return Mock(hits=99 + cards / 10, speed=told.speed)

    assert abs(bench.memory_mb() - int(Path("/proc/self/statm").read_text().split()[1]) / 244) < 9
    with (
        patch.multiple(bench, Load=load, memory_mb=lambda: used[0], carried_out=told.out, ROUNDS=3,
                       FOLDER=tmp_path, BUILD=bench.ROOT, environment=dict, rewrite=told.rewrite,
                       committed=told.committed),
        patch.object(bench.LockStep, "__init__", lambda self: None),
        patch.multiple(replay, build=lambda _: {"Verilator": "5", "CXXRTL": "9"}, speed=told.rtl),
        patch.multiple(shutil, which=lambda _: "node"), patch.object(sys, "argv", ["bench"]),
        patch.multiple(os, sched_getaffinity=lambda _: {0, 1}),
    ):  # fmt: skip
        as_ever("bench", tmp_path, bench.main(), *told.mock_calls)
    for name in bench.BOUNDS:
        row = rf"^\| {re.escape(name)} \|.*\| {re.escape(bench.wanted(name))} \|$"
        assert re.search(row, bench.PAGE.read_text(), re.M), f"docs/evidence/bench.md: {name}"


def test_a_program_that_fails_is_told():
    assert carried_out(["sh", "-c", "echo $A; exit 3"], (3,), env={"A": "b"})[0] == "b\n"
    with pytest.raises(SystemExit, match=r"mmcs: sh -c echo a >&2; exit 1\.\.\. failed: a"):
        carried_out(["sh", "-c", "echo a >&2; exit 1"])


def test_failures_of_the_campaign_are_shares_of_all_flips(tmp_path):
    """Two motions, of 10 and 30 flip-flops: 1/2 and 1/4 of their flips are dangerous."""
    row = {"sort": "register", "deg": 6.0, "after_ms": None, "status": "ok"}
    rows = [row | {"motion": "a", "class": name} for name in (DANGEROUS, MASKED)]
    rows += [row | {"motion": "b", "class": name} for name in (DANGEROUS, MASKED, MASKED, LATE)]
    rows += [row | {"motion": "a", "class": DANGEROUS, "sort": "pin", "after_ms": 50.0, "deg": 5.0}]
    rows += [rows[0] | {"status": "error"}, rows[0] | {"after_ms": 9.0}]
    lines = ["{}", *(json.dumps({"n": 9 - n, "row": row}) for n, row in enumerate(rows))]
    motion = SimpleNamespace(name="a", until=1.0, registers=(("x", 4), ("y", 6)))
    other = SimpleNamespace(name="b", until=2.0, registers=(("x", 30),))
    told = Mock(make_plan=Mock(return_value=SimpleNamespace(motions=(motion, other))))
    told.run.return_value.returncode = 0
    with (
        patch.multiple(campaign, FOLDER=tmp_path, make_plan=told.make_plan, rewrite=told.rewrite,
                       committed=told.committed, subprocess=told),
        patch.object(sys, "argv", ["campaign", "--faults", "60", "--healthy", "9"]),
    ):  # fmt: skip
        for place in (campaign.folder_of(name) for name in campaign.VARIANTS):
            for name in campaign.MOTIONS:
                (place / name).mkdir(parents=True)
                table = "panics,interrupts\n0,1000\n0,989\n0,990\n1,1000\n"
                (place / name / "table.csv").write_text(table)
            (place / campaign.ROWS).write_text("\n".join(lines))
        (tmp_path / "stops").mkdir()
        (tmp_path / "stops" / "report.md").write_text("stops")
        campaign.main()
        table = pandas.read_parquet(tmp_path / "rows.parquet").to_csv()
        as_ever("campaign", tmp_path, table, *told.mock_calls)


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
    wrong = next(n for n, s in enumerate(lines) if re.match(rf"[1-9]\d* {replay.ANSWER} ", s))
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
    run = (sys.executable, "-m", "mmcs", "exec", "--lockstep", "--scenario")
    for program in ([tmp_path / "sines"], [sys.executable, tmp_path / "sines.py"]):
        out = tmp_path / "out"
        done = ran(*run, tmp_path / "sines.toml", "--out", out, "--", *program, "250")
        assert done.returncode == 0, done.stderr
        rows = (out / "log.csv").read_text().splitlines()
        encoder = rows[0].split(",").index("encoder_5")
        assert abs(max(int(row.split(",")[encoder]) for row in rows[1:]) - 400) < 20
