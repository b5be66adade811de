# SPDX-License-Identifier: Apache-2.0
"""The cores of the chips are what mmcs.core makes of them."""

import sys

from tools import cores
from tools.compiled import ran
from tools.sources import made_of


def test_they_are_fresh_and_a_stale_one_is_named():
    done = ran(sys.executable, "tools/cores.py", "--check")
    assert done.returncode == 0, done.stderr


def test_a_chip_has_what_it_is_made_of_and_no_part_of_one_is_a_chip():
    files = ["rtl/chips/i8254_counter.sv", "rtl/chips/i8254.sv"]
    assert [str(f) for f in made_of("i8254")] == files
    assert "i8254" in cores.CHIPS
    assert "i8254_counter" not in cores.CHIPS
