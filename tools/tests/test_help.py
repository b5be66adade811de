# SPDX-License-Identifier: Apache-2.0
"""Whoever asks a tool for help gets it, and nothing else happens."""

import builtins
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
TOOLS = sorted(
    path
    for folder in ("tools", "fpga", "studies", "rtl")
    for path in (ROOT / folder).rglob("*.py")
    if "\nif __name__ ==" in path.read_text()
)


@pytest.mark.parametrize("tool", TOOLS, ids=lambda p: str(p.relative_to(ROOT)))
def test_help_does_nothing(tool, monkeypatch, capsys):
    def starts(*words, **_):
        raise AssertionError(f"{tool.name} --help starts {words}")

    def opens(file, mode="r", *rest, _open=builtins.open, **named):
        assert not set(mode) & set("wax+"), f"{tool.name} --help writes {file}"
        return _open(file, mode, *rest, **named)

    for folder in (ROOT, ROOT / "tools", tool.parent):
        monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setattr(sys, "argv", [str(tool), "--help"])
    monkeypatch.setattr(subprocess, "Popen", starts)
    monkeypatch.setattr(builtins, "open", opens)
    monkeypatch.setattr(Path, "write_text", starts)
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(tool), run_name="__main__")
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith("usage: ")


@pytest.mark.parametrize("tool", sorted((ROOT / "tools").glob("*.sh")), ids=lambda p: p.name)
def test_help_of_a_script(tool):
    done = subprocess.run([tool, "--help"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"Usage: {tool.name}" in done.stdout


def test_a_study_ends_with_one_line_for_bad_input(tmp_path, capsys):
    import studies
    from mmcs import load

    (tmp_path / "bad.toml").write_text('description = "x"\nrobot = "lab500"\nspeed = 1\n')
    with pytest.raises(SystemExit) as end:
        studies.run(lambda: load(str(tmp_path / "bad.toml")))
    said = capsys.readouterr().err
    assert end.value.code == 2 and said.startswith("mmcs: ") and "speed: unknown key" in said
