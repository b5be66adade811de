# SPDX-License-Identifier: Apache-2.0
"""Runs every TEST(name, "ID ID") of the C test program as an item of its own, which covers the
requirements of these ids."""

import bisect
import re
from pathlib import Path

import pytest
from fwbuild import ROOT, SANITIZE, compile_c

from studies.shrink import shrunk
from tools.compiled import ran

HERE = Path(__file__).parent

DRIVER = sorted((ROOT / "firmware" / "mc").glob("*.c"))
TESTS = [*sorted(HERE.glob("test_*.c")), HERE / "harness.c", HERE / "mock.c"]
FUNCTION = re.compile(r'^TEST\((test_\w+)(?:, "([^"]*)")?\)', re.M)


def cases():
    for source in TESTS:
        for name, ids in FUNCTION.findall(source.read_text()):
            marks = [pytest.mark.req(*ids.split())] if ids else []
            yield pytest.param(name, id=f"{source.stem}-{name}", marks=marks)


def program() -> Path:
    return compile_c("driver_tests", [*TESTS, *DRIVER], SANITIZE)


def fewest(name: str, calls: int = 300_000, one_machine: int = 5000) -> str:
    """A random test that fails, with the fewest of its calls."""
    if name not in ("test_random_calls", "test_calls_that_a_model_judges"):
        return ""

    def output(end: int, kept: list[int] | None = None) -> str:
        words = [] if kept is None else [",".join(map(str, kept))]
        done = ran(program(), name, end, 1, *words)
        return (done.stdout + done.stderr) if done.returncode else ""

    end = bisect.bisect_left(range(calls), True, key=lambda n: output(n) != "")
    first = (end - 1) // one_machine * one_machine
    return output(end, shrunk(list(range(first, end)), lambda kept: output(end, kept) != ""))


@pytest.mark.parametrize("name", list(cases()))
def test_c(name):
    done = ran(program(), name)
    assert done.returncode == 0, done.stdout + done.stderr + fewest(name)
