# SPDX-License-Identifier: Apache-2.0
"""Every assumption of a proof, and every pin it ties, stands in docs/evidence/formal.md."""

import re

import pytest

from mmcs import ROOT

PAGE = (ROOT / "docs" / "evidence" / "formal.md").read_text()
HEAD = "## What the proofs take for granted"


def rows_of(text: str) -> list[list[str]]:
    """The cells of the section's table."""
    section = text.split(HEAD, 1)[1].split("\n## ", maxsplit=1)[0]
    return [row.split("|") for row in section.splitlines() if row.startswith("|")]


def named(text: str) -> set[str]:
    """Words of the second column of the table: the names are among them."""
    return {word for row in rows_of(text) if row[3].strip() for word in re.findall(r"\w+", row[2])}


def missing(sources: dict[str, str], page: str) -> list[str]:
    """Assumptions that the page does not name, and bare ones, which have no name."""
    found = []
    for name, text in sources.items():
        given = re.findall(r"`MMCS_GIVEN\((\w+)", text)
        found += [f"{name}: {given}" for given in sorted(set(given) - named(page))]
        if re.search(r"\bassume\b", re.sub(r"//.*", "", text)) and not name.endswith(".svh"):
            found.append(f"{name}: assume without MMCS_GIVEN")
    return found


def tied(sources: dict[str, str], page: str) -> list[str]:
    """Input pins that a formal top ties to a constant and no row of its group names."""
    rows, found = rows_of(page), []
    for name, text in sources.items():
        group = name.removesuffix("_props.sv")
        listed = {w for r in rows if f"`{group}`" in r[1] for w in re.findall(r"`(\w+)`", r[2])}
        pins = re.findall(r"\.([a-z]\w+)\((?:\d*'[bdh]\w+|'[01])\)", text)
        found += [f"{group}: {pin}" for pin in sorted(set(pins) - listed)]
    return found


def proofs() -> dict[str, str]:
    return {f.name: f.read_text() for f in sorted((ROOT / "formal").glob("*.sv*"))}


def test_each_has_its_sentence():
    assert missing(proofs(), PAGE) == []


def test_each_tied_pin_is_listed():
    assert tied(proofs(), PAGE) == []


def test_a_tied_pin_without_row_is_named():
    page = f"{HEAD}\n| `new` | tied: `a_i` | - |\n"
    assert tied({"new_props.sv": ".a_i(1'b0), .b_ni(2'b11), .c_i"}, page) == ["new: b_ni"]


@pytest.mark.parametrize("line", ['`MMCS_GIVEN(NoTrouble, 1, "")', "always assume (quiet);"])
def test_one_without_is_named(line):
    assert missing({"new_props.sv": line}, PAGE)[0].startswith("new_props.sv: ")
