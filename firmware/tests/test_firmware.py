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
NAMES = {source.stem: [name for name, _ in FUNCTION.findall(source.read_text())]
         for source in TESTS[:-2]}  # fmt: skip


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


# Digests of what the driver does to the bus, says and signals in each test. Who means to change it
# puts in those of today: `PYTHONPATH=. .venv/bin/python firmware/tests/test_firmware.py`.
TOLD = {
    "test_calib": "1080 f73c 5580 00cf 8f91 99bb 150e ed22 2869 08b6",
    "test_errors": "09db 2303 36bc 6459 17a3 3fb8 a805",
    "test_open": "0000 4a29 9f37 11b9 3dbb 72c7 0f3d 4e1b 8151 2d82 41eb fd05",
    "test_overrun": "a993 2f3a f577 99bd",
    "test_passes": "c8df 9ff0 feff 0ca2 08e3 597b 886e 2bd7",
    "test_power": "2162 95ae c3de 1f65 8e0a a314 7862",
    "test_random": "1a13 8428",
    "test_requests": "6190 9d12 dec3 bc40 9b91 edd0 3351 c1f1 ca6a",
    "test_revive": "8e02 a799 86b8 928e 9fc7 e0eb c3cf 113d fd56 4778 975d 5105 eea5",
    "test_stop": "27ad 675f 5931 3750 4a0b 119b",
    "test_switches": "d582 0276 0653 b2db da1d 692e 311d",
    "test_units": "661b 3e1b 37ee be35 cb7e cee3 0000",
}  # fmt: skip


@pytest.mark.parametrize("name", list(cases()))
def test_c(name):
    done = ran(program(), name)
    assert done.returncode == 0, done.stdout + done.stderr + fewest(name)
    (stem,) = [stem for stem, names in NAMES.items() if name in names]
    assert done.stdout.split() == TOLD[stem].split()[NAMES[stem].index(name) :][:1]


if __name__ == "__main__":
    for stem, names in NAMES.items():
        told = [ran(program(), name).stdout.strip() for name in names]
        print(f'    "{stem}": "{" ".join(told)}",')
