# SPDX-License-Identifier: Apache-2.0
"""What Python reads from mcdef.h is what a C compiler reads from it."""

import os

import pytest

from mmcs import mcdef
from mmcs.device.execute import cflags
from tools.compiled import compiled, ran, written


@pytest.mark.req("DRV-1")
def test_constants_and_sizes_equal_those_of_the_compiler():
    names = sorted(mcdef.constants())
    assert len(names) > 45
    structs = ["mc_param", "mc_state", "mc_stats"]
    lines = [f'  printf("%u\\n", (unsigned)({name}));' for name in names]
    lines += [f'  printf("%u\\n", (unsigned)sizeof(struct {name}));' for name in structs]
    source = written(
        "all.cpp",
        f'#include <cstdio>\n#include "{mcdef.HEADER}"\n#include "{mcdef.EXTRA}"\nint main() {{\n'
        + "\n".join(lines)
        + "\n}\n",
    )
    program = compiled("all", [os.environ.get("CXX", "g++")], [source])
    printed = ran(program, check=True).stdout
    sizes = [mcdef.make_ffi().sizeof(f"struct {name}") for name in structs]
    expected = [mcdef.constants()[name] for name in names] + sizes
    assert [int(line) for line in printed.split()] == expected


def test_declarations_are_parsed_once_and_again_where_they_were_damaged(tmp_path, monkeypatch):
    monkeypatch.setattr(mcdef, "BUILD", tmp_path)
    make = mcdef.make_ffi.__wrapped__
    size = make().sizeof("struct mc_param")
    (kept,) = (tmp_path / "declared").iterdir()
    monkeypatch.setattr("cffi.FFI.cdef", None)  # no parser
    assert make().sizeof("struct mc_param") == size
    monkeypatch.undo()
    monkeypatch.setattr(mcdef, "BUILD", tmp_path)
    whole = kept.read_bytes()
    kept.write_bytes(whole[:100])
    assert make().sizeof("struct mc_param") == size
    assert kept.read_bytes() == whole
    monkeypatch.setattr(mcdef, "BUILD", tmp_path / "file" / "below")
    (tmp_path / "file").touch()
    assert make().sizeof("struct mc_param") == size


PROGRAMS = (
    ("gcc", "old.c", False, "extern int errno;\nmain() { errno = 3; return errno != 3; }\n"),
    ("g++", "new.cpp", True,
     "#include <sys/mcdef.h>\nint main() { return MC_FSCALE != 1024; }\n"),
    ("cc", "plain.c", True,
     "#include <mcdef.h>\nint main(void) { return sizeof(struct mc_param) != 72; }\n"),
)  # fmt: skip


@pytest.mark.parametrize(("compiler", "name", "modern", "text"), PROGRAMS)
def test_flags_of_1989_and_of_today(tmp_path, compiler, name, modern, text):
    done = ran(compiler, *cflags(modern), written(name, text), "-o", tmp_path / "a.out")
    assert (done.returncode, done.stderr) == (0, "")
    assert ran(tmp_path / "a.out").returncode == 0
