# SPDX-License-Identifier: Apache-2.0
"""The tops for real buses in the tests of cocotb_tops.py."""

from pathlib import Path

from cocotb_tests.lib import runner

ROOT = Path(__file__).resolve().parents[3]

HERE = Path(__file__).parent
FILES = (*sorted((ROOT / "fpga/bus").glob("*.sv")), ROOT / "fpga/board/spi_converters.sv",
         HERE / "bench_bus.sv")  # fmt: skip
TESTS = ("no_two_drivers_meet", "data_in_time", "words_leave_the_upper_byte_alone",
         "interrupts_and_acknowledge", "panic_and_sclock_over_the_cable", "ale_and_clk_of_a_pc",
         "nothing_drives_in_reset")  # fmt: skip


def simulate() -> dict[str, runner.Outcome]:
    job = runner.Job("fpga.bus.tests.cocotb_tops", "bench_bus", "verilator", (), FILES)
    return runner.run(job, list(TESTS), runner.DEFAULT_SEED)
