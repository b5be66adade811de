# SPDX-License-Identifier: Apache-2.0
"""What is compiled for tests is made anew when anything that it reads changes, and only then."""

import pytest

from tools import compiled as module
from tools.compiled import CompileError, compiled, ran


@pytest.fixture
def program(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "STORE", tmp_path / "store")
    (tmp_path / "said.h").write_text('#define SAID "one"\n')
    text = '#include <stdio.h>\n#include "said.h"\nint main(void) { return puts(SAID) < 0; }\n'
    (tmp_path / "a.c").write_text(text)

    def make(*flags):
        return compiled("program", ["cc", *flags], [tmp_path / "a.c"])

    return make


def said(path):
    return ran(path, check=True).stdout


def test_nothing_is_made_twice(program, monkeypatch):
    path = program()
    monkeypatch.setattr(module.subprocess, "run", None)
    assert program() == path


@pytest.mark.parametrize("compiler", ["cc", "clang"])
def test_a_header_of_the_first_of_two_sources_changes(program, tmp_path, compiler):
    (tmp_path / "b.c").write_text("int b;\n")

    def make():
        return compiled("program", [compiler], [tmp_path / "a.c", tmp_path / "b.c"])

    assert said(make()) == "one\n"
    (tmp_path / "said.h").write_text('#define SAID "two"\n')
    assert said(make()) == "two\n"


def test_a_flag_changes_or_the_compiler(program, tmp_path, monkeypatch):
    made = {program(), program("-O1")}
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    for _ in "ab":  # of one size
        (tmp_path / "cc").write_text('#!/bin/sh\nexec gcc "$@"\n')
        (tmp_path / "cc").chmod(0o755)
        made.add(program())
    assert len(made) == 4


def test_half_a_store_is_made_anew(program):
    path = program()
    (path.parent / "made_of.json").write_text("{")
    assert said(program()) == "one\n"


def test_what_is_refused_is_refused_again(program, tmp_path):
    program()
    (tmp_path / "a.c").write_text("int main(void) { return x; }\n")
    for _ in range(2):
        with pytest.raises(CompileError, match="error: .x. undeclared"):
            program()


def test_no_such_compiler():
    with pytest.raises(FileNotFoundError, match="no-such-cc"):
        compiled("x", ["no-such-cc"], [])
