# SPDX-License-Identifier: Apache-2.0
"""No folder grows beyond tools/sizes.toml, whose folders are the whole tree."""

import sys
import tomllib

from tools import sizes
from tools.compiled import ran


def test_no_folder_has_grown():
    done = ran(sys.executable, "tools/sizes.py")
    assert done.returncode == 0, f"{done.stderr}say in the commit why the table is raised"


def test_each_line_is_counted_once():
    folders = tomllib.loads(sizes.TABLE.read_text()).values()
    assert sum(sizes.lines(folder["paths"]) for folder in folders) == sizes.lines(["."])
