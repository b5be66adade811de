# SPDX-License-Identifier: Apache-2.0
"""No suite of the Makefile is unseen: .ci/run runs each."""

import importlib.metadata
import json
import os
import re
import sys
import tempfile
import tomllib
from pathlib import Path

import pytest
from packaging.specifiers import SpecifierSet

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


def suites(makefile: str) -> set[str]:
    """Targets that are called a test, or whose recipe runs pytest."""
    found = set(MORE)
    text = makefile.replace("\\\n", " ")
    for target, recipe in re.findall(r"^([a-z][\w-]*):(?!=).*\n((?:\t.*\n)*)", text, re.M):
        if re.search(r"(^|-)test(-|$)", target) or "pytest" in recipe:
            found.add(target)
    return found - set(OTHERWISE)


def run_by(script: str) -> list[str]:
    """The suites of .ci/run, those of one share among them."""
    every = re.search(r"^suites=\(\n(.*?)^\)", script, re.M | re.S)[1]
    once = re.search(r"^declare -A whole=\((.*)\)", script, re.M)[1]
    return re.findall(r'"([\w-]+)[^"]*"', every + once)


def test_every_suite_is_run():
    makefile = (ROOT / "Makefile").read_text()
    names = run_by((ROOT / ".ci" / "run").read_text())
    assert sorted(names) == sorted(suites(makefile))
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
    pass

def test_quick():
    pass
"""


def test_every_slow_test_is_in_one_share(tmp_path):
    (tmp_path / "test_it.py").write_text(TESTS)
    (tmp_path / "conftest.py").write_text((ROOT / "conftest.py").read_text())
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:xdist"]
    found = []
    for share in map(str, range(10)):
        env = os.environ | {"SHARE": share, "PYTHONPATH": str(ROOT)}
        lines = ran(*command, cwd=tmp_path, env=env, check=True).stdout.splitlines()
        assert "test_it.py::test_quick" in lines
        found += [line for line in lines if "test_slow" in line]
    assert len(found) == len(set(found)) == 100


SKIPPED = """
import pytest

@pytest.mark.parametrize("n", range(3))
def test_of_a_tool(n):
    pytest.skip("missing; install it with: sudo apt-get install tool")
"""


@pytest.mark.parametrize("ci", ["", "true"])
def test_what_does_not_run_is_said_last_or_fails(tmp_path, ci):
    (tmp_path / "test_it.py").write_text(SKIPPED)
    (tmp_path / "conftest.py").write_text((ROOT / "conftest.py").read_text())
    env = os.environ | {"CI": ci, "PYTHONPATH": str(ROOT), "SHARE": ""}
    done = ran(sys.executable, "-m", "pytest", "-p", "no:xdist", cwd=tmp_path, env=env)
    if ci:
        assert done.returncode == 1 and "CI=true allows no skip" in done.stdout
        return
    why, tool, _ = done.stdout.splitlines()[-3:]
    assert why.startswith("3 tests did NOT run") and done.returncode == 0
    assert tool == "  3: missing; install it with: sudo apt-get install tool"


OWN = {"mmcs", "cocotbext-mmcs", "mmcs-fpga", "mmcs-bridges", "pip", "setuptools"}  # or venv's


def test_nothing_is_installed_beside_the_lock():
    """And the wheel's list of what others made has it all, and their licences."""
    with tempfile.TemporaryDirectory() as name:
        library = Path(name) / "some"
        library.mkdir()
        (library / "package.json").write_text('{"name": "s", "version": "1", "license": "MIT"}')
        (library / "LICENSE").write_text("Permission is granted")
        sbom.write(Path(name), Path(name))
        bom = json.loads((Path(name) / sbom.SBOM).read_text())
        notices = (Path(name) / sbom.NOTICES).read_text()
    listed = {part["purl"]: part for part in bom["components"]}
    assert all(part["externalReferences"][0]["hashes"] for part in listed.values())
    assert all(part["bom-ref"] == purl for purl, part in listed.items())
    assert "s 1, MIT" in notices and "Permission is granted" in notices
    assert "Verilator" in notices and len(notices) > 2000
    assert any(purl.startswith("pkg:npm/uplot@") for purl in listed)
    names = {purl.lower().replace("_", "-").replace(".", "-") for purl in listed}
    beside = [
        f"{d.name} {d.version}"
        for d in importlib.metadata.distributions()
        if d.name not in OWN
        and re.sub(r"[._]", "-", f"pkg:pypi/{d.name}@{d.version}".lower()) not in names
    ]
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
