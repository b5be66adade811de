# SPDX-License-Identifier: Apache-2.0
"""The tops for real buses together, VME, adaptor, PC bus and two cards; and the SPI converters."""

import functools
from pathlib import Path

import pytest

from cocotb_tests.lib import runner
from mmcs import ROOT

BENCH = Path(__file__).with_name("bench_bus.sv")
FILES = (*sorted((ROOT / "fpga/bus").glob("*.sv")), BENCH)
TESTS = {
    "cocotb_tops": ("no_two_drivers_meet", "data_in_time", "words_leave_the_upper_byte_alone",
                    "interrupts_and_acknowledge", "panic_and_sclock_over_the_cable",
                    "ale_and_clk_of_a_pc", "nothing_drives_in_reset"),
    "cocotb_converters": ("codes_reach_the_converters", "the_end_of_run_takes_the_torque_away",
                          "the_first_clear_does_not_mean_the_lowest_voltage"),
}  # fmt: skip
TOPS = {"cocotb_tops": "bench_bus", "cocotb_converters": "spi_converters"}


@functools.cache
def outcomes(module: str) -> dict[str, runner.Outcome]:
    job = runner.Job(f"fpga.tests.{module}", TOPS[module], "verilator", (), FILES)
    return runner.run(job, list(TESTS[module]), runner.DEFAULT_SEED)


@pytest.mark.req("VME-2", "VME-3", "VME-4", "PCB-1", "INT-2", "PAN-1", "DAC-1", "ADC-1")
@pytest.mark.xdist_group("bus")
@pytest.mark.parametrize(("module", "name"), [(m, n) for m, names in TESTS.items() for n in names])
def test_on_real_buses(module, name):
    outcome = outcomes(module)[name]
    assert outcome.passed, outcome.text
