# SPDX-License-Identifier: Apache-2.0
"""Verilator and Icarus give the same value on every output in every clock. §4, §5"""

import shutil

import pytest

from cocotb_tests.lib.runner import MISSING, SIMULATORS, Job, run
from cocotb_tests.system.agree_scene import CLOCKS, FILE
from cocotb_tests.system.machine import USUAL

SCENE, TEST = "cocotb_tests.system.agree_scene", "random_traffic"


@pytest.mark.skipif(not shutil.which("iverilog"), reason=MISSING["icarus"])
@pytest.mark.req("VME-3", "PIT-2", "ENC-1", "DAC-1", "ADC-1", "LAT-1", "INT-2")
def test_both_simulators_agree_on_every_clock(request):
    seed = request.config.getoption("--seed")
    seen = {}
    for sim in SIMULATORS:
        outcome = run(Job(SCENE, "mmcs", sim, tuple(sorted(USUAL.items()))), [TEST], seed)[TEST]
        assert outcome.passed, f"{sim}: {outcome.text}"
        seen[sim] = (outcome.log.parent / FILE).read_text().splitlines()
        assert len(seen[sim]) == CLOCKS + 1
        assert len(set(seen[sim])) > CLOCKS // 3, "a machine at rest proves nothing"
    names = seen["icarus"][0].split()
    for clock, (one, other) in enumerate(zip(*seen.values(), strict=True)):
        if one != other:
            pairs = zip(names, one.split(), other.split(), strict=True)
            apart = [f"{n}: {a} and {b}" for n, a, b in pairs if a != b]
            raise AssertionError(f"seed {seed}, clock {clock}: {'; '.join(apart)}")
