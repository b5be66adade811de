# SPDX-License-Identifier: Apache-2.0
"""No folder grows beyond tools/sizes.toml."""

import sys

from tools.compiled import ran


def test_no_folder_has_grown():
    done = ran(sys.executable, "tools/sizes.py")
    assert done.returncode == 0, f"{done.stderr}say in the commit why the table is raised"
