# SPDX-License-Identifier: Apache-2.0
"""The examples of bfm/ run, are named in its READMEs, and run by their own script."""

import shutil
import subprocess
import sys

import pytest

from cocotb_tests.lib import runner

BFM = runner.ROOT / "bfm"
EXAMPLES = {
    "vme_ram": ("vme", "memory_and_interrupt"),
    "pc_port": ("pcbus", "register_and_wait_states"),
    "quad_counter": ("quadrature", "counts_what_turns"),
    "low_pass": ("analog", "step_ramp_and_sine"),
}


def test_none_is_forgotten():
    assert {file.stem for file in (BFM / "examples").glob("*.sv")} == EXAMPLES.keys()


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs(name, request):
    chosen = request.config.getoption("--sim")
    for sim in runner.SIMULATORS if chosen == "both" else (chosen,):
        extra = (BFM / "examples" / f"{name}.sv",)
        job = runner.Job(f"bfm.examples.{name}", name, sim, (), extra)
        test = EXAMPLES[name][1]
        outcome = runner.run(job, [test], request.config.getoption("--seed"))[test]
        assert outcome.passed, f"{sim}: {outcome.text}"


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_named_in_its_readme(name):
    assert f"{name}.py)" in (BFM / "cocotbext" / EXAMPLES[name][0] / "README.md").read_text()


def run(folder, *words):
    command = [sys.executable, str(BFM / "examples" / "run.py"), *words]
    return subprocess.run(command, cwd=folder, text=True, capture_output=True, check=False)


def test_the_script_says_what_it_wants(tmp_path):
    for words in ((), ("vme",), ("vme_ram", "modelsim")):
        done = run(tmp_path, *words)
        assert done.returncode == 2 and "an example (low_pass, pc_port" in done.stderr


def test_the_script_runs_an_example(tmp_path):
    if not shutil.which("iverilog"):
        pytest.skip(runner.MISSING["icarus"])
    done = run(tmp_path, "pc_port")
    assert done.returncode == 0 and "PASS=1 FAIL=0" in done.stdout, done.stdout + done.stderr


def run_copy(folder, file, old, new):
    """pc_port and the script, copied to a folder, with a change of one file."""
    if not shutil.which("iverilog"):
        pytest.skip(runner.MISSING["icarus"])
    for one in (BFM / "examples" / "run.py", *(BFM / "examples").glob("pc_port.*")):
        shutil.copy(one, folder)
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))
    command = [sys.executable, "run.py", "pc_port"]
    return subprocess.run(command, cwd=folder, text=True, capture_output=True, check=False)


def test_a_test_that_fails_is_the_scripts_status(tmp_path):
    done = run_copy(tmp_path, "pc_port.py", "assert ", "assert not ")
    assert done.returncode == 1 and "PASS=0 FAIL=1" in done.stdout, done.stdout + done.stderr


def test_a_time_step_that_is_too_coarse_is_told(tmp_path):
    done = run_copy(tmp_path, "run.py", '"1ps"', '"1ns"')
    assert "the simulator's time step is 1e-9 s, but these models need 1 ps" in done.stdout
