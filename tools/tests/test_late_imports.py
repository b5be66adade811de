# SPDX-License-Identifier: Apache-2.0
"""What a function of the studies imports when it is called can be imported: a whole `make bench`
is no test, and stopped after three minutes at a module that its process could not find."""

import ast
import sys

import pytest

from mmcs import ROOT
from tools.compiled import ran

STUDIES = sorted(str(p.relative_to(ROOT)) for p in (ROOT / "studies").rglob("*.py"))
CHECK = """
import importlib, importlib.util, sys
importlib.import_module(sys.argv[1])
print([name for name in sys.argv[2:] if importlib.util.find_spec(name) is None])
"""


@pytest.mark.parametrize("path", STUDIES)
def test_it_is_found(path):
    late = set()
    for function in ast.walk(ast.parse((ROOT / path).read_text())):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in ast.walk(function):
            if isinstance(node, ast.ImportFrom) and not node.level:
                late.add(node.module)
            elif isinstance(node, ast.Import):
                late.update(name.name for name in node.names)
    if not late:
        return
    module = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    done = ran(sys.executable, "-c", CHECK, module, *sorted(late))
    assert done.stdout.strip() == "[]", f"{path}: {done.stdout}{done.stderr}"
