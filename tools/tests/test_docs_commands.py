# SPDX-License-Identifier: Apache-2.0
"""Every piece of code of README and the docs: run as it stands, or its parts looked up, and why."""

import os
import re
import shlex
import sys
import textwrap
from pathlib import Path

import pytest
from click.testing import CliRunner

from mmcs import ROOT
from mmcs.cli.app import main
from mmcs.tests.conftest import GOOD
from tools.compiled import ran, written

PAGES = ran("git", "ls-files", "*README.md", "CONTRIBUTING.md", "docs/*.md").stdout.split()
# Before a fence that nothing runs: what it needs that a test has not.
FENCE = re.compile(r"(?:<!-- no-run: ([^\n]+) -->\n)?^ *```(\w*)([^\n]*)\n(.*?)^ *```", re.M | re.S)
# Fences that tests of their own run, by page and language.
CARRIED = {
    "docs/use/first_hour.md": ({"sh"}, "mmcs/tests/test_first_hour.py"),
    "docs/use/driver.md": ({"c"}, "mmcs/tests/test_examples.py"),
    "docs/use/python.md": ({"python"}, "mmcs/tests/test_front.py"),
    "docs/use/device.md": ({"python"}, "mmcs/tests/test_device_programs.py"),
    "docs/simulator/simulator.md": ({"c"}, "tools/tests/test_docs_commands.py"),
    "labs/README.md": ({"python"}, "labs/tests/conftest.py"),
    "bfm/cocotbext/conformance/README.md": (
        {"sh", "systemverilog"}, "cocotb_tests/bfm/test_conformance.py"
    ),
}  # fmt: skip
LANGUAGES = {"sh", "c", "python", "systemverilog", "toml", "json", "text"}
WHOLE = re.compile(r"^(cc|g\+\+|iverilog) ", re.M)  # fences that are run from first line to last
START = re.compile(r"make|mmcs|\.ci/run|\. \.venv/bin/activate|\.venv/bin/\S+|python|pytest|cc")
# What stands for the reader's own, and what makes a long command short; the options stay.
INSTEAD = {
    "RUN": "own", "...": "seed=1..1000",
    "/tmp/slow": "slow", "puma560_double_buffer": "own", "puma560_single_buffer": "own",
}  # fmt: skip
FEWER = {"--samples": "2", "--faults": "4"}
# Only read by the command's own parser: option, or command, and why it is not run here.
ONLY_READ = {
    "serve": "ends when it is stopped", "exec": "tests of exec run programs", "tool": "the same",
    "--dask": "wants a cluster",
    "--host": "tests of the hosts run it", "film": "wants an arm's run of a second",
    "panic": "wants a run with a panic", "--grid": "tests of sweep run a grid",
}  # fmt: skip
# Pages say that these miss an expectation, or that runs differ; the words that tell it.
MISSES = {"mmcs run lab500 --set host.cpu_us_per_axis=900": "FAILED  overruns = 0"}


# Of each: page, reason for not running it or "", language, text.
FENCES = [(page, reason, kind, textwrap.dedent(body)) for page in PAGES
          for reason, kind, _, body in FENCE.findall((ROOT / page).read_text())]  # fmt: skip


def commands(body: str) -> list[str]:
    lines = (re.sub(r"\s+#.*", "", line).strip() for line in
             body.replace("\\\n", " ").splitlines())  # fmt: skip
    return [line.removesuffix("&").strip() for line in lines if line]


CASES = [(page, line) for page, reason, kind, body in FENCES if kind == "sh" and not reason
         for line in commands(body)]  # fmt: skip
PROGRAMS = [(page, body) for page, reason, kind, body in FENCES if kind == "sh" and not reason
            and WHOLE.search(body) and "sh" not in CARRIED.get(page, ((), ""))[0]]  # fmt: skip


def of_mmcs(line: str) -> list[str]:
    words = shlex.split(line.replace("$(", "").replace(")", ""))
    out = [INSTEAD.get(word, word) for word in words[1:]]
    return [FEWER.get(before, word) for before, word in zip(["", *out], out, strict=False)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With what the pages take for granted: a scenario of the reader's, and a run of lab500."""
    path = tmp_path_factory.mktemp("reader")
    for name in ("sim", "firmware", "rtl", "docs"):
        (path / name).symlink_to(ROOT / name)
    (path / "my.toml").write_text(GOOD)
    for name in ("motor", "step", "softer"):
        page = next(ROOT.glob("docs/**/first_hour.md")).read_text()
        text = re.search(rf"^```toml {name}.toml\n(.*?)^```", page, re.M | re.S)[1]
        (path / f"{name}.toml").write_text(text)
    for name in ("step", "softer"):
        run(["run", f"{name}.toml"], path)
    run(["run", "lab500", "--out", "own"], path)
    return path


def run(words: list[str], folder: Path):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return CliRunner().invoke(main, words)


@pytest.mark.slow
@pytest.mark.parametrize(
    "line", sorted({line for _, line in CASES if re.match(r"(\S*/)?mmcs ", line)})
)
def test_mmcs(folder, tmp_path, line):
    words = of_mmcs(line)
    if ONLY_READ.keys() & set(words):
        name, *rest = words
        if name == "export":
            name, *rest = rest
        command = main.commands.get(name) or main.commands["export"].commands[name]
        command.make_context(name, rest)  # an unknown option would raise
        return
    writes = words[0] in ("run", "campaign", "sweep")
    if writes and "--out" not in words:  # others may run it at the same time
        words += ["--out", str(tmp_path / "out")]
    result = run(words, folder)
    missed = "".join(text for command, text in MISSES.items() if line.startswith(command))
    assert "Traceback" not in result.output and missed in result.output, result.output
    assert result.exit_code == bool(missed), result.output
    assert missed or not writes or "caution" not in result.output, result.output


def test_every_fence_says_its_language():
    bad = [f"{page}: {body[:60]}" for page, _, kind, body in FENCES if kind not in LANGUAGES]
    bad += [page for page in PAGES if (ROOT / page).read_text().count("```") % 2]  # one is open
    assert bad == []


def test_few_fences_are_not_run():
    reasons = [reason for _, reason, *_ in FENCES if reason]
    assert len(reasons) <= 10
    marks = sum((ROOT / page).read_text().count("no-run: ") for page in PAGES)
    assert marks == len(reasons), "a mark stands on the line before its fence"


def test_every_fence_of_code_is_run_or_part_of_what_is():
    """Part of a file that tests run: its lines in their order, however far indented."""
    files = ran("git", "ls-files", "*.py", "*.sv").stdout.split()
    text = {file: flat((ROOT / file).read_text()) for file in files}
    lost = []
    for page, reason, kind, body in FENCES:
        if reason or kind in CARRIED.get(page, ((), ""))[0]:
            continue
        if kind == "sh":
            lost += [f"{page}: {line}" for line in commands(body)
                     if not WHOLE.search(body) and not START.match(line)]  # fmt: skip
        elif kind in ("c", "python", "systemverilog") and not any(
            flat(body) in text[file] for file in files
        ):
            lost.append(f"{page}: {body[:60]}")
    assert lost == []
    for page, (_, test) in CARRIED.items():
        name = "sheet.md" if page.startswith("labs/") else Path(page).name
        assert name in (ROOT / test).read_text() or "README.md" in (ROOT / test).read_text(), test


def flat(text: str) -> str:
    return "\n".join(line.strip() for line in text.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize(("page", "body"), PROGRAMS, ids=[page for page, _ in PROGRAMS])
def test_program(tmp_path, page, body):
    """Compiled and run, from the first line to the last; a chip's bench must find itself good."""
    for name in ("rtl", "firmware", "docs"):
        (tmp_path / name).symlink_to(ROOT / name)
    env = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    done = ran("bash", "-ec", body.replace("-Irtl", "-Wall -Wno-timescale -Irtl"),
               cwd=tmp_path, env=env)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    chip = Path(page).stem
    if (ROOT / f"docs/hardware/chips/{chip}_tb.sv").exists():
        assert done.stdout.endswith(f"{chip}: ok\n") and not done.stderr, done.stdout + done.stderr


def test_program_of_the_simulators_page():
    """Its names as the headers declare them."""
    [body] = [b for p, _, kind, b in FENCES if p == "docs/simulator/simulator.md" and kind == "c"]
    text = f"""#include <stdio.h>
#include "mmcs_sim.h"
#include "mmcs_service.h"
int main(void) {{
{body}
return 0; }}
"""
    done = ran("cc", "-std=c11", "-Wall", "-Werror", "-fsyntax-only", "-Isim/abi",
               "-Ifirmware/include", written("program_of_the_page.c", text), cwd=ROOT)  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "line", sorted({line for _, line in CASES if "pytest" in line.split() and "--dut" not in line})
)
def test_pytest(line):
    """Finds tests; whether they pass is theirs to say, and test_conformance.py's with --dut."""
    words = shlex.split(line)
    options = words[words.index("pytest") + 1 :]
    done = ran(sys.executable, "-m", "pytest", "--collect-only", "-q", *options, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_make():
    text = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([\w-]+):", text, re.M)) | {""}
    for page, line in CASES:
        if line.split()[0] == "make" and "-f" not in line.split():
            words = line.split()[1:]
            assert {w for w in words if "=" not in w} <= targets, f"{page}: {line}"
            for word in words:
                assert "=" not in word or word.partition("=")[0] in text, line


def test_the_table_of_what_to_run_has_every_suite_of_the_hardware():
    table = (ROOT / "CONTRIBUTING.md").read_text().split("| you change |")[1].split("\n\n")[0]
    folders = {file.parent.name for file in ROOT.glob("cocotb_tests/*/cocotb_*.py")}
    assert len(folders) > 6 and {f for f in folders if not re.search(rf"\b{f}\b", table)} == set()


def test_files_and_tools_that_commands_name():
    for page, line in CASES:
        for word in line.split():
            if re.fullmatch(r"[\w.-]*/[\w./-]+\.(py|sv|c|cpp|h)", word):
                assert (ROOT / word).exists(), f"{page}: {word}"


def test_there_are_commands_and_every_reason_is_needed():
    assert len(CASES) > 60
    words = {word for _, line in CASES for word in line.split()}
    assert set(ONLY_READ) <= words and set(INSTEAD) <= words
