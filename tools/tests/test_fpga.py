# SPDX-License-Identifier: Apache-2.0
"""What goes into programmable logic is read by the synthesis tool, hierarchy and all."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow  # some ten seconds
@pytest.mark.req("SOC-1")
def test_both_tops_elaborate():
    command = [sys.executable, "fpga/build.py", "--elaborate"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
