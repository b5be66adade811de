# SPDX-License-Identifier: Apache-2.0
"""What README shows is what happens, and what it shows is small."""

import re

import pytest

from mmcs import ROOT
from mmcs.tests.conftest import good

TEXT = (ROOT / "README.md").read_text()


def test_its_length_and_the_size_of_its_moving_picture():
    assert len(TEXT.splitlines()) <= 150
    assert 10_000 < (ROOT / "docs/images/puma560.gif").stat().st_size <= 400_000
    for word in ("DPI", "make cocotb", "ross-compile", "aveforms"):
        assert word in TEXT


def test_every_box_of_the_loop_leads_somewhere():
    picture = ROOT / "docs/images/loop.svg"
    boxes = re.findall(r'<a href="([^"]+)">', picture.read_text())
    assert len(boxes) == 10
    assert [box for box in boxes if not (picture.parent / box).is_file()] == []


@pytest.mark.slow
def test_the_output_of_make_sim(mmcs, tmp_path):
    [shown] = re.findall(r"^```text\n(.*?)^```", TEXT, re.M | re.S)
    said = good(mmcs("run", "puma560", "--out", tmp_path / "out"))
    lines = [line for line in shown.splitlines() if line != "..." and "results in" not in line]
    assert len(lines) > 3 and [line for line in lines if line not in said.splitlines()] == []
