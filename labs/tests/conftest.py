# SPDX-License-Identifier: Apache-2.0
"""Each lab sheet, and the sheet of a teacher's own that README.md shows."""

import re

import pytest

from mmcs_labs.sheets import LABS, sheets


@pytest.fixture(params=sheets(), ids=lambda sheet: sheet.name)
def sheet(request):
    return request.param


@pytest.fixture
def own_sheets(tmp_path):
    folder = tmp_path / "sheets" / "01_gain"
    folder.mkdir(parents=True)
    page = (LABS.parent / "README.md").read_text()
    for name, body in re.findall(r"^```\w+ (\w+\.\w+)\n(.*?)^```", page, re.M | re.S):
        (folder / name).write_text(body)
    (folder / "sheet.md").write_text("# A gain\n")
    return tmp_path / "sheets"
