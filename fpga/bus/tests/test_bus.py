# SPDX-License-Identifier: Apache-2.0
"""The tops for real buses together: VME, adaptor, PC bus, two cards; tests: cocotb_tops.py."""

import functools
from pathlib import Path

import pytest

from cocotb_tests.lib import runner
from mmcs import ROOT

FILES = (*sorted((ROOT / "fpga/bus").glob("*.sv")), ROOT / "fpga/board/spi_converters.sv",
         Path(__file__).with_name("bench_bus.sv"))  # fmt: skip
TESTS = ("no_two_drivers_meet", "data_in_time", "words_leave_the_upper_byte_alone",
         "interrupts_and_acknowledge", "panic_and_sclock_over_the_cable", "ale_and_clk_of_a_pc",
         "nothing_drives_in_reset")  # fmt: skip


@functools.cache
def outcomes() -> dict[str, runner.Outcome]:
    job = runner.Job("fpga.bus.tests.cocotb_tops", "bench_bus", "verilator", (), FILES)
    return runner.run(job, list(TESTS), runner.DEFAULT_SEED)


@pytest.mark.req("VME-2", "VME-3", "VME-4", "PCB-1", "INT-2", "PAN-1")
@pytest.mark.xdist_group("bus")
@pytest.mark.parametrize("name", TESTS)
def test_on_real_buses(name):
    outcome = outcomes()[name]
    assert outcome.passed, outcome.text
