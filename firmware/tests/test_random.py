# SPDX-License-Identifier: Apache-2.0
"""Calls that hypothesis chooses, and shortens where the driver does not what the model of
test_random.c says."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_firmware import program

from tools.compiled import ran


@pytest.mark.req("DRV-2", "DRV-3", "DRV-4", "DRV-5", "DRV-6", "DRV-12")
@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(st.binary(min_size=300, max_size=1500))
def test_chosen_calls(choices):
    done = ran(program(), "test_calls_that_a_model_judges", choices.hex().rstrip("0"))
    assert done.returncode == 0, done.stdout + done.stderr
