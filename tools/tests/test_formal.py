# SPDX-License-Identifier: Apache-2.0
"""tools/formal.py without its provers: files that fit together, assumptions in formal.md."""

import re

import pytest

from mmcs import ROOT
from tools import formal

GROUPS = formal.groups()


def test_the_command_by_hand_names_the_tools_that_ours_names():
    page = " ".join(PAGE.split())
    assert f"yowasp-sby {' '.join(formal.TOOLS).replace(str(ROOT), '$PWD')} -f" in page


@pytest.mark.parametrize("file", GROUPS, ids=lambda f: f.stem)
def test_a_group_is_whole(file):
    """Proves or bounds, covers, has properties with section and sentence, and all its files."""
    tasks = formal.tasks(file)
    assert any(t.startswith("cover") for t in tasks)
    assert any(t.startswith(("prove", "bmc")) for t in tasks)
    properties = formal.properties(file)
    assert properties
    for name, section, text in properties:
        assert section and text, name
    names = [task.partition("_")[2] for task in tasks]  # of what tools/carried.py writes
    written = {f"{formal.WORK}/{name}.sv" for name in names}
    written |= {f"{formal.WORK}/part_{name.removeprefix('bits_')}.il" for name in names}
    for line in formal.text(file).partition("[files]")[2].split("\n"):
        if {"part.sv", "part.il"} & set(line.split()):
            assert line.split()[-1] in written, line
        elif line.strip():
            assert (ROOT / line.split()[-1]).is_file(), line


def test_a_file_that_is_not_there_is_named(tmp_path):
    group = tmp_path / "group.sby"
    group.write_text("[options]\n\n[script]\nread_verilog -sv {no_such_module}\n")
    with pytest.raises(SystemExit, match=r"group.sby reads 'no_such_module', which is not there"):
        formal.text(group)


@pytest.mark.parametrize(
    ("script", "verdict"),
    [("sleep 2; echo 'DONE (PASS, rc=0)'", "PASS"), ("while :; do :; done", "TIMEOUT")],
)
def test_the_limit_is_of_processor_time(tmp_path, monkeypatch, script, verdict):
    """A prover that waits for a busy machine goes on, one that computes for longer ends."""
    prover = tmp_path / "yowasp-sby"
    prover.write_text(f"#!/bin/sh\n{script}\n")
    prover.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr(formal, "LIMIT_S", 1)
    assert formal.run(ROOT / "formal" / "oneshot.sby", "prove", tmp_path).verdict == verdict


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
