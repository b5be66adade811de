# SPDX-License-Identifier: Apache-2.0
"""A sample of `make edges`; and a sweep that a broken flip-flop turns red."""

import shutil
from pathlib import Path

import pytest

from tools import edges

ROOT = Path(__file__).resolve().parents[2]

SAMPLE = 101  # prime: no sweep's inner loops divide it


@pytest.mark.parametrize("bench", list(edges.BENCHES))
@pytest.mark.req("VME-3", "INT-2", "ENC-2", "LAT-1", "CAL-1", "PAN-2")
def test_a_sample_of_every_sweep(bench):
    scenes = edges.run(bench, SAMPLE)
    assert len(scenes) >= 10
    for scene in scenes:
        assert scene.cases >= 3, scene
        assert scene.failures == 0, scene


BROKEN = {  # file, what is broken, which sweep must see it
    "DTACK* of a withdrawn strobe": (
        "adaptor/vme_slave.sv", "(answered & ds0_held_q &", "(answered &", "vme", "withdrawn"),
    "the old strobe taken for ours": (
        "adaptor/vme_strobe.sv",
        "selected_o & ds0_fell_q & ~ds0_stale_q & ~ds0_ni",
        "selected_o & ~ds0_ni", "vme", "pipeline"),
    "IACKIN* high for less than a clock": (
        "adaptor/vme_interrupter.sv", ".rst_ni(iackin), .en_i(1'b1), .d_i(1'b1)",
        ".rst_ni, .en_i(1'b1), .d_i(iackin)", "vme", "chain"),
    "two bits that one edge changes": (
        "chips/thct2000.sv", ".d_i({a_i, b_i}), .q_o(in));",
        ".d_i({a_i, a_i ^ b_i}), .q_o(both));\n  logic [1:0] both;\n"
        "  assign in = {both[1], ^both};", "card", "read"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", list(BROKEN))
@pytest.mark.req("VME-3", "INT-2")
def test_a_broken_one_is_seen(name, tmp_path, monkeypatch):
    file, old, new, bench, scene = BROKEN[name]
    shutil.copytree(ROOT / "rtl", tmp_path / "rtl")
    path = tmp_path / "rtl" / file
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    monkeypatch.setenv("MMCS_RTL", str(tmp_path / "rtl"))
    failures = sum(s.failures for s in edges.run(bench, SAMPLE, scene))
    assert failures > 0, "the sample of make test does not see it"
