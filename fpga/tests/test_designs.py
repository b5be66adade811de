# SPDX-License-Identifier: Apache-2.0
"""The page of sizes is written when asked, and limits at the pins name pins."""

import re

import pytest

from fpga import build
from mmcs import ROOT


@pytest.mark.parametrize("write", [False, True])
def test_the_page_is_written_only_when_asked(monkeypatch, tmp_path, write):
    asked, page = [], tmp_path / "fpga.md"
    page.write_text("old")
    for name, ours in {
        "OUT": tmp_path, "PAGE": page, "committed": asked.append, "need": lambda *tools: None,
        "build": lambda target: "a row", "splice": lambda text, name, new: new,
        "table": lambda built: "new\n",
    }.items():  # fmt: skip
        monkeypatch.setattr(build, name, ours)
    words = ["build.py", build.TARGETS[0].name, *["--write"] * write]
    monkeypatch.setattr(build.sys, "argv", words)
    assert build.main() == 0
    assert bool(asked) == write, "sources that are changed may be built, not put down"
    assert ("new" in page.read_text()) == write


@pytest.mark.parametrize("top", [target.top for target in build.TARGETS])
def test_every_pin_of_a_limit_is_a_port(top):
    text = (ROOT / f"fpga/bus/{top}.sv").read_text()
    declared = re.findall(
        r"(?:input|output|inout)\s+(?:wire\s+)?(?:logic)?\s*(\[[^]]*\])?\s*(\w+)", text
    )
    ports = {name + ("*" if width else "") for width, name in declared}
    limits = (ROOT / f"fpga/bus/{top}.sdc").read_text().replace("[*]", "*")
    lists = re.findall(r'^[^#\n]*?(?:get_ports|set \w+) [{"]?([^]}"\n]*)', limits, re.M)
    lists += re.findall(r'-to \[get_ports [{"]?([^]}"\n]*)', limits)
    named = {word for found in lists for word in found.split() if word[0] != "$"}
    assert len(named) >= 20 and named <= ports, sorted(named - ports)


def test_the_longest_path_of_each_kind_is_told():
    pin, clock = "<async>", "posedge clk"
    ends = {"in": (pin, clock), "out": (clock, pin), "through": (pin, pin), "": (clock, clock)}
    paths = [
        {"from": a, "to": b, "path": [{"delay": n}, {"delay": ns}]}
        for n, (a, b) in enumerate(ends.values())
        for ns in (7.0, 3.0)
    ]
    assert build.longest({"critical_paths": paths}) == "in 7.0, out 8.0, through 9.0 ns"
