# SPDX-License-Identifier: Apache-2.0
"""The design as Verilator reads it: instances, variables, registers, and which depends on which.

Everything is taken from the tree that `verilator --json-only` writes after it has elaborated the
design; nothing about the hardware is typed here.
"""

import json
from dataclasses import dataclass, field
from pathlib import Path


class NetlistError(Exception):
    """The design holds something that this reader does not understand."""


def children(node: dict):
    for value in node.values():
        if isinstance(value, list):
            yield from (child for child in value if isinstance(child, dict))


def walk(node: dict):
    yield node
    for child in children(node):
        yield from walk(child)


def _module_vars(node: dict, scope: str = ""):
    """Variables of a module, with the generate blocks around them; not those of its functions."""
    for child in children(node):
        if child.get("type") == "VAR":
            yield scope + child["name"], child
        elif child.get("type") in ("GENBLOCK", "BEGIN"):
            yield from _module_vars(child, _inner(scope, child["name"]))


def _inner(scope: str, name: str) -> str:
    """Generate blocks of a loop come as g_card, then g_card[0] in it: one name."""
    if not name:
        return scope
    if scope and name.startswith(scope.split(".")[-2] + "["):
        return scope[: -len(scope.split(".")[-2]) - 1] + name + "."
    return f"{scope}{name}."


NAMES: dict[str, str] = {}  # of variables in generate blocks, by the tree's address


def _name(node: dict) -> str:
    return NAMES.get(node["varp"], node["name"])


def reads(node: dict) -> set[str]:
    """Variables that an expression reads."""
    return {_name(n) for n in walk(node) if n.get("type") == "VARREF" and n["access"] != "WR"}


def writes(node: dict) -> set[str]:
    return {_name(n) for n in walk(node) if n.get("type") == "VARREF" and n["access"] != "RD"}


@dataclass
class Var:
    name: str
    width: int
    direction: str  # INPUT, OUTPUT, NONE
    is_param: bool
    value: str | None
    low: int = 0  # the number of its lowest bit
    lsb: int = 0  # of a slice: where it begins in the variable


@dataclass
class Module:
    name: str  # as in the source
    key: str
    vars: dict[str, Var] = field(default_factory=dict)
    cells: list[tuple[str, str, dict]] = field(default_factory=list)  # name, module, port: expr
    blocks: list[dict] = field(default_factory=list)  # the always statements themselves
    registers: set[str] = field(default_factory=set)  # what a clock or a strobe writes
    reads: set[str] = field(default_factory=set)  # by statements, those of functions included
    writes: set[str] = field(default_factory=set)

    @property
    def ports(self) -> list[Var]:
        return [v for v in self.vars.values() if v.direction != "NONE" and not v.is_param]


class Netlist:
    def __init__(self, path: Path):
        tree = json.loads(path.read_text())
        self._types = {t["addr"]: t for t in tree["miscsp"][0]["typesp"]}
        self.modules = {
            m["addr"]: self._module(m) for m in tree["modulesp"] if m["type"] == "MODULE"
        }
        self.top = next(iter(self.modules.values()))

    def width(self, dtype: str) -> int:
        kind = self._types[dtype]
        if "range" in kind:
            high, low = kind["range"].split(":")
            return int(high) - int(low) + 1
        if kind["type"] == "BASICDTYPE":
            return {"logic": 1, "bit": 1, "int": 32, "integer": 32}.get(kind["keyword"], 0)
        inner = kind.get("refDTypep")
        if inner and inner != "UNLINKED":
            per = self.width(inner)
            if "declRange" in kind:
                high, low = (int(x) for x in kind["declRange"].strip("[]").split(":"))
                return per * (abs(high - low) + 1)
            return per
        return 0

    def low(self, dtype: str) -> int:
        return int(self._types[dtype].get("range", "0:0").split(":")[1])

    def _module(self, node: dict) -> Module:
        module = Module(node["origName"], node["addr"])
        for name, var in _module_vars(node):
            value = (var.get("valuep") or [{}])[0].get("name")
            if name != var["name"]:
                NAMES[var["addr"]] = name
            module.vars.setdefault(name, Var(
                name, self.width(var["dtypep"]), var["direction"],
                bool(var.get("isGParam")), value, self.low(var["dtypep"])))  # fmt: skip
        self._statements(node.get("stmtsp", []), "", module)
        functions = [n for n in walk(node) if n.get("type") == "FUNC"]
        module.reads.update(*map(reads, [*module.blocks, *functions]))
        module.writes.update(*map(writes, module.blocks))
        return module

    def _statements(self, statements: list, scope: str, module: Module) -> None:
        for node in statements:
            kind = node["type"]
            if kind == "CELL":
                pins = {p["name"]: (p.get("exprp") or [None])[0] for p in node["pinsp"]}
                module.cells.append((scope + node["name"], node["modp"], pins))
            elif kind in ("GENBLOCK", "BEGIN"):
                inner = _inner(scope, node["name"])
                for value in node.values():
                    if isinstance(value, list):
                        self._statements(value, inner, module)
            elif kind in ("ALWAYS", "INITIAL"):
                module.blocks.append(node)
                if any(c.get("type") == "SENTREE" for c in children(node)):
                    late = (n["lhsp"][0] for n in walk(node) if n.get("type") == "ASSIGNDLY")
                    module.registers.update(*map(writes, late))


def dissolve(netlist: Netlist, outer: Module, name: str) -> None:
    """What a module holds of its own becomes its surroundings': its cells keep their names."""
    at = next(n for n, (cell, _, _) in enumerate(outer.cells) if cell == name)
    _, key, pins = outer.cells[at]
    inner = netlist.modules[key]
    names = {port: expr["name"] for port, expr in pins.items() if expr is not None}
    if any(expr["type"] != "VARREF" for expr in pins.values() if expr is not None):
        raise NetlistError(f"{name}: a pin is no plain net")
    pinned = (expr for _, _, below in inner.cells for expr in below.values() if expr is not None)
    for node in (n for tree in (*inner.blocks, *pinned) for n in walk(tree)):
        if node.get("type") == "VARREF":
            node["name"] = names.get(node["name"], node["name"])
    for var in inner.vars.values():
        if var.direction == "NONE" and not var.is_param:
            outer.vars.setdefault(var.name, var)
    outer.cells[at : at + 1] = inner.cells
    outer.blocks += inner.blocks
    outer.registers |= inner.registers


@dataclass
class Instance:
    path: str  # "" for the top
    module: Module


def instances(netlist: Netlist, module: Module, path: str = ""):
    """This instance and all below."""
    yield Instance(path, module)
    for name, key, _ in module.cells:
        below = f"{path}.{name}" if path else name
        yield from instances(netlist, netlist.modules[key], below)


def cpp(value) -> str:
    """A C++ initializer: lists and tuples in braces, texts in quotes but for members of Kind."""
    if isinstance(value, list | tuple):
        return "{" + ",\n".join(map(cpp, value)) + "}"
    if isinstance(value, str):
        return value if value.startswith("Kind::") else f'"{value}"'
    return str(int(value))
