# SPDX-License-Identifier: Apache-2.0
"""What goes into programmable logic is read by the synthesis tool, hierarchy and all."""

import sys

import pytest

from tools.compiled import ran


@pytest.mark.slow  # some ten seconds
@pytest.mark.req("SW-1")
def test_all_tops_elaborate():
    done = ran(sys.executable, "fpga/build.py", "--elaborate")
    assert done.returncode == 0, done.stdout + done.stderr
