# SPDX-License-Identifier: Apache-2.0
"""The timing diagrams are of today's RTL."""

import sys

import pytest

from tools.compiled import ran


@pytest.mark.slow  # twelve simulations
def test_the_diagrams_are_fresh():
    done = ran(sys.executable, "tools/wavegen.py", "--check")
    assert done.returncode == 0, done.stdout + done.stderr
