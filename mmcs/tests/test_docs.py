# SPDX-License-Identifier: Apache-2.0
"""docs/use/scenarios.md names every key and input, and its example is a good scenario; what README
shows is what happens, and what it shows is small."""

import json
import re
import typing
from fractions import Fraction

import pytest

from mmcs import ROOT
from mmcs.inputs import INPUTS
from mmcs.scenario import scenario
from mmcs.tests.conftest import good

TEXT = (ROOT / "docs" / "use" / "scenarios.md").read_text()
README = (ROOT / "README.md").read_text()
SECTIONS = dict(part.split("\n", 1) for part in TEXT.split("\n## ")[1:])
TABLES = ("motor", "servo", "motion", "event", "call", "process", "program", "expect", "card")


def models():
    """(heading of the section, model) for every table of a scenario."""
    yield "Top level", scenario.Scenario
    yield "Top level", scenario.Host
    for name in TABLES:
        (member,) = typing.get_args(scenario.Scenario.model_fields[name].annotation)
        member = typing.get_args(member)[0] if typing.get_args(member) else member
        for model in typing.get_args(member) or (member,):
            yield f"`[[{name}]]`", model


def rows(heading):
    """The cells of all table rows of a section, headings and rules left out."""
    lines = re.findall(r"^\| *(`.*?) *\|$", SECTIONS[heading], re.M)
    return [[cell.strip() for cell in line.split(" | ")] for line in lines]


def names(text):
    """What stands in code: `a`, `a = 1` and `"a"` all name a."""
    return {n for code in re.findall(r"`([^`]*)`", text) for n in re.findall(r'^"?(\w+)', code)}


def kinds(model):
    field = model.model_fields.get("kind")
    return typing.get_args(field.annotation) if field else ()


def all_keys():
    return [
        pytest.param(heading, model, key, id=f"{model.__name__}.{key}")
        for heading, model in models()
        for key in model.model_fields
        if key != "kind" and not (model is scenario.Scenario and key in (*TABLES, "host"))
    ]


@pytest.mark.parametrize("heading,model,key", all_keys())
def test_key_is_documented(heading, model, key):
    """In its own section; a key of one kind in the row of that kind, or before all kinds."""
    for kind in kinds(model) or ("",):
        found = set()
        for cells in rows(heading):
            of_kind = any(f'"{k}"' in cells[0] for _, m in models() for k in kinds(m))
            if f'"{kind}"' in cells[0] or not of_kind:
                found |= names(cells[0])
            if f'"{kind}"' in cells[0]:
                found |= names(" | ".join(cells))
        if not rows(heading):  # a section of one sentence
            found = names(SECTIONS[heading])
        assert key in found, f"{heading} says nothing of {key} {kind}"


def test_nothing_is_documented_that_is_no_key():
    for heading in {heading for heading, _ in models()}:
        known = {k for h, m in models() if h == heading for k in (*m.model_fields, *kinds(m))}
        known |= {"extends"} if heading == "Top level" else set()  # gone before the check
        known |= set(INPUTS) if "event" in heading else set()
        for cells in rows(heading):
            assert names(cells[0]) <= known, f"{heading}: {cells[0]}"


def test_defaults_are_current():
    """The middle column of the tables of three columns, where it gives a value."""
    fields = {**scenario.Scenario.model_fields, **scenario.Host.model_fields}
    for key, default, _ in (cells for cells in rows("Top level") if len(cells) == 3):
        field = fields[key.strip("`")]
        if field.is_required() or default == "robot file":
            assert (default, field.default) in (("", field.default), ("robot file", [])), key
        elif "/" in default:
            assert float(Fraction(default)) == pytest.approx(field.default), key
        else:
            assert json.loads(default.strip("`")) == field.default, key


def test_example_is_a_good_scenario(mmcs, scenario):
    example = re.search(r"```toml\n(.*?)```", TEXT, flags=re.S)[1]
    assert "good" in good(mmcs("check", scenario(example)), silent=True)


def test_ports_and_parameters_of_the_machine():
    """docs/hardware/ports.md names each of them, and no other; widths in cards as declared."""
    rtl = (ROOT / "rtl" / "mmcs.sv").read_text()
    page = (ROOT / "docs" / "hardware" / "ports.md").read_text()
    head = rtl[rtl.index("module mmcs") : rtl.index("\n);")]
    ports = set(re.findall(r"^  (?:in|out)put .*?(\w+),?(?: *//.*)?$", head, re.M))
    parameters = dict(
        re.findall(r"^  parameter (?:\w+ )+(?:\[.*\] )?(\w+) = ([^,\n/]+)", head, re.M)
    )
    assert len(ports) > 40
    cells = re.findall(r"^\| (`.*?) \|", page, re.M)
    named = [n for cell in cells for n in re.findall(r"`(\w+)`", cell)]
    assert sorted(named) == sorted(ports | set(parameters))
    for width, name in re.findall(r"\[ *(\d+)\*NumCards-1:0\] (\w+)", head):
        row = next(line for line in page.splitlines() if re.match(rf"\| .*`{name}`", line))
        assert f"[{width}N−1:0]" in row, name
    for name, value in parameters.items():
        row = next(line for line in page.splitlines() if re.match(rf"\| .*`{name}`", line))
        number = value.strip().replace("_", "")
        if number.isdigit():
            assert re.search(rf"\b{number}\b", row.split(" | ")[1]), name


def test_its_length_and_the_size_of_its_moving_picture():
    assert len(README.splitlines()) <= 150
    assert 10_000 < (ROOT / "docs/images/puma560.gif").stat().st_size <= 400_000
    for word in ("DPI", "make cocotb", "ross-compile", "aveforms"):
        assert word in README


def test_every_box_of_the_loop_leads_somewhere():
    picture = ROOT / "docs/images/loop.svg"
    boxes = re.findall(r'<a href="([^"]+)">', picture.read_text())
    assert len(boxes) == 10
    assert [box for box in boxes if not (picture.parent / box).is_file()] == []


@pytest.mark.slow
def test_the_output_of_make_sim(mmcs, tmp_path):
    [shown] = re.findall(r"^```text\n(.*?)^```", README, re.M | re.S)
    said = good(mmcs("run", "puma560", "--out", tmp_path / "out"))
    lines = [line for line in shown.splitlines() if line != "..." and "results in" not in line]
    assert len(lines) > 3 and [line for line in lines if line not in said.splitlines()] == []
