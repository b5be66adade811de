# SPDX-License-Identifier: Apache-2.0
"""The parts of a board, as parts.toml lists them, and the nets between them, from the netlist.

`parts.py` prints what sim/Makefile asks for: the boards and chips, and where packages are.
"""

import re
import sysconfig
import tomllib
from dataclasses import replace
from pathlib import Path

from netlist import Instance, Module, Netlist, Var, instances, reads, writes

RULES = tomllib.loads(Path(__file__).with_name("parts.toml").read_text())
CHIPS = RULES["chips"]


def carried(module: str) -> list[str]:
    """Registers and nets of a module that are data."""
    return RULES["data"].get(module, [])


def decides(rules: dict, module: str) -> dict[str, list[str]]:
    """Of a part: the nets at which data decide, and the registers and nets that then do."""
    found: dict[str, list[str]] = {}
    for name, cells in rules["decides"].get(module, {}).items():
        if isinstance(cells, str):  # a chip
            for event, own in decides(rules, cells).items():
                found[f"{name}.{event}"] = [f"{name}.{cell}" for cell in own]
        else:
            found[name] = cells
    return found


class Board:
    """A board's parts, and the nets between them: part 0 is the board less its chips."""

    def __init__(self, netlist: Netlist, module: Module):
        self.all = list(instances(netlist, module))
        self.modules = {i.path: i.module for i in self.all}
        self.parts = [self.all[0]]
        self.parts += [i for i in self.all if i.path and i.module.name in CHIPS]
        self.registers = [(i, r) for i in self.all for r in i.module.registers]
        rule = decides(RULES, module.name)
        self.decides = [(*split(event), self.part(split(event.strip("!"))[0])) for event in rule]
        self.deciding = {split(cell) for cells in rule.values() for cell in cells}
        self.alias: dict[tuple[str, str], tuple[str, str]] = {}  # of nets that are one
        self.read: list[tuple[tuple[str, str], int]] = []  # a net, and the part that reads it
        self.driven: list[tuple[tuple[str, str], int]] = []
        for i in self.all:
            self._visit(i)

    def part(self, path: str) -> int:
        """The part that an instance belongs to."""
        found = 0
        for number, chip in enumerate(self.parts):
            inside = path == chip.path or path.startswith(chip.path + ".")
            if number and inside and len(chip.path) > len(self.parts[found].path):
                found = number
        return found

    def kind(self, path: str, name: str) -> str:
        """Of a register, or of a port of a part."""
        if name not in carried(self.modules[path].name):
            return "Kind::kControl"
        return "Kind::kDecides" if (path, name) in self.deciding else "Kind::kData"

    def net(self, name: tuple[str, str]) -> tuple[str, str]:
        while name in self.alias:
            name = self.alias[name]
        return name

    def _visit(self, i: Instance) -> None:
        own = self.part(i.path)
        self.read += [((i.path, n), own) for n in i.module.reads]
        self.driven += [((i.path, n), own) for n in i.module.writes]
        for name, _, pins in i.module.cells:
            below = f"{i.path}.{name}".lstrip(".")
            for port, expr in pins.items():
                pin = (below, port)
                if expr is None:
                    continue
                if expr["type"] == "VARREF":
                    a, b = self.net(pin), self.net((i.path, net_name(expr)))
                    if a != b:
                        self.alias[a] = b
                elif self.modules[below].vars[port].direction == "INPUT":
                    self.read += [((i.path, n), own) for n in reads(expr)]
                    self.driven.append((pin, own))
                else:
                    self.read.append((pin, own))
                    self.driven += [((i.path, n), own) for n in writes(expr)]

    def ports(self) -> tuple[list[list[tuple]], dict[str, int]]:
        """Of each part: where its model has a port, its variable, out, its kind, whether it is
        received only by a selected card, the net; and the nets of the board's own ports."""
        readers, drivers, members = {}, {}, {}
        for found, what in (self.read, readers), (self.driven, drivers):
            for name, part in found:
                what.setdefault(self.net(name), set()).add(part)
        for i in self.all:
            for v in i.module.vars.values():
                members.setdefault(self.net((i.path, v.name)), []).append((i.path, v))
        board = {p.name: self.net(("", p.name)) for p in self.all[0].module.ports
                 if p.name != "clk_i"}  # fmt: skip
        numbers = {net: n for n, net in enumerate(dict.fromkeys(
            [*board.values(), *sorted(set(readers) | set(drivers))]))}  # fmt: skip
        selected = RULES["selected"].get(self.all[0].module.name, {"inputs": ()})["inputs"]
        selected = {board[p] for p in selected}
        outputs = {board[p.name] for p in self.all[0].module.ports if p.direction == "OUTPUT"}
        rows: list[list[tuple]] = [[] for _ in self.parts]
        for net, number in numbers.items():
            inside = members.get(net, [])
            driver = drivers.get(net, set())
            for n in range(len(self.parts)):
                out = n in driver
                others = readers.get(net, set()) - {n}
                loop = out and self._variable(n, inside, False)[0] == ""  # around the part
                if loop:
                    rows[n].append((*self._variable(n, inside, False), False, "Kind::kControl",
                                    False, number))  # fmt: skip
                if out and not (others or net in outputs or loop):
                    continue
                if not out and n not in readers.get(net, ()):
                    continue
                if not out and not driver and net not in board.values():
                    continue  # a constant, or the clock
                kinds = {self.kind(path, v.name) for path, v in inside if self.part(path) == n}
                path, var = self._variable(n, inside, out)
                if path is None:
                    if out or driver - {n} or net in board.values():
                        raise SystemExit(f"generate: {self.parts[n].path} has no port for {net}")
                    continue
                kind = next((k for k in ("Kind::kDecides", "Kind::kData") if k in kinds),
                            "Kind::kControl")  # fmt: skip
                sliced = [] if path or out or driver else self.slices(self.parts[n], var)
                for v, own in sliced or [(var, kind)]:
                    rows[n].append((path, v, out, own, net in selected, number))
        return rows, {p: numbers[net] for p, net in board.items()}

    def slices(self, i: Instance, var: Var) -> list[tuple[Var, str]]:
        """An input or a register of which some bits are data: those, and what is between them."""
        path, bits, found = i.path, var.low, []
        names = {cut(d)[1:]: d for d in carried(i.module.name)
                 if cut(d)[0] == var.name and cut(d)[1] is not None}  # fmt: skip
        for high, low in sorted(names, key=lambda s: s[1]):
            data = "Kind::kDecides" if (path, names[high, low]) in self.deciding else "Kind::kData"
            found += [(bits, low - 1, "Kind::kControl"), (low, high, data)]
            bits = high + 1
        top = var.low + var.width - 1
        found += [(bits, top, "Kind::kControl")] if found else []
        return [(replace(var, width=high - low + 1, lsb=low - var.low), kind)
                for low, high, kind in found if low <= high]  # fmt: skip

    def _variable(self, n: int, members: list, out: bool):
        """The variable of a part's model that a net is: a port of its own, or of a chip in it."""
        part = self.parts[n]
        own = "OUTPUT" if out else "INPUT"
        chips = {c.path for c in self.parts[1:]} - {part.path}
        for path, v in members:
            if path == part.path and v.direction == own:
                return "", v
        for path, v in members:
            within = path in chips and self.part(path.rpartition(".")[0]) == n
            if within and v.direction not in ("NONE", own):
                return path[len(part.path) :].lstrip("."), v
        return None, None


def cut(name: str) -> tuple[str, int | None, int | None]:
    """A name, and the bits of it that are meant."""
    found = re.fullmatch(r"(.*)\[(\d+):(\d+)\]", name)
    return (found[1], int(found[2]), int(found[3])) if found else (name, None, None)


def split(name: str) -> tuple[str, str]:
    """A net below a board: the instance that has it, its name there."""
    path, _, last = name.rpartition(".")
    return path, last


def net_name(expr: dict) -> str:
    (name,) = reads(expr) | writes(expr)
    return name


if __name__ == "__main__":
    own = RULES["boards"]
    print(*(f"board:{b}" for b in own), *(f"chip:{c}" for c in CHIPS if c not in own),
          f"packages:{sysconfig.get_path('purelib')}")  # fmt: skip
