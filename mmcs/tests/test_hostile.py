# SPDX-License-Identifier: Apache-2.0
"""Names, files and surroundings that mean no good: one clear line, and nothing is lost."""

import json
import os
import re
import subprocess
import sys

import pytest

from mmcs import ROBOTS, ROOT
from mmcs.tests.conftest import GOOD, good, one_clear_line
from tools.compiled import ran

CLI = [sys.executable, "-m", "mmcs"]


def command(*args, **options):
    done = ran(*CLI, *args, text=False, **options)
    return done.returncode, done.stdout, done.stderr


# --- names -------------------------------------------------------------------------------------

NAMES = ["[red]x[bold]", "[x", "[b]", "\x1b[31mx", "a\rb", "a\nb", ":smile:", b"\xff\xfe".decode(
    errors="surrogateescape"), "ümläut", "x" * 200, "-" + "x", "%s", "{x}"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_names_are_text(mmcs, tmp_path, name):
    path = tmp_path / f"{name}.toml"
    path.write_text(GOOD.replace('"a test"', '"[b]a\\u001b[7m :smile:"'))
    for args in (("check", path), ("show", path)):
        out = good(mmcs(*args), silent=True)
        assert "\x1b" not in out and "\r" not in out and "\udcff" not in out
    one_clear_line(mmcs("check", path, "--set", "axis.0.b0=0"))
    one_clear_line(mmcs("run", tmp_path / name / "none"))
    one_clear_line(mmcs("replay", tmp_path / name))
    one_clear_line(mmcs("run", f"--{name}", "lab500"))


def test_names_of_a_robot_are_text(mmcs, tmp_path, scenario):
    robot = (ROBOTS / "lab500.toml").read_text()
    name = r'"[red]\u001b[31m"'
    text = re.sub(r'^name = ".*"', lambda _: f"name = {name}", robot, flags=re.M)
    assert name in text
    (tmp_path / "mine.toml").write_text(text)
    out = good(mmcs("show", scenario(GOOD.replace('"lab500"', '"./mine.toml"'))), silent=True)
    assert "[red]\\x1b[31m" in out and "\x1b" not in out


def test_no_way_out_of_the_folder_of_results(mmcs, tmp_path):
    for name in ("...toml", "..toml"):
        path = tmp_path / name
        path.write_text(GOOD)
        one_clear_line(mmcs("run", path), "is no name for results; rename the file")
    assert [p.name for p in tmp_path.iterdir() if p.is_dir()] == []


def test_description_with_markup(mmcs, scenario, tmp_path):
    path = scenario(GOOD.replace("a test", "a [b] $x_{$ [/none] \\u001b[31m"))
    out = good(mmcs("run", path, "--out", tmp_path / "out"))
    assert out.startswith("test: a [b] $x_{$ [/none] \\x1b[31m\n")
    assert "shoot" in out and "…" not in out


# --- surroundings ------------------------------------------------------------------------------

ASCII = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "LANG": "C"}


def test_locale_without_unicode(tmp_path):
    (tmp_path / "ü.toml").write_text(GOOD.replace("a test", "ein Tüst"), encoding="utf-8")
    for args in (("list",), ("show", "puma560"), ("check", tmp_path / "ü.toml")):
        status, out, err = command(*args, env=os.environ | ASCII)
        assert (status, err) == (0, b"")
    status, out, err = command("show", tmp_path / "ü.toml", env=os.environ | ASCII)
    assert status == 0 and "ein Tüst" in out.decode()


def test_no_width_and_warnings_that_are_errors(tmp_path, scenario):
    env = os.environ | {"COLUMNS": "0", "PYTHONWARNINGS": "error"}
    status, out, err = command("run", scenario(), "--out", tmp_path / "out", env=env)
    assert (status, err) == (0, b"") and b"shoot" in out


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full"])
def test_closed_files_lose_nothing(mmcs, tmp_path, scenario, closed):
    out = tmp_path / "out"
    run = ["sh", "-c", f'exec "$@" {closed}', "sh", *CLI, "run", scenario(), "--out", out]
    assert subprocess.run(run, cwd=ROOT, check=False).returncode == 0
    report = json.loads((out / "report.json").read_text())
    assert report["scenario"] == "test" and (out / "run.mmcs").read_text().startswith("{")
    assert not list(out.glob(".new")) and mmcs("compare", out, out)[0] == 0


# --- files that are none, or never end ---------------------------------------------------------


def test_file_that_never_ends(mmcs, scenario, tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "big.csv").write_bytes(b"1\n" * (5 << 20))
    (tmp_path / "big.toml").write_bytes(b"#" * (2 << 20))
    table = '[[motion]]\naxis = 0\nkind = "table"\nat = 0.1\nduration = 0.1\nfile = "{}"\n'
    for file, words in (
        ("/dev/zero", "is a pipe, a device or a folder"),
        ("pipe.csv", "is a pipe, a device or a folder"),
        ("/", "cannot be read"),
        ("big.csv", "is larger than 8 MB"),
    ):
        text = GOOD.partition("[[motion]]")[0] + table.format(file)
        one_clear_line(mmcs("check", scenario(text)), words)
    one_clear_line(mmcs("check", tmp_path / "big.toml"), "is larger than 1 MB")
    one_clear_line(
        mmcs("check", scenario(GOOD.replace('"lab500"', '"./big.toml"'))), "is larger than 1 MB"
    )


def test_very_many_values_are_not_all_tried_beforehand(monkeypatch):
    from mmcs.sweeps.plan import Plan, make_plan

    tried, setup = [], Plan.setup
    monkeypatch.setattr(Plan, "setup", lambda s, v: tried.append(v) or setup(s, v))
    plan = make_plan("lab500", ("axis.0.b0=1..200000",), (), None, 1)
    assert len(plan) == 200_000 and len(tried) <= 101
