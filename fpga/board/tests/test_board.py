# SPDX-License-Identifier: Apache-2.0
"""The boards' tops, simulated with the chips beside them; cocotb_board.py has the tests."""

import functools

import pytest

from fpga.board.tests.board import PTY_TESTS, SOC_TESTS, TESTS, over_a_pty, simulate, simulate_soc

outcomes = functools.cache(simulate)
sessions = functools.cache(over_a_pty)
soc = functools.cache(simulate_soc)


@pytest.mark.slow
@pytest.mark.req("ADP-1", "ENC-1", "DAC-1", "ADC-1", "PAN-1")
@pytest.mark.xdist_group("board")
@pytest.mark.parametrize("board", ["ulx3s", "icebreaker"])
@pytest.mark.parametrize("name", TESTS)
def test_the_card_on_a_board(name, board):
    outcome = outcomes(board)[name]
    assert outcome.passed, outcome.text


@pytest.mark.req("ADP-1", "HB-1", "PAN-1", "PPI-1")
@pytest.mark.xdist_group("board")
@pytest.mark.parametrize("name", PTY_TESTS)
def test_mmcs_board_over_a_pty(name):
    outcome = sessions()[name]
    assert outcome.passed, outcome.text


@pytest.mark.slow
@pytest.mark.req("SOC-1", "ENC-1", "DAC-1", "HB-1", "PAN-1")
@pytest.mark.xdist_group("board")
@pytest.mark.parametrize("name", SOC_TESTS)
def test_the_board_that_closes_the_loop(name):
    outcome = soc()[name]
    assert outcome.passed, outcome.text
