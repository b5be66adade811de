# SPDX-License-Identifier: Apache-2.0
"""A LiteX SoC with our module, simulated whole: its processor runs our driver; make litex-test."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from cocotb_tools.runner import get_runner

HERE = Path(__file__).resolve().parents[1]
ROOT = HERE.parents[1]


@pytest.fixture(scope="module")
def sources(tmp_path_factory) -> list[Path]:
    """Those of the SoC; its folder is that of the first."""
    folder = tmp_path_factory.mktemp("litex")
    command = [sys.executable, str(HERE / "soc.py"), str(folder)]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return [Path(line) for line in done.stdout.splitlines() if line.endswith((".v", ".sv"))]


@pytest.mark.req("ADP-1")
def test_the_headers_are_litex_own(sources):
    generated = sources[0].parent / "generated"
    assert "#define MMCS_BASE" in (generated / "mem.h").read_text()
    assert "#define MMCS_INTERRUPT" in (generated / "soc.h").read_text()


@pytest.mark.req("ADP-1", "INT-1", "DRV-7", "FW-1")
def test_litex_moves_two_motors(sources, monkeypatch):
    folder = sources[0].parent
    monkeypatch.delenv("PYTEST_CURRENT_TEST")  # the runner would end the process
    runner = get_runner("verilator")
    runner.build(
        sources=sources[1:] + sources[:1], includes=[ROOT / "rtl"], hdl_toplevel="soc",
        build_args=["--assert", "--no-timing", "-Wno-fatal", "-CFLAGS", "-O0"],
        build_dir=folder / "sim",
        timescale=("1ns", "1ps"), log_file=folder / "build.log",
    )  # fmt: skip
    results = runner.test(
        test_module="bridges.litex.tests.litex_bench", hdl_toplevel="soc", test_dir=folder,
        build_dir=folder / "sim", results_xml=str(folder / "results.xml"),
        log_file=folder / "sim.log",
        timescale=("1ns", "1ps"), extra_env={"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    cases = list(ET.parse(results).iter("testcase"))
    bad = [e for case in cases for e in case if e.tag in ("failure", "error")]
    assert len(cases) == 1 and not bad, (folder / "sim.log").read_text()[-3000:]


GOOD = "estop_closed=Constant(1), cable_ok=Constant(1), pc_power=Constant(1)"


@pytest.mark.req("ADP-1", "PAN-1")
@pytest.mark.parametrize(("arguments", "what"), [
    (f"10e6, {GOOD}", "sys_clk_freq 1e+07 must be 8 to 80 MHz, in 8 MHz"),
    ("8e6", "mmcs: estop_closed is missing; give its pin, or Constant(1) if there is none"),
    ("8e6, estop_closed=Constant(1), pc_power=Constant(1)", "mmcs: cable_ok is missing"),
    ("8e6, estop_closed=Constant(1), cable_ok=Constant(1), pc_power=None", "pc_power is missing"),
    (f"8e6, estop=Constant(1), {GOOD}", "mmcs: estop is no pin; there are estop_closed"),
])  # fmt: skip
def test_what_cannot_be_is_told(arguments, what):
    code = f"from migen import Constant; from mmcs_litex import MMCS; MMCS(None, {arguments})"
    done = subprocess.run([sys.executable, "-c", code], cwd=HERE, text=True, capture_output=True,
                          check=False)  # fmt: skip
    assert what in done.stderr
