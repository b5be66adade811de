# SPDX-License-Identifier: Apache-2.0
"""A broken rule ends the simulation with its sentence, and so fails the test that ran. §4.3.1"""

from pathlib import Path

import pytest

from cocotb_tests.lib.runner import Job, run

CHECKER = Path(__file__).resolve().parents[2] / "rtl/checkers/vme_slave_checker.sv"
SCENE = "cocotb_tests.checkers.cocotb_vme_slave_checker"
TEST = "rule_goes_red/fault=0"  # a slave that pulls DTACK* with no strobe


@pytest.mark.req("VME-3")
@pytest.mark.parametrize("stop", [1, 0])
def test_a_broken_rule_ends_the_run(stop):
    job = Job(SCENE, "vme_slave_checker", "verilator", (("Stop", stop),), (CHECKER,))
    outcome = run(job, [TEST], seed=1, worker=f"stop{stop}")[TEST]
    assert outcome.passed != bool(stop), outcome.text
    if stop:
        assert "DTACK* falls only while a data strobe is low" in outcome.log.read_text()
