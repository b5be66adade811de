# SPDX-License-Identifier: Apache-2.0
"""Who may know whom, between the trees and the folders of mmcs/: docs/architecture.md."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from mmcs import ROOT
from tools.compiled import ran

FILES = ran("git", "ls-files", "-co", "--exclude-standard", check=True).stdout.splitlines()
HEADERS = [Path(f) for f in FILES if f.endswith((".h", ".svh", ".def"))]
C, SV = (".h", ".c", ".cpp"), (".sv", ".svh")
# folder: endings, and the folders whose headers it may include; what is generated has no home
MAY_INCLUDE = {
    "rtl": (SV, ("rtl",)),
    "firmware/mc": (C, ("firmware/mc", "firmware/include")),
    "firmware/include": (C, ("firmware/include",)),
    "sim/abi": (C, ()),
    "sim/plant": (C, ("sim/plant", "sim/abi")),
    "sim/model": (C, ("sim/model", "sim/abi", "sim/card")),
    "sim/card": (C, ("sim/card", "sim/model", "sim/abi")),
    "sim/setup": (C, ("sim/setup", "sim/abi", "firmware/include")),
    "sim/service": (C, ("sim/service", "sim/setup", "sim/abi", "firmware/include")),
    "sim/device": (C, ("sim/device", "sim/abi", "firmware/include")),
    "sim/engine": (C, ("sim/engine", "sim/abi", "sim/plant", "sim/model", "sim/hosts", "firmware")),
}
# tree: what of it is exempt, and the modules of ours that the rest may import
MAY_IMPORT = {
    "bfm": ((), ()),
    "labs": (("labs/tests/",), ("mmcs",)),
    "bridges": ((), ("mmcs",)),
    "fpga": (("fpga/tests/", "fpga/netlists/"), ("fpga.build", "tools.pages", "tools.sources")),
    "cocotb_tests": (
        ("cocotb_tests/adaptor/driver.py", "cocotb_tests/dpi/", "cocotb_tests/lib/runner.py"),
        ("cocotb_tests", "mmcs", "mmcs.regs", "tools.sources"),
    ),
}
OURS = ("mmcs", "cocotb_tests", "tools", "bridges", "studies", "fpga", "firmware", "web", "sim")


@pytest.mark.parametrize("folder", MAY_INCLUDE)
def test_headers_come_from_the_trees_that_it_knows(folder):
    endings, known = MAY_INCLUDE[folder]
    files = [f for f in FILES if f.startswith(f"{folder}/") and f.endswith(endings)]
    assert files
    for path in files:
        for name in re.findall(r'^\s*[#`]include "([^"]+)"', (ROOT / path).read_text(), re.M):
            homes = [h.parent for h in HEADERS if h.name == Path(name).name]
            met = [home for home in homes if any(home.is_relative_to(other) for other in known)]
            assert met or not homes, f"{path} includes {name} of {homes}"


def test_the_driver_needs_no_library():
    for path in (f for f in FILES if f.startswith("firmware/mc/") and f.endswith(C)):
        system = re.findall(r"#include <([^>]+)>", (ROOT / path).read_text())
        assert set(system) <= {"stdint.h", "stddef.h", "stdbool.h"}, path


def test_time_passes_in_one_function():
    files = [f for f in FILES if f.startswith(("sim/engine/", "sim/service/")) and f.endswith(C)]
    texts = [(ROOT / path).read_text() for path in files]
    assert sum(len(re.findall(r"\bmodel(?:_|\(\))(?:->|\.)run\(", text)) for text in texts) == 1
    engine = (ROOT / "sim/engine/machine.cpp").read_text()
    body = engine.partition("\nbool Machine::advance(")[2].partition("\n}\n")[0]
    assert "model_->run(" in body


@pytest.mark.parametrize("tree", MAY_IMPORT)
def test_imports_are_of_the_trees_that_it_knows(tree):
    exempt, known = MAY_IMPORT[tree]
    files = [f for f in FILES if f.startswith(f"{tree}/") and f.endswith(".py")]
    assert files
    for path in files:
        for module in re.findall(r"^\s*(?:from|import) ([\w.]+)", (ROOT / path).read_text(), re.M):
            if module.split(".")[0] in OURS and not path.startswith(exempt or "-"):
                allowed = module in known or module.split(".")[0] in {"cocotb_tests"} & set(known)
                assert allowed, f"{path} imports {module}"


# --- the folders of mmcs/ ----------------------------------------------------------------------

PACKAGE = [f for f in FILES if re.match(r"mmcs/(?!.*tests/).*\.py$", f) and (ROOT / f).is_file()]
FOLDERS = sorted({f.split("/")[1] for f in PACKAGE if f.count("/") > 1})
HAND_ON = ("mmcs/__init__.py", "mmcs/__main__.py", "mmcs/front.py")  # public names
# What looks into a folder of mmcs/ from outside, to test, ship or attack it.
DEEPER = {
    "labs/tests/": {"scenario", "tests", "view"},
    "sim/tests/": {"engine", "runs", "tests"},
    "studies/": {"sweeps"},
    "tools/": {"cli", "device", "engine", "runs", "scenario", "sweeps", "tests", "tool", "view"},
    "web/tests/": {"device", "tests", "tool"},
}


def imported(path: str) -> set[str]:
    """Full names of what a file imports, at its top or within a function."""
    found = set()
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def folders_of(path: str) -> set[str]:
    """Folders of mmcs/ that a file imports from."""
    names = [name.split(".") for name in imported(path)]
    known = {*FOLDERS, "tests"}
    return {name[1] for name in names if name[0] == "mmcs" and name[1:] and name[1] in known}


def may_know(folder: str) -> set[str]:
    text = ast.get_docstring(ast.parse((ROOT / "mmcs" / folder / "__init__.py").read_text()))
    (line,) = re.findall(r"^May know: ([^.]+)\.", text, re.M)
    return set(re.findall(r"\w+", line)) - {"nothing"}


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_imports_those_that_it_announces(folder):
    files = [f for f in PACKAGE if f.startswith(f"mmcs/{folder}/")]
    assert set().union(*map(folders_of, files)) - {folder} == may_know(folder)


def test_folders_make_no_circle():
    TopologicalSorter({folder: may_know(folder) for folder in FOLDERS}).prepare()


def test_what_lies_above_folders_imports_none():
    for path in (f for f in PACKAGE if f.count("/") == 1 and f not in HAND_ON):
        assert not folders_of(path), path


def test_the_package_imports_nothing_above_it():
    above = {"studies", "cocotb_tests", "tools", "bridges", "fpga", "mmcs_gymnasium", "mmcs_labs"}
    for path in PACKAGE:
        assert not above & {name.split(".")[0] for name in imported(path)}, path


def test_outside_everybody_imports_public_names():
    for path in (f for f in FILES if f.endswith(".py") and not f.startswith("mmcs/")):
        if (ROOT / path).is_file():
            allowed = next((known for k, known in DEEPER.items() if path.startswith(k)), set())
            assert folders_of(path) <= allowed, path


def test_every_public_name_is_there():
    import mmcs

    for name in mmcs._homes():
        assert getattr(mmcs, name) is not None
