# SPDX-License-Identifier: Apache-2.0
"""fpga/limits.py: constraint files name pins that exist, and reports are judged."""

import re
import sys

import pytest

from fpga import limits
from mmcs import ROOT


@pytest.mark.parametrize("kind", ["sdc", "xdc"])
def test_the_files_hold_each_limit(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "FOLDER", tmp_path / "made")
    monkeypatch.setattr(sys, "argv", ["limits.py", "--write"])
    assert limits.main() == 0
    for top in limits.tops():
        text = (tmp_path / "made" / f"{top}.{kind}").read_text()
        for limit in limits.limits(top):
            assert limits.ports(limit.pins) in text and f"# {limit.why}" in text


@pytest.mark.parametrize("top", limits.tops())
def test_every_pin_of_a_limit_is_a_port(top):
    text = (ROOT / f"fpga/bus/{top}.sv").read_text()
    declared = re.findall(
        r"(?:input|output|inout)\s+(?:wire\s+)?(?:logic)?\s*(\[[^]]*\])?\s*(\w+)", text
    )
    ports = {name + ("*" if width else "") for width, name in declared}
    for limit in limits.limits(top):
        named = {*limit.pins, *limit.to} | ({limit.port} if limit.port else set())
        assert named <= ports, sorted(named - ports)


def report(**ns) -> dict:
    """A report with one path of each kind."""
    ends = {"input": ("<async>", "posedge clk"), "output": ("posedge clk", "<async>"),
            "through": ("<async>", "<async>"), "strobe": ("<async>", "negedge vme_as_n$glb"),
            "inside": ("posedge clk", "posedge clk")}  # fmt: skip
    paths = [
        {"from": ends[kind][0], "to": ends[kind][1], "path": [{"delay": n / 2}, {"delay": n / 2}]}
        for kind, n in ns.items()
    ]
    return {"fmax": {"clk": {"achieved": 30.0}}, "critical_paths": paths}


@pytest.mark.parametrize(
    ("kind", "ns", "limit", "said"),
    [
        ("input", 9.0, 10.0, "holds"),
        ("input", 11.0, 10.0, "not shown: the longest path is of any pin"),
        ("output", 11.0, 10.0, "not shown: the longest path is of any pin"),
        ("through", 10.0, 10.0, "holds"),
        ("strobe", 9.9, 10.0, "holds"),
        ("strobe", 10.1, 10.0, "not shown: the longest path is of any pin"),
        ("skew", 1.0, 10.0, limits.UNCHECKED),
        ("clock", 1.0, 40.0, "holds"),
        ("clock", 1.0, 33.0, "missed"),
    ],
)
def test_a_report_against_a_limit(kind, ns, limit, said):
    paths = {kind: ns} if kind not in ("skew", "clock") else {"inside": ns}
    port = "vme_as_n" if kind == "strobe" else ""
    it = limits.Limit(kind, ("pin",), (), limit, "", port)
    # a path of another kind, longer than any limit, is not taken for it
    other = {"output": 99.0} if kind != "output" else {"input": 99.0}
    assert limits.verdict(it, [limits.measured(it, report(**paths, **other))] * 3) == said


def test_one_seed_that_misses_is_a_miss():
    it = limits.Limit("clock", ("clk",), (), 33.0, "")
    assert limits.verdict(it, [30.0, 34.0, 30.0]) == "missed"
