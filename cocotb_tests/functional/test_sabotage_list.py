# SPDX-License-Identifier: Apache-2.0
"""The list of breakages fits the RTL and the tests of now, and the manual shows it.

That each one is caught is for `make sabotage`; this only keeps the list from going stale.
"""

import sys

import pytest

from cocotb_tests.lib.runner import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import breakage  # noqa: E402
import sabotage  # noqa: E402
from pages import part  # noqa: E402

ENTRIES = breakage.entries(sabotage.LIST)


def test_one_line_breaks_in_a_copy(tmp_path):
    entry = ENTRIES[0]
    assert breakage.broken(entry, tmp_path / "copy") is None
    assert entry["replace"] in (tmp_path / "copy" / entry["file"]).read_text()
    assert "stands 0 times" in breakage.broken(entry | {"find": "no such text"}, tmp_path / "copy")


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda e: e["name"])
def test_breakage_applies_and_its_test_exists(entry):
    text = (ROOT / entry["file"]).read_text()
    assert text.count(entry["find"]) == 1, (
        f"{entry['file']} changed: adapt cocotb_tests/sabotage.toml"
    )
    assert entry["find"] != entry["replace"]
    for test in entry["test"].split():
        file, _, name = test.partition("::")
        function = name.split("/")[0].split("[")[0]
        assert f"def {function}(" in (ROOT / file).read_text(), test


def test_names_are_unique():
    assert len({e["name"] for e in ENTRIES}) == len(ENTRIES)


def test_every_block_is_broken_twice():
    files = [e["file"] for e in ENTRIES]
    assert {f for f in files if files.count(f) < 2} == set()


def test_the_manual_shows_the_list():
    shown = part(sabotage.PAGE.read_text(), "breakages")
    told = "docs/evidence/verification.md is stale: python tools/sabotage.py --table"
    assert shown == sabotage.table(ENTRIES) + "\n", told
