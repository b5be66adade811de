# SPDX-License-Identifier: Apache-2.0
"""Every command of README and the docs: run as it stands, or its parts looked up, and why."""

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from mmcs import ROOT
from mmcs.cli.app import main
from mmcs.tests.conftest import GOOD
from tools.compiled import ran

PAGES = ran("git", "ls-files", "README.md", "CONTRIBUTING.md", "docs/*.md").stdout.split()
START = re.compile(r"(make|mmcs|\.venv/bin/\S+|python|pytest|cc|g\+\+|iverilog|\w+=\S+)( |$)")
# What stands for the reader's own, and what makes a long command short; the options stay.
INSTEAD = {
    "RUN": "own", "RUN@0.25": "own@0.25", "NAME": "lab500", "...": "seed=1..1000",
    "/tmp/slow": "slow", "puma560_double_buffer": "own", "puma560_single_buffer": "own",
}  # fmt: skip
FEWER = {"--samples": "2", "--faults": "4"}
# Only read by the command's own parser: option, or command, and why it is not run here.
ONLY_READ = {
    "serve": "ends when it is stopped", "exec": "tests of exec run programs", "tool": "the same",
    "--apply": "wants a running server", "--dask": "wants a cluster",
    "--host": "tests of the hosts run it", "film": "wants an arm's run of a second",
    "panic": "wants a run with a panic", "--grid": "tests of sweep run a grid",
}  # fmt: skip
# Pages say that these miss an expectation, or that runs differ; the words that tell it.
MISSES = {
    "mmcs run lab500 --set host.cpu_us_per_axis=900": "FAILED  overruns = 0",
}


def commands(page: str) -> list[str]:
    found = []
    for kind, body in re.findall(
        r"^```(\w*)[^\n]*\n(.*?)^```", (ROOT / page).read_text(), re.M | re.S
    ):
        if kind in ("", "sh"):
            lines = (re.sub(r"\s+#.*", "", line).strip() for line in
                     body.replace("\\\n", " ").splitlines())  # fmt: skip
            found += [line.removesuffix("&").strip() for line in lines if START.match(line)]
    return [line for line in found if not re.match(r"mmcs[./]", line)]  # a drawing


CASES = [(page, line) for page in PAGES for line in commands(page)]


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
    assert "Traceback" not in result.output
    misses = [text for command, text in MISSES.items() if line.startswith(command)]
    if misses:
        assert result.exit_code == 1 and misses[0] in result.output, result.output
    else:
        assert result.exit_code == 0, result.output
        assert not writes or "caution" not in result.output, result.output


def test_make():
    text = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([\w-]+):", text, re.M)) | {""}
    for page, line in CASES:
        if line.split()[0] == "make" and "-f" not in line.split():
            words = line.split()[1:]
            assert {w for w in words if "=" not in w} <= targets, f"{page}: {line}"
            for word in words:
                variable = word.partition("=")[0]
                assert "=" not in word or f"$({variable})" in text or f"{variable}" in text, line


def test_files_and_tools_that_commands_name():
    for page, line in CASES:
        for word in line.split():
            if re.fullmatch(r"[\w./-]+\.(py|sv|c|cpp|h)", word):
                assert (ROOT / word).exists(), f"{page}: {word}"


def test_there_are_commands_and_every_reason_is_needed():
    assert len(CASES) > 60
    words = {word for _, line in CASES for word in line.split()}
    assert set(ONLY_READ) <= words and set(INSTEAD) <= words
