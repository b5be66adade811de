# SPDX-License-Identifier: Apache-2.0
"""A broken rule ends the simulation with its sentence, and so fails the test that ran. §4.3.1"""

from pathlib import Path

import pytest

from cocotb_tests.lib.runner import Job, run

CHECKER = Path(__file__).resolve().parents[2] / "rtl/checkers/vme_slave_checker.sv"
SCENE = "cocotb_tests.checkers.cocotb_vme_slave_checker"
TEST = "rule_goes_red/fault=0"  # a slave that pulls DTACK* with no strobe


@pytest.mark.req("VME-3")
def test_a_broken_rule_ends_the_run():
    job = Job(SCENE, "vme_slave_checker", "verilator", (), (CHECKER,))
    outcome = run(job, [TEST], seed=1)[TEST]
    assert not outcome.passed
    assert "DTACK* falls only while a data strobe is low" in outcome.log.read_text()
