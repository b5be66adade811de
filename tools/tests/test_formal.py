# SPDX-License-Identifier: Apache-2.0
"""tools/formal.py without its provers: what it reads in logs, and that its files fit together."""

import pytest

from mmcs import ROOT
from tools import formal

GROUPS = formal.groups()


def read(text: str, mode: str = "prove") -> formal.Result:
    result = formal.Result("g", mode, mode, 8, "ERROR", 0.0)
    formal.read_log(text, result)
    return result


def test_a_proof_that_holds():
    result = read("SBY [g] summary: successful proof by k-induction.\nSBY [g] DONE (PASS, rc=0)\n")
    assert result.status() == "proved unbounded"


def test_the_command_by_hand_names_the_tools_that_ours_names():
    page = " ".join((ROOT / "docs" / "evidence" / "formal.md").read_text().split())
    assert f"yowasp-sby {' '.join(formal.TOOLS).replace(str(ROOT), '$PWD')} -f" in page


def test_a_counter_example_names_its_property():
    log = "SBY ##   0:00:00  Assert failed in g_props: LoopPanics\nSBY [g] DONE (FAIL, rc=2)\n"
    result = read(log)
    assert (result.status(), result.failed) == ("FAIL", ["LoopPanics"])


def test_a_bound_is_said():
    assert read("DONE (PASS, rc=0)", "bmc").status() == "bounded to 8 clocks"


def test_covers_reached_and_not():
    result = read(
        "##   0:00:00  Reached cover statement in step 5 at top: A_when\n"
        "##   0:00:00  Reached cover statement in step 9 at top: B_when\n"
        "##   0:00:00  Unreached cover statement at top: C_when\n"
        "DONE (FAIL, rc=2)",
        "cover",
    )
    assert result.reached == {"A_when": 5, "B_when": 9}
    assert result.missed == ["C_when"]
    assert result.status() == "FAIL"


def test_no_verdict_is_an_error():
    result = read("ERROR: something\n")
    assert (result.verdict, result.note) == ("ERROR", "ERROR: something")


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
