# SPDX-License-Identifier: Apache-2.0
"""Runs every TEST(name, "ID ID") of the C test program as an item of its own, which covers the
requirements of these ids."""

import re
from pathlib import Path

import pytest
from fwbuild import ROOT, SANITIZE, compile_c
from hypothesis import given, settings
from hypothesis import strategies as st

from tools.compiled import ran

HERE = Path(__file__).parent

DRIVER = sorted((ROOT / "firmware" / "mc").glob("*.c"))
TESTS = [*sorted(HERE.glob("test_*.c")), HERE / "harness.c", HERE / "mock.c"]
FUNCTION = re.compile(r'^TEST\((test_\w+)(?:, "([^"]*)")?\)', re.M)


def cases():
    for source in TESTS:
        for name, ids in FUNCTION.findall(source.read_text()):
            marks = [pytest.mark.req(*ids.split())] if ids else []
            yield pytest.param(name, id=f"{source.stem}-{name}", marks=marks)


def program() -> Path:
    return compile_c("driver_tests", [*TESTS, *DRIVER], SANITIZE)


@pytest.mark.parametrize("name", list(cases()))
def test_c(name):
    done = ran(program(), name)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.req("DRV-2", "DRV-3", "DRV-4", "DRV-5", "DRV-6", "DRV-12")
@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(st.binary(min_size=300, max_size=1500))
def test_chosen_calls(choices):
    """Chosen by hypothesis, and shortened where the driver does not what the model of test_random.c
    says."""
    done = ran(program(), "test_calls_that_a_model_judges", choices.hex().rstrip("0"))
    assert done.returncode == 0, done.stdout + done.stderr
