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
    assert formal.properties(file)
    assert [name for name, *told in formal.properties(file) if not all(told)] == []
    names = [task.partition("_")[2] for task in tasks]  # of what tools/carried.py writes
    written = {f"{formal.WORK}/{name}.sv" for name in names}
    written |= {f"{formal.WORK}/part_{name.removeprefix('bits_')}.il" for name in names}
    for line in formal.text(file).partition("[files]")[2].split("\n"):
        if {"part.sv", "part.il"} & set(line.split()):
            assert line.split()[-1] in written, line
        elif line.strip():
            assert (ROOT / line.split()[-1]).is_file(), line


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
SECTION = PAGE.split("## What the proofs take for granted")[1].split("\n## ")[0]
ROWS = [row.split("|") for row in SECTION.splitlines() if row.startswith("|")]
PROOFS = {f.name: f.read_text() for f in sorted((ROOT / "formal").glob("*.sv*"))}


def test_each_assumption_has_its_sentence():
    """And none is a bare one, which has no name."""
    named = {word for row in ROWS if row[3].strip() for word in re.findall(r"\w+", row[2])}
    for name, text in PROOFS.items():
        assert set(re.findall(r"`MMCS_GIVEN\((\w+)", text)) <= named, name
        bare = re.search(r"\bassume\b", re.sub(r"//.*", "", text))
        assert not bare or name.endswith(".svh"), f"{name}: assume without MMCS_GIVEN"


def test_each_pin_that_a_formal_top_ties_to_a_constant_is_listed():
    for name, text in PROOFS.items():
        group = f"`{name.removesuffix('_props.sv')}`"
        listed = {w for r in ROWS if group in r[1] for w in re.findall(r"`(\w+)`", r[2])}
        tied = re.findall(r"\.([a-z]\w+)\((?:\d*'[bdh]\w+|'[01])\)", text)
        assert set(tied) <= listed, group
