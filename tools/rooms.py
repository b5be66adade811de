# SPDX-License-Identifier: Apache-2.0
"""The rooms of mmcs/ and the arrows between them, from the imports, into docs/architecture.md.

A room is a folder of mmcs/. The docstring of its __init__.py says what it holds and, in the line
"May know: a, b.", which other rooms it may import. What lies in mmcs/ itself (errors, mcdef, regs)
is the threshold: everybody may know it, and it knows no room, but for the door, mmcs/__init__.py
and __main__.py, which only hand on public names.
"""

import argparse
import ast
import re
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from tools.pages import splice

ROOT = Path(__file__).resolve().parent.parent
DOC = ROOT / "docs" / "architecture.md"
DOOR = ("mmcs", "mmcs.__main__", "mmcs.front")


def modules(root: Path = ROOT, package: str = "mmcs") -> dict[str, Path]:
    """Every module of the package by its full name, tests left out."""
    found = {}
    for path in sorted((root / package).rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        if "tests" not in parts:
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


def imports(path: Path) -> set[str]:
    """Full names of what a file imports, at its top or within a function."""
    return _imports(path.read_text())


@cache
def _imports(text: str) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {node.module}
    return found


def arrows(found: dict[str, Path]) -> dict[str, set[str]]:
    """Which module knows which other; a package's own __init__ does not count as one it knows."""
    out = {}
    for name, path in found.items():
        known = {other for other in imports(path) if other in found and other != name}
        packages = {other for other in known if found[other].name == "__init__.py"}
        out[name] = known - packages
    return out


def room(module: str, found: dict[str, Path]) -> str:
    """The room a module lies in; "" for the threshold."""
    parts = module.split(".")
    return parts[1] if len(parts) > 2 or (found[module].name == "__init__.py" and parts[1:]) else ""


def room_arrows(found: dict[str, Path]) -> dict[str, set[str]]:
    """Which room knows which other room."""
    out = {room(name, found): set() for name in found}
    for name, known in arrows(found).items():
        if name not in DOOR:
            out[room(name, found)] |= {room(other, found) for other in known}
    return {name: known - {name, ""} for name, known in out.items()}


def told(name: str, root: Path = ROOT) -> tuple[str, set[str]]:
    """(first sentence, rooms that it may know), as the room itself says."""
    text = ast.get_docstring(ast.parse((root / "mmcs" / name / "__init__.py").read_text())) or ""
    line = re.search(r"^May know: ([^.]+)\.", text, re.M)
    if not line:
        raise ValueError(f'mmcs/{name}/__init__.py has no line "May know: ...."')
    known = {word.strip() for word in line[1].split(",")} - {"nothing"}
    return text.splitlines()[0], known


def circle(known: dict[str, set[str]]) -> list[str]:
    """A way that ends where it begins, or nothing."""
    try:
        TopologicalSorter(known).prepare()
    except CycleError as error:
        return error.args[1][::-1]
    return []


def c_arrows(folder: Path) -> dict[str, set[str]]:
    """Which C file of a folder uses a function of which other, of those its headers declare."""
    texts = {
        path.name: re.sub(
            r"/\*.*?\*/|//[^\n]*|\"(\\\\.|[^\"\\\\\n])*\"", "", path.read_text(), flags=re.S
        )
        for path in sorted(folder.glob("*.[ch]"))
    }
    declared = {
        name
        for file, text in texts.items()
        for name in re.findall(r"^\w[\w \*]*?\b(\w+)\([^{};]*\);", text, re.M)
        if file.endswith(".h")
    }
    sources = {file: text for file, text in texts.items() if file.endswith(".c")}
    homes = {
        name: file
        for file, text in sources.items()
        for name in re.findall(r"^\w[\w \*]*?\b(\w+)\([^{};]*\) \{", text, re.M)
        if name in declared
    }
    return {
        file: {homes[word] for word in re.findall(r"\w+", text) if word in homes} - {file}
        for file, text in sources.items()
    }


def table() -> str:
    """The rooms from the lowest floor to the highest, with what each knows."""
    known = {name: others for name, others in room_arrows(modules()).items() if name}
    sorter = TopologicalSorter(known)
    sorter.prepare()
    lines = ["| room | holds | imports |", "|---|---|---|"]
    while floor := sorted(sorter.get_ready()):
        for name in floor:
            others = ", ".join(f"`{other}`" for other in sorted(known[name]))
            lines.append(f"| `{name}/` | {told(name)[0]} | {others or '–'} |")
        sorter.done(*floor)
    return "\n".join(lines)


def counts() -> str:
    known = room_arrows(modules())
    arrows_ = sum(map(len, known.values()))
    return f"{len(known) - 1} rooms, {arrows_} imports between them, no circle."


def page(text: str) -> str:
    return splice(text, "rooms", f"{counts()}\n\n{table()}")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    DOC.write_text(page(DOC.read_text()))
