# SPDX-License-Identifier: Apache-2.0
"""Tests that share something costly run in one worker: xdist's groups are heeded.

With pytest 9.2 the pytest-xdist of the lock file loses them without a word: then every worker
makes the fixtures of a module, and simulates each bench of cocotb, for itself.
"""

import os
import re
import sys

from mmcs import ROOT
from tools.compiled import ran

TESTS = """
import pytest

@pytest.fixture(scope="module")
def costly():
    return 1

@pytest.mark.parametrize("n", range(8))
def test_shares(n, costly):
    pass

@pytest.mark.xdist_group("a")
@pytest.mark.parametrize("n", range(8))
def test_of_a_group(n):
    pass
"""


def pytest_in(folder, tests, *options):
    (folder / "test_it.py").write_text(tests)
    (folder / "conftest.py").write_text((ROOT / "conftest.py").read_text())
    kept = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    return ran(sys.executable, "-m", "pytest", *options, cwd=folder, env=kept)


def test_groups_stay_together(tmp_path):
    done = pytest_in(tmp_path, TESTS, "-n", "2", "--dist", "loadgroup", "-v")
    assert done.returncode == 0, done.stdout + done.stderr
    for name in ("test_shares", "test_of_a_group"):
        workers = re.findall(rf"\[(gw\d)\].* PASSED \S+{name}", done.stdout)
        assert len(workers) == 8, done.stdout
        assert len(set(workers)) == 1, f"{name} ran in {workers}"


def test_a_group_that_xdist_would_not_see_is_refused(tmp_path):
    """Each bench of cocotb was simulated by every worker: their groups' names ended with ]."""
    done = pytest_in(tmp_path, TESTS.replace('"a"', '"a]"'), "--collect-only", "-q")
    assert done.returncode != 0 and "a group's name holds no ]: a]" in done.stdout + done.stderr
