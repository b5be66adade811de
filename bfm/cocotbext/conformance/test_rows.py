# SPDX-License-Identifier: Apache-2.0
"""Each row of a data sheet on the core that --dut names; the plugin has simulated them all."""

import pytest
from cocotbext.conformance.plugin import FOUND, chosen

CONFORMANCE = True


def pytest_generate_tests(metafunc):
    metafunc.parametrize("row", chosen(metafunc.config))


def test_row(row, pytestconfig):
    wrong = pytestconfig.stash[FOUND][row.name]
    if wrong and row.silent:
        pytest.skip(f"not in the sheet; the cores of MMCS differ: {wrong}")
    if wrong:
        pytest.fail(f"{row.section}: {row.words}: {wrong}", pytrace=False)
