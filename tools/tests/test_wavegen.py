# SPDX-License-Identifier: Apache-2.0
"""Timing diagrams are of today's RTL, and the rows of `make waves TEST=NAME` are in the trace."""

import re
import shutil
import subprocess
import sys

import pytest

from tools import wavegen
from tools.compiled import ran

pytestmark = pytest.mark.xdist_group("wavegen")  # both write build/waves


def test_the_diagrams_are_fresh():
    done = ran(sys.executable, "tools/wavegen.py", "--check", "--sim", "icarus")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(not shutil.which("fst2vcd"), reason="get it with: apt-get install gtkwave")
def test_each_row_of_a_view_is_in_its_trace():
    entry = wavegen.load()["iack"]
    trace, start, end = wavegen.simulate("iack", "icarus")
    wavegen.view(trace, entry, start, end)
    text = subprocess.check_output(["fst2vcd", trace], text=True)
    there = {a + b for a, b in re.findall(r"\$var \S+ \d+ \S+ (\S+) ?(\S*) \$end", text)}
    rows = [line for line in trace.with_suffix(".gtkw").read_text().splitlines() if line[0] in "+#"]
    assert len(rows) == len(entry["signals"])
    for row in rows:
        for net in re.sub(r"\(\d+\)", "", row.partition("}")[2]).split():
            assert net.removeprefix("mmcs.") in there, row
    assert "#{A03-A01} (12)mmcs.vme_a_i[15:1] (13)" in "\n".join(rows)
