# SPDX-License-Identifier: Apache-2.0
"""The runner says which tool is missing, what a simulation ended with; CI skips nothing."""

import os
import sys

import pytest

from cocotb_tests.lib import runner


@pytest.mark.parametrize(
    "sim,words", [("icarus", "apt-get install iverilog"), ("verilator", "make")]
)
def test_a_missing_simulator_is_named(monkeypatch, sim, words):
    monkeypatch.setenv("PATH", "/nowhere")
    outcome = runner.run(runner.Job("no.module", "oneshot", sim), ["t"], 1)["t"]
    assert not outcome.passed
    assert words in outcome.text


@pytest.mark.parametrize("sim", runner.SIMULATORS)
def test_a_parameter_that_the_top_has_not_is_refused(sim):
    job = runner.Job("no.module", "oneshot", sim, (("PulsClks", 10),))
    outcome = runner.run(job, ["t"], 1)["t"]
    assert "does not build" in outcome.text and "PulsClks" in outcome.text


def test_an_assertion_that_icarus_tells_in_its_log_alone_is_in_the_tests_outcome(tmp_path):
    log, results = tmp_path / "sim.log", tmp_path / "results.xml"
    log.write_text(
        "0.00ns INFO cocotb.regression running m.one (1/3)\n"
        "5.00ns INFO cocotb.regression m.one passed\n"
        "5.00ns INFO cocotb.regression running m.two (2/3)\n"
        "FATAL: t.sv:2: t: the rule is broken\n       Time: 10000 Scope: t\n"
        "10.00ns WARNING cocotb.regression m.two failed\n"
        "10.00ns WARNING cocotb.regression m.three failed\n"
    )
    ended = '<failure message="ended prematurely"/>'
    cases = [f'<testcase name="{name}">{bad}</testcase>'
             for name, bad in (("one", ""), ("two", ended), ("three", ended))]  # fmt: skip
    results.write_text(f"<testsuites>{''.join(cases)}</testsuites>")
    found = runner._read(results, log)
    assert found["one"].passed and not found["one"].text
    assert "the rule is broken" in found["two"].text and "ended prematurely" in found["two"].text
    assert "the rule" not in found["three"].text


def test_a_simulator_that_never_ends_is_ended_by_the_time_it_uses(monkeypatch):
    monkeypatch.setattr(runner, "HANG_S", 1)
    simulator = runner._Runner()
    simulator.env = dict(os.environ)
    simulator._execute_cmds([[sys.executable, "-c", "import time; time.sleep(1.5)"]], None)
    with pytest.raises(RuntimeError, match=r"ended with -"):
        simulator._execute_cmds([[sys.executable, "-c", "while True: pass"]], None)


def test_a_simulation_shares_no_folder_with_another_process(tmp_path):
    own = runner._run_folder(tmp_path / "m-gw0-0")
    (own / "left").touch()
    living, ended = tmp_path / "m-gw0-0-1", tmp_path / f"m-gw0-0-{2**30}"
    living.mkdir()
    ended.mkdir()
    assert runner._run_folder(tmp_path / "m-gw0-0") == own
    assert not list(own.iterdir()) and living.is_dir() and not ended.exists()
