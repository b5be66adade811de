# SPDX-License-Identifier: Apache-2.0
"""The tops for real buses together: VME, adaptor, PC bus, two cards; tests: cocotb_tops.py."""

import functools

import pytest

from fpga.bus.tests.bus import TESTS, simulate

outcomes = functools.cache(simulate)


@pytest.mark.req("VME-2", "VME-3", "VME-4", "PCB-1", "INT-2", "PAN-1")
@pytest.mark.xdist_group("bus")
@pytest.mark.parametrize("name", TESTS)
def test_on_real_buses(name):
    outcome = outcomes()[name]
    assert outcome.passed, outcome.text
