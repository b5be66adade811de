# SPDX-License-Identifier: Apache-2.0
"""No suite of the Makefile is unseen: .ci/run runs each."""

import importlib.metadata
import json
import os
import re
import sys
import tomllib

import pytest
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

from mmcs import ROOT
from tools import sbom
from tools.compiled import ran

# Not suites of their own, and why.
OTHERWISE = {
    "test-all": "runs .ci/run",
    "attack": "tests of test, and damaged inputs",
    "test-fast": "a part of test",
    "cocotb": "a part of test; SIM=icarus is test-icarus",
}
# Suites that their name does not tell.
MORE = {"lint", "sim", "firmware", "formal", "mutation"}


def test_every_suite_is_run():
    """Targets that are called a test, or whose recipe runs pytest."""
    makefile, script = ((ROOT / name).read_text() for name in ("Makefile", ".ci/run"))
    every = re.search(r"^suites=\(\n(.*?)^\)", script, re.M | re.S)[1]
    once = re.search(r"^declare -A whole=\((.*)\)", script, re.M)[1]  # in one share
    names = re.findall(r'"([\w-]+)[^"]*"', every + once)
    rules = re.compile(r"^([a-z][\w-]*):(?!=).*\n((?:\t.*\n)*)", re.M)
    suites = {target for target, recipe in rules.findall(makefile.replace("\\\n", " "))
              if re.search(r"(^|-)test(-|$)", target) or "pytest" in recipe}  # fmt: skip
    assert sorted(names) == sorted((suites | MORE) - set(OTHERWISE))
    for name in (*names, *OTHERWISE):
        assert re.search(rf"^{name}:", makefile, re.M), f"the Makefile has no target {name}"


def test_what_runs_there_is_pinned_and_everything_runs_each_night():
    flows = {path.stem: path.read_text() for path in (ROOT / ".github/workflows").glob("*.yml")}
    for name, text in flows.items():
        for action in re.findall(r"uses: (.*)", text):
            assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v[\d.]+", action), (
                f"{name}: {action}"
            )
    assert "schedule:" in flows["nightly"] and "run: make test-all" in flows["nightly"]
    assert all("run: make release" in flows[name] for name in ("ci", "nightly"))
    named = re.findall(r"Python :: (3\.\d+)", (ROOT / "pyproject.toml").read_text())
    assert named and f"python: {json.dumps(named)}" in flows["nightly"]


TESTS = """
import pytest

@pytest.mark.parametrize("n", range(100))
@pytest.mark.slow
def test_slow(n):
    pytest.skip("missing; install it with: sudo apt-get install tool")

def test_quick():
    pass
"""


@pytest.fixture
def tests(tmp_path):
    """TESTS by pytest, as conftest.py has it: what it says."""
    (tmp_path / "test_it.py").write_text(TESTS)
    (tmp_path / "conftest.py").write_text((ROOT / "conftest.py").read_text())
    command = (sys.executable, "-m", "pytest", "-p", "no:xdist")

    def run(*options, **variables):
        env = os.environ | {"PYTHONPATH": str(ROOT)} | variables
        return ran(*command, *options, cwd=tmp_path, env=env)

    return run


def test_every_slow_test_is_in_one_share(tests):
    found = []
    for share in map(str, range(10)):
        lines = tests("--collect-only", "-q", SHARE=share).stdout.splitlines()
        assert "test_it.py::test_quick" in lines
        found += [line for line in lines if "test_slow" in line]
    assert len(found) == len(set(found)) == 100


@pytest.mark.parametrize("ci", ["", "true"])
def test_what_does_not_run_is_said_last_or_fails(tests, ci):
    done = tests(CI=ci, SHARE="3")
    if ci:
        assert done.returncode == 1 and "CI=true allows no skip" in done.stdout
        return
    why, tool, _ = done.stdout.splitlines()[-3:]
    assert why.startswith("10 tests did NOT run") and done.returncode == 0
    assert tool == "  10: missing; install it with: sudo apt-get install tool"


OWN = {"mmcs", "cocotbext-mmcs", "mmcs-fpga", "mmcs-bridges", "pip", "setuptools"}  # or venv's


def test_nothing_is_installed_beside_the_lock(tmp_path):
    """And the wheel's list of what others made has it all, and their licences."""
    (library := tmp_path / "some").mkdir()
    (library / "package.json").write_text('{"name": "s", "version": "1", "license": "MIT"}')
    (library / "LICENSE").write_text("Permission is granted")
    sbom.write(tmp_path, tmp_path)
    bom = json.loads((tmp_path / sbom.SBOM).read_text())
    notices = (tmp_path / sbom.NOTICES).read_text()
    listed = {part["purl"]: part for part in bom["components"]}
    assert all(part["externalReferences"][0]["hashes"] for part in listed.values())
    assert all(part["bom-ref"] == purl for purl, part in listed.items())
    assert "s 1, MIT" in notices and "Permission is granted" in notices
    assert "Verilator" in notices and len(notices) > 2000
    assert any(purl.startswith("pkg:npm/uplot@") for purl in listed)
    names = {(canonicalize_name(part["name"]), part["version"]) for part in listed.values()}
    found = [d for d in importlib.metadata.distributions() if d.name not in OWN]
    beside = {(canonicalize_name(d.name), d.version) for d in found} - names
    assert not beside, "a name and its version in requirements.lock; CONTRIBUTING tells how"


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
