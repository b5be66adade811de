# SPDX-License-Identifier: Apache-2.0
"""docs/use/first_hour.md as it stands: files written, commands run; the chips' pages."""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from mmcs import ROOT
from tools.compiled import ran

CHIPS = ("ad574", "ad667", "i8254", "i8255", "oneshot", "thct2000")
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


@pytest.mark.parametrize("name", CHIPS)
def test_page_of_the_chip_has_its_ports(name):
    text = (ROOT / f"rtl/chips/{name}.sv").read_text()
    ports = re.findall(r"^  (?:input|output)\b.*?(\w+) *,? *(?://.*)?$", text, re.M)
    page = (ROOT / f"docs/hardware/chips/{name}.md").read_text()
    assert len(ports) >= 5 and re.findall(r"^\| `(\w+)` \| (?:in|out)put", page, re.M) == ports
