# SPDX-License-Identifier: Apache-2.0
"""What watches the firmware at work turns red: a rule broken in the RTL, and one in the host."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from cocotb_tests.dpi import cocotb_dpi
from cocotb_tests.lib import runner
from mmcs import ensure_library, make_env

ROOT = Path(__file__).resolve().parents[2]
TEST = "everything_the_firmware_does_keeps_the_rules"
JOB = runner.Job(
    "cocotb_tests.dpi.cocotb_dpi", cocotb_dpi.TOPLEVEL, "verilator", (("NumCards", 1),),
    dpi=cocotb_dpi.DPI["brief"],
)  # fmt: skip


def broken(text: str, right: str, wrong: str) -> str:
    assert text.count(right) == 1, right
    return text.replace(right, wrong)


def said(job: runner.Job) -> str:
    """Why the test fails, as it must."""
    outcome = runner.run(job, [TEST], runner.DEFAULT_SEED, f"broken-{os.getpid()}")[TEST]
    assert not outcome.passed
    return outcome.text


@pytest.mark.slow
@pytest.mark.req("MAP-1")
def test_a_rule_broken_in_the_rtl(tmp_path, monkeypatch):
    """PC A13-A10 the wrong way round: a machine of one card works, and is another one."""
    shutil.copytree(ROOT / "rtl", tmp_path / "rtl")
    file = tmp_path / "rtl/adaptor/adaptor_core.sv"
    wrong = ".a_i({2'b00, hp_a_i[6], hp_a_i[7], hp_a_i[8], hp_a_i[9], base"
    file.write_text(broken(file.read_text(), ".a_i({2'b00, hp_a_i[9:6], base", wrong))
    monkeypatch.setenv("MMCS_RTL", str(tmp_path / "rtl"))
    assert "assert pc.address == low | base << 5 | high << 10" in said(JOB)


@pytest.mark.slow
@pytest.mark.req("VME-3")
def test_a_rule_broken_in_the_host(tmp_path):
    """The bus master puts its strobes out with the address, not a clock later."""
    ensure_library(1, "dpi")
    make = ["make", "-s", "-f", "sim/Makefile", "KIND=dpi", "parts"]
    listed = subprocess.run(make, cwd=ROOT, env=make_env(), check=True, text=True, stdout=-1)
    parts = [p for p in listed.stdout.split() if not p.endswith("/engine.o")]
    others = [f for d in ("engine", "plant") for f in (ROOT / "sim" / d).glob("*.cpp")]
    right = "c.write, false, c.data);\n  machine_.advance(1, Watch::kNothing);\n"
    wrong = "c.write, false, c.data);\n"
    (tmp_path / "vme_bus.cpp").write_text(
        broken((ROOT / "sim/engine/vme_bus.cpp").read_text(), right, wrong)
    )
    source = tmp_path / "together.cpp"
    files = [tmp_path / f.name if f.name == "vme_bus.cpp" else f for f in sorted(others)]
    source.write_text("".join(f'#include "{f}"\n' for f in files))
    library = tmp_path / "libmmcs_dpi.so"
    folders = ("sim/abi", "sim/engine", "sim/model", "sim/plant", "firmware/include")
    includes = [f"-I{d}" for d in folders]
    flags = ["-std=c++17", "-O1", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-shared"]
    command = [os.environ.get("CXX", "g++"), *flags, *includes, "-Ifirmware/mc", source]
    subprocess.run([*command, *parts, "-o", library], cwd=ROOT, check=True)
    job = runner.Job(**{**vars(JOB), "environment": (("LD_PRELOAD", str(library)),)})
    assert "addr_setup" in said(job)
