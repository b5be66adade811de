# SPDX-License-Identifier: Apache-2.0
"""The cores of the chips are what mmcs.core makes of them."""

import subprocess
import sys
from pathlib import Path

from tools import cores
from tools.sources import made_of

ROOT = Path(__file__).resolve().parents[2]


def test_they_are_fresh_and_a_stale_one_is_named():
    done = subprocess.run([sys.executable, "tools/cores.py", "--check"], cwd=ROOT, check=False)
    assert done.returncode == 0


def test_a_chip_has_what_it_is_made_of_and_no_part_of_one_is_a_chip():
    files = ["rtl/chips/i8254_counter.sv", "rtl/chips/i8254.sv"]
    assert [str(f) for f in made_of("i8254")] == files
    assert "i8254" in cores.CHIPS
    assert "i8254_counter" not in cores.CHIPS
