# SPDX-License-Identifier: Apache-2.0
"""The largest axis count that the page tells is so. §5"""

import pytest
from needed import needs

from mmcs import ROOT
from studies.processors import limits
from tools.pages import part

pytestmark = pytest.mark.req("FW-1")


def page() -> dict[str, dict[str, str]]:
    """By the name of its row and of its column: a cell of the page's table."""
    text = (ROOT / "docs" / "simulator" / "processors.md").read_text()
    lines = [line for line in part(text, "limits").splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[0]: dict(zip(rows[0], row, strict=True)) for row in rows[2:]}


@needs("m68020")
def test_boundary_of_the_page_is_real():
    """At 1 kHz the 68020 carries what the page says, and two axes more make it overrun."""
    case = limits.CASES[0]
    most = int(page()[str(case)]["1000 Hz"])
    inside, outside = (limits.run(case, axes, 1000) for axes in (most, most + 2))
    assert inside.good and inside.overruns == inside.missed == 0 and not inside.refused
    assert not outside.good and outside.overruns > 0
    assert inside.longest_us < outside.longest_us
