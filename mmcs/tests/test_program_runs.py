# SPDX-License-Identifier: Apache-2.0
"""A program as a scenario: [[program]], `mmcs exec --out`, replay, sweep."""

import json
import re
import sys

import pytest

from mmcs.scenario.load import load
from mmcs.sweeps.workers import run_row
from mmcs.tests.conftest import call, good, one_clear_line
from mmcs.tests.device_bench import PORT, compile_example, write_scenario

STEP = """
import sys
import mmcs
from mmcs import mcdef as mc
with mmcs.Device() as dev:
    dev.set_param(0, {**dev.get_param(0), "mode": mc.MD_POS, "a0": 7309, "a1": -7027, "b0": 64})
    dev.enable()
    for n in range(300):
        dev.wait()
        dev.write([min(n, int(sys.argv[1]))])
"""


@pytest.fixture
def folder(tmp_path):
    write_scenario(tmp_path)
    (tmp_path / "step.py").write_text(STEP)
    (tmp_path / "whole.toml").write_text(f"""
extends = "device.toml"
[[program]]
run = "{sys.executable} step.py 200"
[[event]]
at = 0.5
input = "estop"
value = 1
[[expect]]
kind = "event"
event = "panic"
text = "high"
after = 0.5
within_ms = 1
[[expect]]
kind = "signal"
signal = "encoder"
axis = 0
after = 0.45
until = 0.5
mean = [150, 250]
""")
    return tmp_path


def test_a_program_is_a_scenario(folder):
    """Report, record and expectations; the record replays, and says when the program is another."""
    out = folder / "out"
    good(call("run", folder / "whole.toml", "--out", out))
    report = json.loads((out / "report.json").read_text())
    assert [e["ok"] for e in report["expect"]] == [True, True]
    assert report["processes"][0]["status"] == 1  # its write() after the button is refused
    assert {"report.json", "log.csv", "plot.svg", "run.mmcs"} <= {p.name for p in out.iterdir()}
    assert f"reproduced, hash {report['hash']}" in good(call("replay", out))
    (folder / "step.py").write_text(STEP.replace("200", "100").replace("min(n,", "min(n // 2,"))
    status, said, _ = call("replay", out)
    assert status == 1 and "have changed since the record" in said


def test_exec_leaves_results(folder):
    """`--set` counts, the program's status is that of the command, and its record replays."""
    out = folder / "out"
    words = ["exec", "--scenario", folder / "device.toml", "--out", out, "--set", "seed=3", "--"]
    good(call(*words, sys.executable, folder / "step.py", 200))
    record = json.loads((out / "run.mmcs").read_text())
    assert record["seed"] == 3 and 0.4 < record["data"]["duration"] < 1.0
    assert "step.py 200" in record["data"]["description"], "the scenario's own motion is not there"
    good(call("replay", out))
    assert call(*words, sys.executable, "-c", "raise SystemExit(7)")[0] == 7


def test_exec_takes_a_compiled_set_up(folder):
    """With and without results: one hash, that of the scenario's."""
    good(call("compile", folder / "device.toml", "-o", folder / "own.bin"))
    hashes = set()
    for name in ("device.toml", "own.bin"):
        out, words = folder / name[:3], ["exec", "--scenario", folder / name]
        program = ["--", sys.executable, folder / "step.py", 200]
        good(call(*words, "--out", out, *program))
        hashes.add(json.loads((out / "report.json").read_text())["hash"])
        assert "reproduced" in good(call("replay", out))
        good(call(*words, "--lockstep", *program))
    assert len(hashes) == 1


def test_exec_replays_expectations_beyond_its_end(folder):
    """They are not met, and the record is one all the same."""
    words = ["exec", "--scenario", folder / "whole.toml", "--out", folder / "out", "--"]
    assert call(*words, sys.executable, "-c", "import mmcs; mmcs.Device().wait()")[0] == 1
    assert "reproduced" in good(call("replay", folder / "out"))


@pytest.mark.req("DRV-1", "API-1")
def test_the_driver_runs_as_a_program_on_the_mapped_window(folder, capfd):
    """firmware/ports/linux: a sine without a missed sample; bus errors of its window stop it."""
    user = compile_example(PORT)
    for name, value in (("bus_error", 2), ("cable", 0)):
        event = f'[[event]]\nat = 0.5\ninput = "{name}"\nvalue = {value}\n'
        (folder / f"{name}.toml").write_text('extends = "device.toml"\n' + event)

    def ran(scenario, *arguments):
        words = ("--scenario", folder / scenario, "--out", folder / "out")
        status = call("exec", *words, "--", user, *arguments)[0]
        return status, "".join(capfd.readouterr())

    status, said = ran("device.toml")
    found = re.search(r"(\d+) samples, (\d+) missed, worst error (\d+)", said)
    assert status == 0 and found, said
    assert (found[1], found[2]) == ("400", "0") and 5 < int(found[3]) < 100
    status, said = ran("device.toml", "/dev/vme16", "0x7000")
    assert status == 1 and "open: No such device or address" in said
    status, said = ran("bus_error.toml")
    assert status == 1 and "PANIC: bus error in a servo pass" in said and "write: Input/" in said
    status, said = ran("cable.toml")
    assert status == 1 and "PANIC: card 0 does not answer" in said and "sample: " in said
    assert ran("device.toml", "/dev/vme16")[0] == 2


def test_a_sweep_takes_one(folder):
    rows = [run_row(load(str(folder / "whole.toml"), (f"seed={n}",))) for n in (1, 1, 2)]
    assert [row["status"] for row in rows] == ["ok"] * 3
    assert rows[0]["hash"] == rows[1]["hash"] != rows[2]["hash"]


def test_a_sweep_tells_of_failing_programs_and_prints_nothing_of_theirs(folder, capfd):
    (folder / "step.py").write_text("print('noise'); raise SystemExit('more of it')")
    row = run_row(load(str(folder / "whole.toml"), ("expect=[]",)))
    assert row["status"] == "ok" and row["why"].endswith("step.py 200: status 1")
    assert capfd.readouterr() == ("", "")


def test_run_tells_the_status_of_a_program_and_show_its_command(folder):
    said = "".join(call("run", folder / "whole.toml", "--out", folder / "out")[1:])
    assert "step.py 200: status 1" in said.replace("\n", ""), said
    shown = good(call("show", folder / "whole.toml"))
    assert "step.py 200" in shown and " a0 " not in shown, shown


def test_the_duration_ends_who_goes_on_and_its_run_is_traced(folder):
    (folder / "long.toml").write_text("""
extends = "device.toml"
duration = 0.05
[[program]]
run = "sleep 100"
""")
    from mmcs.runs.runner import simulate

    answer = call("campaign", folder / "long.toml")
    one_clear_line(answer, "without events, processes and programs")
    result = simulate(load(str(folder / "long.toml")))
    assert result.processes == [{"kind": "program", "run": "sleep 100", "status": 137}]
    assert result.simulated_s == pytest.approx(0.05, abs=1e-6)
    good(call("run", folder / "long.toml", "--out", folder / "out"))
    wave = folder / "w.fst"
    said = good(call("trace", folder / "out", "--at", 0.02, "--window", 1, "--out", wave))
    assert "the same hash" in said and wave.stat().st_size > 10_000
