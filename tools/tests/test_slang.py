# SPDX-License-Identifier: Apache-2.0
"""slang, which shares nothing with our other tools, accepts the testbenches and all of rtl/."""

import sys

from mmcs import ROOT
from tools import slang
from tools.compiled import ran


def test_all_of_it_elaborates():
    done = ran(sys.executable, "tools/slang.py")
    assert (done.returncode, done.stderr) == (0, "")


def test_every_file_is_among_them():
    given = {str(word) for arguments in slang.jobs().values() for word in arguments}
    listed = (ROOT / "sim/dpi/mmcs_tb.f").read_text()
    for file in (ROOT / "rtl").rglob("*.sv"):
        name = str(file.relative_to(ROOT))
        assert str(file) in given or name in listed, name


def test_an_error_is_told(tmp_path):
    """A port that is not there parses; only elaboration finds it."""
    file = tmp_path / "wrong.sv"
    file.write_text("module a(input logic x); endmodule\nmodule b; a u(.y(1'b0)); endmodule\n")
    assert not slang.elaborates([file])
    file.write_text("module a(input logic x); endmodule\nmodule b; a u(.x(1'b0)); endmodule\n")
    assert slang.elaborates([file])
