# SPDX-License-Identifier: Apache-2.0
"""The card on a board, simulated with the chips beside it; cocotb_board.py has the tests."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))
from cocotb_tests.lib import runner  # noqa: E402

FILES = ("uart_host", "spi_converters", "mmcs_board")
TESTS = ("registers_over_the_serial_line", "converters_and_encoder", "the_stop_loop")


@pytest.fixture(scope="module")
def outcomes():
    extra = tuple(ROOT / f"fpga/board/{name}.sv" for name in FILES)
    job = runner.Job("fpga.board.tests.cocotb_board", "mmcs_board", "verilator", (), extra)
    return runner.run(job, list(TESTS), runner.DEFAULT_SEED)


@pytest.mark.slow
@pytest.mark.parametrize("name", TESTS)
def test_the_card_on_a_board(name, outcomes):
    assert outcomes[name].passed, outcomes[name].text
