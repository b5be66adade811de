# SPDX-License-Identifier: Apache-2.0
"""mmcs.core is the one list: of the testbench's files, of each chip's."""

from pathlib import Path

from mmcs import ROOT
from tools.sources import made_of, manifest, sources


def test_the_testbench_lists_the_same_files():
    listed = (ROOT / "sim/dpi/mmcs_tb.f").read_text().splitlines()
    files = [str(f) for name in ("rtl", "checkers") for f in sources(name, Path())]
    assert [line for line in listed if line.startswith("rtl/")] == files


def test_a_chip_has_what_it_is_made_of():
    sets = manifest()["filesets"]
    benches = [Path(file).stem for file in sets["benches"]["files"]]
    for chip in (name.removesuffix("_tb") for name in benches if name.endswith("_tb")):
        assert sets[chip]["files"] == [str(f) for f in made_of(chip)]
