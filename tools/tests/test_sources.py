# SPDX-License-Identifier: Apache-2.0
"""mmcs.core is the one list: of the testbench's files, of each chip's."""

from pathlib import Path

from mmcs import ROOT
from tools import slang
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


def test_an_error_of_slang_is_told(tmp_path):
    """A port that is not there parses; only elaboration finds it."""
    file = tmp_path / "wrong.sv"
    file.write_text("module a(input logic x); endmodule\nmodule b; a u(.y(1'b0)); endmodule\n")
    assert not slang.elaborates(str(file))
    file.write_text("module a(input logic x); endmodule\nmodule b; a u(.x(1'b0)); endmodule\n")
    assert slang.elaborates(str(file))
