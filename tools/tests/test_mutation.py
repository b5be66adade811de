# SPDX-License-Identifier: Apache-2.0
"""The seeded faults and the waivers fit the sources and the proofs of now. That each fault is
noticed is for `make mutation`; that each requirement has one, for tools/trace.py."""

import re

import pytest

from mmcs import ROOT
from tools import formal
from tools.mutation import code, faults, mutate

FAULTS = faults.read()[0]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f["name"])
def test_a_fault_has_its_place(fault):
    assert (ROOT / fault["file"]).read_text().count(fault["find"]) == 1, "adapt faults.toml"
    assert fault["find"] != fault["replace"] and ("req" in fault) == ("test" in fault)
    if about := fault.get("proof"):
        assert about.get("task", "prove") in formal.tasks(ROOT / f"formal/{about['group']}.sby")
        if wanted := about.get("property"):
            sources = [*(ROOT / "formal").glob("*.sv"), *(ROOT / "rtl/checkers").glob("*.sv")]
            assert any(re.search(rf"\b{wanted}\b", f.read_text()) for f in sources)


def test_every_group_of_proofs_has_one_fault():
    assert sorted(f["proof"]["group"] for f in FAULTS if "proof" in f) == [
        f.stem for f in formal.groups()
    ]


@pytest.mark.slow  # compiles the driver
def test_a_fault_of_the_driver_is_noticed():
    fault = next(f for f in FAULTS if f.get("req") == "DRV-3")
    assert faults.run([fault], faults.by_test) == 0
    assert faults.run([fault | {"find": "no such text"}], faults.by_test) == 1


@pytest.mark.parametrize("name", ["firmware/mc/timer.c", "mmcs/runs/expect.py", "web/samples.js"])
def test_mutants_of_a_file_are_the_same_each_time_and_some_build(name):
    made, text = code.mutants(name), (ROOT / name).read_text()
    assert (ROOT / code.files()[name].partition("::")[0]).is_file()
    assert len(made) > 100 and made == code.mutants(name)
    assert text not in {mutant["text"] for mutant in made}
    assert code.builds({"file": name, "text": text}) == (not name.endswith(".py"))
    assert {code.builds(mutant) for mutant in made[:20]} == {True, False}


@pytest.mark.parametrize("entry", mutate.waivers(), ids=lambda e: f"{e['module']} {e['match']}")
def test_a_waiver_is_of_a_line_that_stands_there(entry):
    (file,) = (ROOT / "rtl").rglob(f"{entry['module']}.sv")
    lines = [line.strip() for line in file.read_text().splitlines()]
    assert entry.get("line", lines[0]) in lines, f"{file.name} changed: adapt {mutate.WAIVERS}"
