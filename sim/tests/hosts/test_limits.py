# SPDX-License-Identifier: Apache-2.0
"""The table of the largest axis count and rate: how it is found, and that it is so. §5"""

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


class Thing:
    """Good up to some n of low..high; remembers who looked."""

    def __init__(self, low, high, true):
        self.low, self.high, self.true, self.seen = low, high, true, []

    def good(self, n):
        assert self.low <= n <= self.high and n not in self.seen
        self.seen.append(n)
        return n <= self.true


@pytest.mark.parametrize("low,high", [(1, 1), (1, 16), (0, 90)])
def test_edge_is_found_from_any_guess(low, high):
    """With a look at the largest good one and at the one above it, and few others."""
    for true in range(low - 1, high + 1):
        for guess in range(low - 3, high + 4):
            thing = Thing(low, high, true)
            assert limits.edge(thing.good, low, high, guess) == true
            assert {n for n in (true, true + 1) if low <= n <= high} <= set(thing.seen)
            assert len(thing.seen) <= 2 * (high - low + 1).bit_length() + 2
            if guess == true:
                assert len(thing.seen) <= 2


def test_page_agrees_with_itself():
    """A row for each processor; so many axes run at a rate that their shortest interval allows."""
    table = page()
    assert list(table) == [str(case) for case in limits.CASES]
    for name, row in table.items():
        most = [int(row[f"{rate} Hz"].replace("none", "0")) for rate in limits.RATES]
        assert most == sorted(most, reverse=True), name
        for axes in limits.SIZES:
            interval_us = int(row[f"{axes} axes"].split()[0])
            for rate, n in zip(limits.RATES, most, strict=True):
                assert (n >= axes) == (interval_us <= 1_000_000 // rate), (name, axes, rate)
    fastest, slowest = list(table.values())[0], list(table.values())[3]
    assert int(fastest["500 Hz"]) > int(slowest["500 Hz"])


@needs("m68020")
def test_boundary_of_the_page_is_real():
    """At 1 kHz the 68020 carries what the page says, and two axes more make it overrun."""
    case = limits.CASES[0]
    most = int(page()[str(case)]["1000 Hz"])
    inside, outside = (limits.run(case, axes, 1000) for axes in (most, most + 2))
    assert inside.good and inside.overruns == inside.missed == 0 and not inside.refused
    assert not outside.good and outside.overruns > 0
    assert inside.longest_us < outside.longest_us
