# SPDX-License-Identifier: Apache-2.0
"""FuseSoC runs every target of every core, offline, without a warning; make fusesoc-test."""

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
CHIPS = ("i8254", "i8255", "thct2000", "ad574", "ad667", "oneshot")


def cocotb_wants() -> dict[str, str]:
    """What cocotb 2.1 reads beside what FuseSoC tells it."""
    import cocotb_tools.config
    import find_libpython

    users = f"{find_libpython.find_libpython()};{cocotb_tools.config.pygpi_entry_point()}"
    return {"GPI_USERS": users, "PYTHONPATH": str(ROOT), "COCOTB_TOPLEVEL": "mmcs",
            "COCOTB_TEST_FILTER": "timer_2_counts_sclocks|registers_at_this_rate"}  # fmt: skip


def fusesoc(folder: Path, *words: str, roots: tuple[Path, ...] = (ROOT,)) -> str:
    """What it prints; it must end well, and warn of nothing."""
    command = [str(Path(sys.executable).with_name("fusesoc"))]
    for root in roots:
        command += ["--cores-root", str(root)]
    env = os.environ | cocotb_wants() | {"XDG_CACHE_HOME": str(folder), "HOME": str(folder)}
    done = subprocess.run(
        [*command, "run", "--build-root", str(folder), *words],
        cwd=folder, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:]
    for line in done.stdout.splitlines():
        assert not line.startswith(("WARNING", "%Warning")) and "deprecat" not in line, line
    return done.stdout


@pytest.mark.req("PIT-1", "PPI-1", "ENC-1", "ADC-1", "DAC-1", "HB-1")
@pytest.mark.parametrize("chip", CHIPS)
def test_each_chip_alone(chip, tmp_path):
    fusesoc(tmp_path, f"--target={chip}_lint", "mmcs:machine:mmcs")
    assert f"{chip}: ok" in fusesoc(tmp_path, f"--target={chip}", "mmcs:machine:mmcs")
    fusesoc(tmp_path, f"--target={chip}_synth", "mmcs:machine:mmcs")
    assert list(tmp_path.rglob("*.json"))


@pytest.mark.req("PIT-2")
def test_the_machine(tmp_path):
    fusesoc(tmp_path, "--target=lint", "mmcs:machine:mmcs")
    said = fusesoc(tmp_path, "--target=sim", "mmcs:machine:mmcs")
    assert "PASS=2 FAIL=0" in said


def test_the_provider_entry_of_a_core_library(tmp_path):
    """A core file somewhere else, as others have it: it fetches the sources of a release."""
    release, library = tmp_path / "mmcs.tar.gz", tmp_path / "library"
    names = subprocess.run(["git", "ls-files", "rtl"], cwd=ROOT, text=True, check=True,
                           capture_output=True).stdout.split()  # fmt: skip
    with tarfile.open(release, "w:gz") as tar:
        for name in names:
            tar.add(ROOT / name, name)
    library.mkdir()
    provider = f"{{name: url, url: '{release.as_uri()}', filetype: tar}}"
    text = (ROOT / "mmcs.core").read_text()
    (library / "mmcs.core").write_text(f"{text}\nprovider: {provider}\n")
    fusesoc(tmp_path, "--target=lint", "mmcs:machine:mmcs", roots=(library,))
