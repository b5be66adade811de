# SPDX-License-Identifier: Apache-2.0
"""docs/use/first_hour.md and the chips' benches, as they stand: files written, commands run."""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from mmcs import ROOT
from tools import chip_pages
from tools.compiled import ran
from tools.pages import part

PAGE = next(ROOT.glob("docs/**/first_hour.md"))
PARTS = dict(part.split("\n", 1) for part in PAGE.read_text().split("\n## ")[1:])
ICARUS = pytest.mark.skipif(
    not shutil.which("iverilog"), reason="iverilog is missing: sudo apt-get install iverilog"
)


def carry_out(part: str, folder: Path) -> str:
    """What the part's commands print, in a folder that has its files and the checkout's."""
    for name in ("rtl", "firmware", "docs"):
        (folder / name).symlink_to(ROOT / name)
    said = ""
    env = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    blocks = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```", re.M | re.S)
    for kind, name, text in blocks.findall(PARTS[part]):
        if name:
            (folder / name).write_text(text)
        elif kind == "sh":
            done = ran("bash", "-ec", text, cwd=folder, env=env)
            assert done.returncode == 0, done.stdout + done.stderr
            said += done.stdout
    return said


@ICARUS
def test_engineer(tmp_path):
    assert "i8254: ok" in carry_out("An FPGA engineer who needs an 8254", tmp_path)


def test_teacher(tmp_path):
    said = carry_out("A teacher with a motor of their own", tmp_path)
    assert "[14639, -14076, 128]" in said and "a0 = 14639" in said
    assert "caution: axis 0: has no gains" in said
    assert (tmp_path / "runs" / "step" / "report.json").is_file()


def test_programmer(tmp_path):
    carry_out("A programmer with a script", tmp_path)
    for name in ("sine.csv", "sine_py.csv"):
        rows = [list(map(int, line.split(","))) for line in
                (tmp_path / name).read_text().splitlines()[1:]]  # fmt: skip
        assert [row[0] for row in rows] == list(range(1000))
        assert max(abs(encoder) for _, _, encoder, _ in rows) < 260


def test_every_method_of_the_device_is_in_the_table():
    from mmcs import Device

    told = set(re.findall(r"`(\w+)\(", PARTS["A programmer with a script"]))
    public = {name for name in vars(Device) if not name.startswith("_")} - {"close"}
    assert public <= told


@ICARUS
@pytest.mark.parametrize("name", chip_pages.names())
def test_bench_of_the_chip(name, tmp_path):
    program = tmp_path / "tb"
    sources = [*chip_pages.files(name).split(), f"docs/hardware/chips/{name}_tb.sv"]
    ran("iverilog", "-g2012", "-Irtl", "-s", f"{name}_tb", "-o", program, *sources, check=True)
    assert f"{name}: ok\n" in ran("vvp", program, check=True).stdout


@pytest.mark.parametrize("name", chip_pages.names())
def test_page_of_the_chip_is_fresh(name):
    text = (chip_pages.PAGES / f"{name}.md").read_text()
    assert chip_pages.page(name, text) == text, "run python tools/chip_pages.py"
    assert len(chip_pages.ports(name)) >= 5
    assert all(meaning for _, _, _, meaning in chip_pages.ports(name))


@pytest.mark.parametrize("change", ["cs_ni", "nobody_i"])
def test_a_port_without_a_meaning_is_told(change, monkeypatch):
    """One that is missing, and one that the RTL does not have."""
    said = dict(chip_pages.SAID["i8254"]["ports"])
    said.pop(change, None) or said.update({change: "x"})
    monkeypatch.setitem(chip_pages.SAID, "i8254", chip_pages.SAID["i8254"] | {"ports": said})
    with pytest.raises(SystemExit, match=rf"ports.toml: i8254: {change}: has a meaning there"):
        chip_pages.ports("i8254")


@pytest.mark.slow  # a minute of synthesis
def test_sizes_of_the_chips_are_fresh():
    told = part(chip_pages.SIZES.read_text(), "chips").strip()
    assert told == chip_pages.sizes(), "run `python tools/chip_pages.py --sizes`"


def test_gains_that_do_not_fit_are_cautioned(mmcs):
    status, out, _ = mmcs("check", "lab500", "--set", "axis.0.a1=0", "--set", "axis.0.a0=40000")
    assert status == 0 and "unstable loop at 1000 us; `mmcs design" in out
    assert "loop" not in mmcs("check", "lab500")[1]
