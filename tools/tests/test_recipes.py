# SPDX-License-Identifier: Apache-2.0
"""The recipes of CONTRIBUTING.md: done whole in a copy of the checkout their tests are green; with
any step left out, a test of the row that the recipe names is red and names the place.

The row of an input or a request is compiled by no test here: without it the rest does not compile.
"""

import os
import re
import shutil
import subprocess
import sys
from contextlib import contextmanager, suppress
from typing import NamedTuple

import pytest

from mmcs import ROOT
from tools.compiled import ran

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("recipes")]  # some 30 starts of pytest
PAGE = (ROOT / "CONTRIBUTING.md").read_text().partition("## How to add")[2]

SHEET = "docs/labs/11_heat"  # the new one
GENERATE, TABLES = "rtl/regs/generate.py", "tools/tables.py"
GENERATED = (
    "rtl/regs/mmcs_regs_pkg.sv", "firmware/include/mmcs_regs.h", "docs/hardware/registers.md",
    "web/registers_table.js", "docs/use/scenarios.md", "firmware/include/mcdef.h",
    "docs/use/driver.md", "docs/man/mc.4",
)  # fmt: skip


class Step(NamedTuple):
    file: str
    before: str  # the text of the file in whose place `text` comes; "": a new file
    text: str
    test: str  # red without this step
    says: str  # and why


def behind(file, line, text, test, says):
    return Step(file, line, f"{line}{text}", test, says)


CLOSED_LOOP = "mmcs/tests/test_closed_loop.py::"
REQUESTS, REGS = "mmcs/tests/test_requests.py::", "mmcs/tests/test_regs.py::"
LABS, SCENARIOS = "mmcs/tests/test_labs.py::", "mmcs/tests/test_scenarios.py::"


def sheet(name, text, says, test="test_no_sheet_is_half_there"):
    return Step(name, "", text, LABS + test, says)


RECIPES = {
    "a fault": [
        Step(
            "sim/scenarios/faults/fault_heat.toml",
            "",
            'description = "Heat"\nextends = "arm_move"\n'
            '[fault]\nname = "Heat"\nwhy = "It is hot."\n'
            '[[event]]\nat = 0.1\ninput = "amp_dead"\nvalue = 1\n',
            f"{SCENARIOS}test_fault_table_has_every_fault",
            "fault_heat: is not there",
        ),
        Step(
            "docs/evidence/faults.md",
            "## Why\n",
            "| Heat | - |\n\n## Why\n\n* **Heat** (`fault_heat`). It is hot.\n",
            f"{SCENARIOS}test_fault_table_has_every_fault",
            "fault_heat: run `python -m studies.faults`",
        ),
    ],
    "an input": [
        behind("sim/abi/inputs.def", '"1: the shaft is blocked")\n',
               'PLANT(kMotorHeat, "motor_heat", kAxis, 0, 1, 0, "each", "pin", "hot")\n', "", ""),
        behind("sim/plant/axis.cpp", '#include "axis.h"\n', "// kMotorHeat\n",
               f"{CLOSED_LOOP}test_every_input_has_its_effect", "sim/plant/axis.cpp: kMotorHeat"),
        Step(TABLES, "", "", f"{REQUESTS}test_tables_are_fresh",
             "is stale; run `make generate`"),
    ],
    "a request of the driver": [
        behind("firmware/include/requests.def", '"what MSETVERBOSITY has set")\n',
               'REQUEST(MGETHEAT, 20, "int", out, get_num_cards, 0, 0, 0, "heat")\n', "", ""),
        Step(TABLES, "", "", f"{REQUESTS}test_tables_are_fresh", "run `make generate`"),
        behind("firmware/tests/test_requests.c", "{MCALIB, 4, 0}", ", {MGETHEAT, 0, 4}",
               f"{REQUESTS}test_every_request_has_a_test", "no test of MGETHEAT"),
        behind("docs/use/driver.md", "\n```c\n/* MCALIB", ", MGETHEAT",
               f"{REQUESTS}test_every_request_has_an_example", "no example of MGETHEAT"),
    ],
    "a register bit": [
        behind("rtl/regs/mmcs.rdl", "clears the index latches.\";} INDEX_EN[4:4];\n",
               '    field {desc = "Heat.";} HEAT[5:5];\n',
               f"{REGS}test_nothing_else_is_on_the_map", "mmcs.rdl and this file's BITS"),
        Step(GENERATE, "", "", f"{REGS}test_what_is_generated_is_fresh",
             "is stale; run `make generate`"),
        behind("mmcs/tests/test_regs.py", '"CARD_PPI_B_INDEX_EN": (4, 4),',
               ' "CARD_PPI_B_HEAT": (5, 5),',
               f"{REGS}test_nothing_else_is_on_the_map", "mmcs.rdl and this file's BITS"),
        behind("rtl/mark1/mark1.sv", "endmodule", "  // CARD_PPI_B_HEAT",
               f"{REGS}test_the_hardware_uses_every_bit", "nothing in rtl/ uses CARD_PPI_B_HEAT"),
    ],
    "a lab sheet": [
        sheet(f"{SHEET}/sheet.md",
              "# Heat\n\n**Goal.** g\n\n## Steps\n\n## Questions\n\n1.  `t` (9 points). q\n"
              "2.  `u` (1 point). q\n\n`mmcs lab check 11 answer.toml` grades.\n",
              "docs/labs: a folder without sheet.md"),
        sheet(f"{SHEET}/answer.toml", "# t = 1\n# u = 1\n",
              "a sheet needs a file answer.toml", "test_the_sheet_asks_what_is_graded[heat]"),
        Step("docs/labs/README.md", "\nThe grader",
             "| [11](11_heat/sheet.md) | heat |\n\nThe grader",
             f"{LABS}test_no_sheet_is_half_there", "docs/labs/README.md"),
        sheet(f"{SHEET}/grader.py",
              "from mmcs.lab.marks import Question\nfrom mmcs.scenario.schema import Strict\n\n\n"
              "class Answer(Strict):\n    t: int | None = None\n    u: int | None = None\n\n\n"
              "QUESTIONS = (Question('t', 9, None), Question('u', 1, None))\n",
              "a sheet needs a file grader.py", "test_the_sheet_asks_what_is_graded[heat]"),
        sheet(f"{SHEET}/tests/good.toml", "t = 1\n", "11_heat/tests"),
        sheet(f"{SHEET}/tests/bad.toml", "t = 0\n", "11_heat/tests"),
    ],
}  # fmt: skip
CASES = [(recipe, step) for recipe, steps in RECIPES.items() for step in steps if step.test]


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The checkout's own files."""
    to = tmp_path_factory.mktemp("copy")
    listed = ran("git", "ls-files", "-co", "--exclude-standard", check=True).stdout
    for name in listed.splitlines():
        if (ROOT / name).is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, to / name)
    return to


@contextmanager
def carried_out(copy, steps):
    """The steps, undone afterwards."""
    files = {copy / file for step in steps for file in (step.file, *GENERATED)}
    kept = {path: path.read_text() if path.is_file() else None for path in files}
    try:
        for step in steps:
            path = copy / step.file
            if step.file in (GENERATE, TABLES):
                subprocess.run([sys.executable, path], check=True)
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            whole = path.read_text() if path.is_file() else ""
            assert step.before in whole, f"{step.file} has changed: no {step.before!r}"
            path.write_text(whole.replace(step.before, step.text, 1))
        yield
    finally:
        for path, text in kept.items():
            if text is not None:
                path.write_text(text)
            elif path.is_file():
                path.unlink()
                with suppress(OSError):  # not empty
                    os.removedirs(path.parent)


def red(copy, tests):
    """Whether pytest fails in the copy, and what it says."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", "-o",
               "addopts=", "--tb=short", "-q", *tests]  # fmt: skip
    environment = {n: value for n, value in os.environ.items() if not n.startswith("PYTEST_")}
    done = ran(*command, cwd=copy, env=environment)
    return done.returncode != 0, done.stdout + done.stderr


@pytest.mark.parametrize("recipe", RECIPES)
def test_the_whole_recipe_is_green(copy, recipe):
    with carried_out(copy, RECIPES[recipe]):
        failed, said = red(copy, sorted({step.test for step in RECIPES[recipe]} - {""}))
    assert not failed, said


@pytest.mark.parametrize(
    "recipe, step", CASES, ids=[f"{r.split()[-1]}-{s.file}-{n}" for n, (r, s) in enumerate(CASES)]
)
def test_a_step_left_out_is_red_and_named(copy, recipe, step):
    with carried_out(copy, [other for other in RECIPES[recipe] if other is not step]):
        failed, said = red(copy, [step.test])
    assert failed and step.says in said, said


@pytest.mark.parametrize("recipe", RECIPES)
def test_the_recipe_names_its_files_and_its_row(recipe):
    text = " ".join(PAGE.partition(f"**{recipe}")[2].partition("\n**")[0].split())
    told = re.findall(r"`([^`]*)`", text)
    row = re.search(r"Run `pytest ([^`]*)`", text)[1]
    word = re.search(r"-k (\w+)|$", row)[1] or ""
    for step in RECIPES[recipe]:
        folder, _, name = (
            step.file.replace("11_heat", "NN_name").replace("heat", "name").rpartition("/")
        )
        whole = f"{folder}/{name}" in told or folder in map(lambda t: t.rstrip("/"), told)
        assert whole or name in told, f"{recipe}: {step.file} is not told"
        file, _, test = step.test.partition("::")
        assert not test or (file in row and word in test), (
            f"{recipe}: {step.test} is not in its row"
        )
