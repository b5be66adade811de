# SPDX-License-Identifier: Apache-2.0
"""What a module is set to reaches its parts: a parameter that both have is handed on under its own
name. What no bench sets would be seen by nothing else."""

import re

import pytest

from mmcs import ROOT

MODULE = re.compile(r"^module (\w+)(.*?)^endmodule", re.S | re.M)
PARAMETER = re.compile(r"^ *parameter\b[^=,\n]*?(\w+) +=", re.M)
INSTANCE = re.compile(r"^ +(\w+)(?: #\((.*?)\n? *\))? +(u_\w+)\b[^;]*?\(", re.S | re.M)


def modules(text: str) -> dict[str, str]:
    return dict(MODULE.findall(re.sub(r"//.*", "", text)))


def not_handed_on(found: dict[str, str]) -> list[str]:
    """Of modules by name."""
    own = {name: PARAMETER.findall(text) for name, text in found.items()}
    lost = []
    for name, text in found.items():
        for kind, given, part in INSTANCE.findall(text):
            bound = dict(re.findall(r"\.(\w+)\(([^)]*)\)?", given))
            both = [one for one in own.get(kind, ()) if one in own[name]]
            other = (one for one in both if not re.match(rf"{one}\b", bound.get(one, "")))
            lost += [f"{name}: {part}: {one}" for one in other]
    return lost


@pytest.mark.req("JMP-1")
def test_parts_get_the_parameters_of_the_whole():
    files = [*ROOT.glob("rtl/**/*.sv"), *ROOT.glob("fpga/bus/*.sv")]
    found = {name: text for file in files for name, text in modules(file.read_text()).items()}
    assert len(found) > 40 and not_handed_on(found) == []


def test_a_parameter_that_is_left_out_or_another_is_told():
    whole = """module a #(\n  parameter int X = 1,\n  parameter bit Y = 0\n);
  b #(\n    .X(X),\n    .Y(%s)\n  ) u_b (.c);\n  b #(.X(2), .Y(Y[1])) u_c (.c);\nendmodule
module b #(\n  parameter int X = 1,\n  parameter bit Y = 0\n) (input c);\nendmodule\n"""
    assert not_handed_on(modules(whole % "Y")) == ["a: u_c: X"]
    assert not_handed_on(modules(whole % "X"))[0] == "a: u_b: Y"
    assert not_handed_on(modules(whole.replace(".Y(%s)", ".Z(1)")))[0] == "a: u_b: Y"
