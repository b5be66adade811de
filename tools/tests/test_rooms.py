# SPDX-License-Identifier: Apache-2.0
"""The arrows between the rooms of mmcs/: only those that a room announces, and no circle."""

import ast

import pytest

from mmcs import ROOT
from tools import rooms

FOUND = rooms.modules()
ROOMS = sorted({rooms.room(name, FOUND) for name in FOUND} - {""})


@pytest.fixture(scope="module")
def known():
    return rooms.room_arrows(FOUND)


@pytest.mark.parametrize("name", ROOMS)
def test_a_room_knows_whom_it_says_it_knows(name, known):
    assert known[name] == rooms.told(name)[1]


def test_the_threshold_knows_no_room(known):
    assert known[""] == set()


def test_rooms_and_arrows_are_few(known):
    assert len(ROOMS) <= 10 and sum(map(len, known.values())) <= 30


def test_no_circle(known):
    assert rooms.circle(known) == []
    inner = rooms.arrows(FOUND)
    assert rooms.circle({name: inner[name] for name in inner if name not in rooms.DOOR}) == []


@pytest.mark.parametrize("folder", ["firmware/mc", "sim/device"])
def test_no_circle_of_c_files(folder):
    known = rooms.c_arrows(ROOT / folder)
    assert sum(map(len, known.values())) > 10 and rooms.circle(known) == []


def test_a_circle_of_c_files_is_found(tmp_path):
    (tmp_path / "x.h").write_text("int a_one(int n);\nvoid b_two(void);\n")
    (tmp_path / "a.c").write_text("int a_one(int n) {\n  b_two();\n  return n;\n}\n")
    (tmp_path / "b.c").write_text("void b_two(void) {\n  (void)a_one(1); /* c_x() */\n}\n")
    assert rooms.circle(rooms.c_arrows(tmp_path)) == ["a.c", "b.c", "a.c"]


# Who looks into a room from outside: its inside is what is tested, shipped or attacked.
DEEPER = {
    "labs/tests/": {"scenario", "tests", "view"},
    "sim/tests/engine/test_compilers.py": {"engine"},
    "sim/tests/hosts/test_again.py": {"tests"},
    "tools/parsers.py": {"device", "runs", "sweeps"},
    "tools/setup_venv.py": {"engine"},
    "tools/tests/test_docs_commands.py": {"cli", "tests"},
    "tools/wavegen.py": {"view"},
    "tools/website.py": {"runs", "scenario", "tool", "view"},
    "web/tests/": {"device", "tests", "tool"},
}


def test_outside_everybody_uses_the_front_door():
    used: dict[str, set[str]] = {}
    for path in ROOT.rglob("*.py"):
        name = str(path.relative_to(ROOT))
        if name.startswith(("mmcs/", "build/", ".venv/")):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            names += [a.name for a in node.names] if isinstance(node, ast.Import) else []
            for module in (n for n in names if n.startswith("mmcs.")):
                room = rooms.room(module, FOUND) if module in FOUND else module.split(".")[1]
                allowed = [k for k in DEEPER if name.startswith(k) and room in DEEPER[k]]
                assert not room or allowed, f"{name}: {module}: take it from `mmcs`"
                used.setdefault(next(iter(allowed), ""), set()).add(room)
    assert {k: v for k, v in used.items() if k} == DEEPER


def test_every_name_of_the_door_is_there():
    import mmcs

    for name in mmcs._HOMES:
        assert getattr(mmcs, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = mmcs.nothing


def test_the_product_knows_nobody_above_it():
    """Studies, tests and tools look at the product; it does not know them."""
    above = ("studies", "cocotb_tests", "tools", "bridges", "mmcs_labs", "mmcs.tests")
    for name, path in FOUND.items():
        known = [other for other in rooms.imports(path) if other.split(".")[0] in above]
        assert not known and "mmcs.tests" not in rooms.imports(path), name


def test_a_circle_and_an_unannounced_arrow_are_found(tmp_path):
    for name, text in {
        "a/__init__.py": '"""One.\n\nMay know: nothing.\n"""',
        "a/x.py": "from mmcs.b import y",
        "b/__init__.py": '"""Two.\n\nMay know: a.\n"""',
        "b/y.py": "def f():\n    import mmcs.a.x",
    }.items():
        path = tmp_path / "mmcs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    found = rooms.modules(tmp_path)
    known = rooms.room_arrows(found)
    assert known == {"a": {"b"}, "b": {"a"}}
    assert rooms.circle(known) == ["a", "b", "a"]
    assert rooms.circle(rooms.arrows(found)) == ["mmcs.a.x", "mmcs.b.y", "mmcs.a.x"]
    assert rooms.told("a", tmp_path)[1] != known["a"]


def test_the_page_shows_the_present_arrows():
    text = rooms.DOC.read_text()
    assert rooms.page(text) == text, "docs/architecture.md is stale: run python tools/rooms.py"
