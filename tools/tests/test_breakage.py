# SPDX-License-Identifier: Apache-2.0
"""The list of breakages fits the RTL and the tests of now, and the manual's example is a test.

That each one is caught is for `make sabotage`; this only keeps the list from going stale.
"""

import pytest

from mmcs import ROOT
from tools.breakage import firmware_mutants as mutants
from tools.breakage import mutate
from tools.breakage import run as breakage

ENTRIES = breakage.entries("tests")
EVERY = {e["name"]: e for kind in breakage.KINDS for e in breakage.entries(kind)}


def test_one_line_breaks_in_a_copy(tmp_path):
    entry = ENTRIES[0]
    assert breakage.broken(entry, tmp_path / "copy") is None
    assert entry["replace"] in (tmp_path / "copy" / entry["file"]).read_text()
    assert "stands 0 times" in breakage.broken(entry | {"find": "no such text"}, tmp_path / "copy")


@pytest.mark.parametrize("entry", EVERY.values(), ids=lambda e: e["name"])
def test_breakage_applies_and_its_test_exists(entry):
    text = (ROOT / entry["file"]).read_text()
    assert text.count(entry["find"]) == 1, (
        f"{entry['file']} changed: adapt tools/breakage/list.toml"
    )
    assert entry["find"] != entry["replace"]
    if "unit" in entry:
        program, name = entry["unit"].split()
        text = (ROOT / "firmware" / "tests" / f"{program}.c").read_text()
        assert f"TEST({name}" in text, entry["unit"]
    for test in (entry.get("test", "") + entry.get("served", "")).split():
        file, _, name = test.partition("::")
        function = name.split("/")[0].split("[")[0]
        assert f"def {function}(" in (ROOT / file).read_text(), test


def test_names_are_unique():
    text = breakage.LIST.read_text()
    assert len(EVERY) == text.count("\nfind = ")


def test_every_block_is_broken_twice():
    files = [e["file"] for e in ENTRIES if "test" in e]
    assert {f for f in files if files.count(f) < 2} == set()


def test_the_manual_shows_a_test_as_it_is():
    page = (ROOT / "docs" / "evidence" / "verification.md").read_text()
    example = page.partition("```python\n")[2].partition("```")[0]
    assert example in (ROOT / "cocotb_tests" / "system" / "cocotb_vme.py").read_text()
    assert "async def address_modifiers(" in example


def test_a_broken_driver_is_noticed_and_a_whole_one_is_not(tmp_path):
    (entry,) = breakage.entries("tests", "a monitor may change the machine")
    for replace, complaint in ((entry["replace"], None), (entry["find"], "the test stays green")):
        entry["replace"] = replace
        assert breakage.broken(entry, tmp_path / "copy", breakage.PARTS["unit"]) is None
        assert breakage.driver(entry, tmp_path / "copy")[0] == complaint


@pytest.mark.parametrize(
    "line, to, same",
    [
        ("return 1;", "return (1+1);", True),
        ("x->lost = 1;", "x->lost = -1;", True),
        ("x->lost = 1;", "x->lost = 0;", False),
        ("if (n == 0) return;", "if (n <= 0) return;", True),
        ("if (n == 0) return;", "if (n != 0) return;", False),
        ("if (a < b || c == 0) go();", "if (a < b || c >= 0) go();", True),
        ("if (a < b) go();", "if (a <= b) go();", False),
        ("} else if (b) {", "}  if (b) {", True),
        ("found = 1; }", "continue; }", True),
    ],
)
def test_mutants_that_are_no_change_are_not_made(line, to, same):
    assert mutants.is_same(line, to) == same


@pytest.mark.parametrize("entry", mutate.explained(), ids=lambda e: f"{e['module']} {e['match']}")
def test_the_excuses_of_the_rtl_are_of_lines_that_stand_there(entry):
    """The whole line, as reason() of mutate.py compares it."""
    (file,) = (ROOT / "rtl").rglob(f"{entry['module']}.sv")
    lines = [line.strip() for line in file.read_text().splitlines()]
    assert entry.get("line", lines[0]) in lines, f"{file.name} changed: adapt {mutate.EXPLAINED}"


def test_the_excuses_are_of_lines_that_stand_there():
    for file, function, line, changes, why in mutants.tomllib.loads(mutants.EQUIVALENT.read_text())[
        "mutants"
    ]:
        text = " ".join((mutants.MC / file).read_text().split())
        assert line in text and f"{function}(" in text and changes and why, (file, line)
        assert not [to for to in changes if mutants.is_same(line, to)], (file, line)
