# SPDX-License-Identifier: Apache-2.0
"""The runner knows what a build was made from, says which tool is missing; CI skips nothing."""

import os
import subprocess
import sys

import pytest

from cocotb_tests.lib import runner


def test_a_build_of_other_sources_is_not_current(tmp_path):
    source, folder = tmp_path / "a.sv", tmp_path / "build"
    source.write_text("module a; endmodule\n")
    folder.mkdir()
    assert not runner.is_current(folder), "never built"
    (folder / "built").touch()
    assert not runner.is_current(folder), "built from what nobody noted"
    (folder / "built").write_text(f"{runner.digest_of([source]).hexdigest()}\n{source}\n")
    assert runner.is_current(folder)
    source.write_text("module a; wire b; endmodule\n")
    assert not runner.is_current(folder)
    source.unlink()
    assert not runner.is_current(folder)


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


def test_a_simulator_runs_under_a_lower_limit():
    """As tools/mutation/faults.py sets one: a limit cannot be raised again."""
    script = (
        "import os, resource, sys; resource.setrlimit(resource.RLIMIT_CPU, (60, 60));"
        "from cocotb_tests.lib import runner; simulator = runner._Runner();"
        "simulator.env = dict(os.environ); simulator._execute_cmds([['true']], None)"
    )
    subprocess.run([sys.executable, "-c", script], cwd=runner.ROOT, check=True)


@pytest.mark.parametrize("ci,status,words", [("true", 1, "get it with: apt"), ("", 0, "1 skipped")])
@pytest.mark.parametrize("how", ["in_test", "in_module"])
def test_a_skip_fails_in_ci(tmp_path, ci, status, words, how):
    body = {
        "in_test": "def test_a(): pytest.skip('get it with: apt')",
        "in_module": "pytest.importorskip('no_such', reason='get it with: apt')",
    }[how]
    file = tmp_path / "test_skip.py"
    file.write_text(f"import pytest\n\n{body}\n\ndef test_b(): pass\n")
    command = [sys.executable, "-m", "pytest", "-p", "conftest", "-p", "no:cacheprovider", "-rs"]
    done = subprocess.run(
        [*command, f"--rootdir={tmp_path}", "-o", "addopts=", str(file)],
        cwd=tmp_path,
        env=os.environ | {"CI": ci, "PYTHONPATH": str(runner.ROOT)},
        text=True,
        capture_output=True,
        check=False,
    )
    assert words in done.stdout, done.stdout + done.stderr
    # 2: a module that cannot be collected; 5: nothing was left to run
    assert done.returncode in ({1, 2} if status else {0, 5}), done.stdout
