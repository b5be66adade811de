# SPDX-License-Identifier: Apache-2.0
"""No suite of the Makefile is unseen: .ci/run runs each."""

import importlib.metadata
import re
import tomllib

import pytest
from packaging.specifiers import SpecifierSet

from mmcs import ROOT

# Not suites of their own, and why.
OTHERWISE = {
    "test-all": "runs .ci/run",
    "test-fast": "a part of test",
    "test-loaded": "test, beside busy loops",
    "cocotb": "a part of test; SIM=icarus is test-icarus",
}
# Suites that their name does not tell.
MORE = {"lint", "sim", "firmware", "formal", "mutation"}


def suites(makefile: str) -> set[str]:
    """Targets that are called a test, or whose recipe runs pytest."""
    found = set(MORE)
    text = makefile.replace("\\\n", " ")
    for target, recipe in re.findall(r"^([a-z][\w-]*):(?!=).*\n((?:\t.*\n)*)", text, re.M):
        if re.search(r"(^|-)test(-|$)", target) or "pytest" in recipe:
            found.add(target)
    return found - set(OTHERWISE)


def run_by(script: str) -> list[str]:
    """The targets in the list of .ci/run."""
    table = re.search(r"^suites=\(\n(.*?)^\)", script, re.M | re.S)[1]
    return re.findall(r'^ *"([\w-]+)[^"]*"', table, re.M)


def unseen(makefile: str, script: str) -> set[str]:
    return suites(makefile) - set(run_by(script))


MAKEFILE = (ROOT / "Makefile").read_text()
SCRIPT = (ROOT / ".ci" / "run").read_text()


def test_every_suite_is_run():
    missing = unseen(MAKEFILE, SCRIPT)
    assert not missing, f"suites that .ci/run does not run: {', '.join(sorted(missing))}"
    names = run_by(SCRIPT)
    assert len(names) == len(set(names)), "a suite stands twice in .ci/run"
    for name in (*names, *OTHERWISE):
        assert re.search(rf"^{name}:", MAKEFILE, re.M), f"the Makefile has no target {name}"


@pytest.mark.parametrize("name", run_by(SCRIPT))
def test_a_suite_that_is_left_out_is_missed(name):
    without = re.sub(rf'^  "{name}( [^"]*)?"\n', "", SCRIPT, flags=re.M)
    assert unseen(MAKEFILE, without) == {name}


@pytest.mark.parametrize(
    "rule",
    [
        "new-test: x ## text\n\t@true\n",
        "test-new: x\n\t@true\n",
        "dpi: x ## text\n\t@need x\n\t@$(BIN)/python \\\n\t    -m pytest sim/dpi\n",
    ],
)
def test_a_new_suite_is_missed(rule):
    assert unseen(MAKEFILE + rule, SCRIPT) == {rule.partition(":")[0]}


def test_a_sample_is_fixed_and_whole_in_test_all():
    """What .ci/run shortens it shortens by FAST=1 alone, which --all takes away."""
    listed = re.search(r"^suites=\(\n(.*?)^\)", SCRIPT, re.M | re.S)[1]
    for name, words in re.findall(r'^ *"([\w-]+)([^"]*)"', listed, re.M):
        assert words in ("", " FAST=1"), f".ci/run: {name}{words}"
    assert "suites%" not in SCRIPT and '"${suites[@]% FAST=1}"' in SCRIPT
    assert re.search(r"^test-all:.*\n\t@\.ci/run --all$", MAKEFILE, re.M)


def test_every_package_takes_the_least_python():
    """What is installed here installs with the oldest Python of pyproject.toml, too."""
    least = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["requires-python"]
    oldest = least.removeprefix(">=") + ".0"
    refused = [
        f"{d.name} {d.version} wants Python {wanted}"
        for d in importlib.metadata.distributions()
        if (wanted := d.metadata.get("Requires-Python")) and oldest not in SpecifierSet(wanted)
    ]
    assert not refused, "pin older versions in requirements.lock"
