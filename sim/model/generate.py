# SPDX-License-Identifier: Apache-2.0
"""Makes of the design what the model needs: `generate.py parts|boards|wires|extra|triggers ...`.

boards DIR HOST CLK   registers.vlt (what Verilator keeps visible), *.args (parameters), *.ports
                      *_shell.sv, *_shell.vlt: what stands for a chip in other parts
                      plain.vlt: registers of rtl/mmcs.sv as a whole, where wires can be cut
                      boards.inc: registers and ports of each part, by name
                      decoder.inc: what a card's decoder says
wires DIR HOST CLK N  wires.cpp: what rtl/mmcs.sv wires and computes between the boards of N cards
extra DIR HOST CLK N  extra.inc, extra.vlt: registers of a SoC outside the boards
                      checkers.inc, extra.vlt: the bus checkers, whose reset can be forced
parts boards|chips HOST  prints their modules
triggers DIR          triggers.inc: which bit stands for which clock, from Verilator's own words
                      V*.edges: values before and now of what edges are looked for

With HOST rv32 the machine is the one in rtl/soc/mmcs_soc.sv, and its host one board more.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(HERE), str(ROOT / "tools")]

from netlist import Instance, Module, Netlist, dissolve, instances, reads, writes  # noqa: E402
from wires import wires_text  # noqa: E402

RULES = tomllib.loads((HERE / "parts.toml").read_text())
CHIPS = RULES["chips"]


def read_design(folder: Path, cards: int, clk_hz: str, top: str = "mmcs",
                sets: tuple[str, ...] = ("rtl",)) -> Netlist:  # fmt: skip
    from sources import core_arguments, sources

    folder.mkdir(parents=True, exist_ok=True)
    files = [str(f) for name in sets for f in sources(name)]
    subprocess.run(
        ["verilator", "--json-only", "--no-timing", "-Wno-fatal", "-Wno-lint", "--quiet",
         f"-GNumCards={cards}", f"-GClkHz={clk_hz}",
         *os.environ.get("MMCS_RTL_PARAMETERS", "").split(), "--top-module", top,
         "--prefix", "Vtree",
         f"-I{ROOT / 'rtl'}", "-Mdir", str(folder), "-DMMCS_NO_ASSERT", "-DMMCS_NO_BUS_TIMES",
         *(core_arguments() if "soc" in sets else []), *files],
        check=True)  # fmt: skip
    return Netlist(folder / "Vtree.tree.json")


def boards(netlist: Netlist) -> dict[str, Module]:
    """The modules that mmcs.sv is made of, one of a name."""
    found: dict[str, Module] = {}
    for _, key, _ in netlist.top.cells:
        module = netlist.modules[key]
        if found.setdefault(module.name, module) is not module:
            raise SystemExit(f"generate: boards {module.name} of different parameters")
    return found


def chips(netlist: Netlist) -> dict[str, Module]:
    """The chips that are models of their own, one of a name."""
    found: dict[str, Module] = {}
    for board in boards(netlist).values():
        for i in instances(netlist, board):
            if (
                i.path
                and i.module.name in CHIPS
                and found.setdefault(i.module.name, i.module) is not i.module
            ):
                raise SystemExit(f"generate: chips {i.module.name} of different parameters")
    return found


def machine(netlist: Netlist) -> tuple[Netlist, tuple | None]:
    """The netlist with the boards at its top; and, in a SoC, its host: path, module, pins by port,
    and the pins of the machine."""
    cells = {path: (netlist.modules[key], pins) for path, key, pins in netlist.top.cells}
    host = None
    if "u_mmcs" in cells:
        netlist.top, outer = cells["u_mmcs"]
        host = ("u_host", *cells["u_host"], outer)
    dissolve(netlist, netlist.top, "u_cards")
    return netlist, host


def config(folder: Path, netlist: Netlist) -> None:
    lines = set()
    for module in {i.module.key: i.module for i in instances(netlist, netlist.top)}.values():
        for name in (v.rpartition(".")[2] for v in module.registers):
            lines.add(f'public_flat_rd -module "{module.name}" -var "{name}"')
    # The whole machine's registers may be written between clocks.
    plain = sorted(lines)
    plain += [f'forceable -module "{board}" -var "{p}"' for board in boards(netlist)
              for p in RULES["cut"].get(board, [])]  # fmt: skip
    texts = {"registers": sorted(lines), "plain": plain}
    for name, chip in chips(netlist).items():
        texts[f"{name}_shell"] = [
            f'public_flat_{"rw" if p.direction == "OUTPUT" else "rd"} '
            f'-module "{name}" -var "{p.name}"'
            for p in chip.ports if p.name != "clk_i"
        ]  # fmt: skip
        (folder / f"{name}_shell.sv").write_text(shell(chip))
    for name, text in texts.items():
        (folder / f"{name}.vlt").write_text("\n".join(["`verilator_config", *text]) + "\n")
    for name, module in (boards(netlist) | chips(netlist)).items():
        write_ports(folder / name, module)


def write_ports(path: Path, module: Module) -> None:
    """A module's ports, and the parameters that it has in this design."""
    ports = "".join(f"MMCS_PORT({p.name})\n" for p in module.ports)
    path.with_name(f"{path.name}.ports").write_text(ports)
    values = [v for v in module.vars.values() if v.is_param and "'" in (v.value or "")]
    path.with_name(f"{path.name}.args").write_text(
        "\n".join(f"-G{v.name}={_literal(v.value)}" for v in values) + "\n"
    )


def shell(chip: Module) -> str:
    """A chip without contents: its outputs are written by the model."""
    parameters = ", ".join(f"parameter {v.name} = 0" for v in chip.vars.values() if v.is_param)
    ports = ",\n".join(f"  {p.direction.lower()} logic [{p.width - 1}:0] {p.name}"
                       for p in chip.ports)  # fmt: skip
    return f"module {chip.name} #({parameters}) (\n{ports}\n);\nendmodule\n"


def _literal(value: str) -> str:
    return value.replace("'sh", "'h")


def carried(module: str) -> list[str]:
    """Registers and nets of a module that are data."""
    return RULES["data"].get(module, []) + RULES["through"].get(module, [])


class Board:
    """A board's parts, and the nets between them: part 0 is the board less its chips."""

    def __init__(self, netlist: Netlist, module: Module):
        self.all = list(instances(netlist, module))
        self.modules = {i.path: i.module for i in self.all}
        self.parts = [self.all[0]]
        self.parts += [i for i in self.all if i.path and i.module.name in CHIPS]
        self.registers = [(i, r) for i in self.all for r in i.module.registers]
        self.alias: dict[tuple[str, str], tuple[str, str]] = {}  # of nets that are one
        self.read: list[tuple[tuple[str, str], int]] = []  # a net, and the part that looks at it
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

    def net(self, name: tuple[str, str]) -> tuple[str, str]:
        while name in self.alias:
            name = self.alias[name]
        return name

    def _visit(self, i: Instance) -> None:
        own = self.part(i.path)
        for assign in i.module.assigns:
            self.read += [((i.path, n), own) for n in assign.sources]
            self.driven += [((i.path, n), own) for n in assign.target]
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
        """Of each part: where its model has a port, its variable, out, data, whether it is heard,
        the net; and the nets of the board's own ports."""
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
        heard = (
            RULES["heard"]["inputs"] if RULES["heard"]["module"] == self.all[0].module.name else []
        )
        heard = {board[p] for p in heard}
        rows: list[list[tuple]] = [[] for _ in self.parts]
        for net, number in numbers.items():
            inside = members.get(net, [])
            if any(v.name.endswith("clk_i") for _, v in inside):
                continue
            driver = drivers.get(net, set())
            for n in range(len(self.parts)):
                out = n in driver
                others = readers.get(net, set()) - {n}
                outside = any(net == b and v.direction == "OUTPUT" for p, b in board.items()
                              for v in [self.all[0].module.vars[p]])  # fmt: skip
                loop = out and self._variable(n, inside, False)[0] == ""  # around the part
                if loop:
                    rows[n].append((*self._variable(n, inside, False), False, False, False, number))
                if out and not (others or outside or loop):
                    continue
                if not out and n not in readers.get(net, ()):
                    continue
                if not out and not driver and net not in board.values():
                    continue  # a constant
                data = any(v.name in carried(self.modules[path].name)
                           for path, v in inside if self.part(path) == n)  # fmt: skip
                path, var = self._variable(n, inside, out)
                if path is None:
                    if out or driver - {n} or net in board.values():
                        raise SystemExit(f"generate: {self.parts[n].path} has no port for {net}")
                    continue
                rows[n].append((path, var, out, data, net in heard, number))
        return rows, {p: numbers[net] for p, net in board.items()}

    def _variable(self, n: int, members: list, out: bool):
        """The variable of a part's model that a net is: a port of its own, or of a chip in it."""
        part = self.parts[n]
        own = "OUTPUT" if out else "INPUT"
        for path, v in members:
            if path == part.path and v.direction == own:
                return "", v
        for path, v in members:
            chip = any(c.path == path for c in self.parts[1:]) and path != part.path
            if (
                chip
                and v.direction not in ("NONE", own)
                and self.part(path.rpartition(".")[0]) == n
            ):
                return path[len(part.path) :].lstrip("."), v
        return None, None


def net_name(expr: dict) -> str:
    (name,) = reads(expr) | writes(expr)
    return name


def port_rows(ports: list[tuple], driven: dict) -> list[str]:
    return [f'  {{"{path}", "{v.name}", {v.width}, {int(out)}, {int(data)}, {int(heard)}, '
            f'{driven.get((path, v.name), -1)}, {net}}},'
            for path, v, out, data, heard, net in ports]  # fmt: skip


def boards_text(netlist: Netlist, soc: bool) -> str:
    out = ["// Made by sim/model/generate.py."]
    rows = []
    for name, module in boards(netlist).items():
        board = Board(netlist, module)
        out.append(f"static const RegisterRow k_{name}_registers[] = {{")
        for i, r in sorted(board.registers, key=lambda x: (x[0].path, x[1])):
            scope, _, last = r.rpartition(".")
            path = ".".join(x for x in (i.path, scope) if x)
            margin = RULES["counters"].get(f"{i.module.name}.{r}")
            kind = (
                "Kind::kCounter"
                if margin is not None
                else (
                    "Kind::kData" if r in RULES["data"].get(i.module.name, []) else "Kind::kControl"
                )
            )
            out.append(f'  {{"{path}", "{last}", {i.module.vars[r].width}, {board.part(i.path)}, '
                       f"{kind}, {-1 if margin is None else margin}}},")  # fmt: skip
        out.append("};")
        ports, own = board.ports()
        for n, rows_of in enumerate(ports):
            # what a chip does not drive is ones: where the port is that tells
            driven = {}
            for path, v, is_out, data, _, _ in rows_of:
                chip = board.modules[f"{board.parts[n].path}.{path}".strip(".")].name
                tells = CHIPS.get(chip, {}).get("driven") if path and data and not is_out else None
                for index, row in enumerate(rows_of):
                    if row[0] == path and row[1].name == tells:
                        driven[(path, v.name)] = index
            out += [f"static const PortRow k_{name}_ports{n}[] = {{", *port_rows(rows_of, driven)]
            out.append("};")
        out.append(f"static const PartRow k_{name}_parts[] = {{")
        out += [f'  {{"{p.path}", "{p.module.name}", k_{name}_ports{n}, '
                f"MMCS_COUNT(k_{name}_ports{n})}},"
                for n, p in enumerate(board.parts)]  # fmt: skip
        out += ["};", f"static const NetRow k_{name}_nets[] = {{"]
        out += [f'  {{"{port}", {net}}},' for port, net in own.items()]
        out.append("};")
        rows.append(table_row(name))
    if soc:
        rows.append('  {"soc_host", nullptr, k_soc_host_parts, k_soc_host_nets, 0, 1, '
                    "MMCS_COUNT(k_soc_host_nets)},")  # fmt: skip
    out += ["static const BoardTable kBoards[] = {", *rows, "};"]
    return "\n".join(out) + "\n"


def table_row(name: str) -> str:
    tables = [f"k_{name}_{what}" for what in ("registers", "parts", "nets")]
    return (
        f'  {{"{name}", {", ".join(tables)}, '
        + ", ".join(f"MMCS_COUNT({t})" for t in tables)
        + "},"
    )


def host_text(module: Module, pins: dict, outer: dict) -> str:
    """The table of a SoC's host: ports only, as it rests by rules of its own (soc_core.cpp)."""
    nets = {e["name"] for e in outer.values() if e is not None and e["type"] == "VARREF"}
    met = [p for p in module.ports
           if "clk" not in p.name and (pins.get(p.name) or {}).get("name") in nets]  # fmt: skip
    rows = [("", p, p.direction == "OUTPUT", False, False, n) for n, p in enumerate(met)]
    out = ["static const PortRow k_soc_host_ports[] = {", *port_rows(rows, {}), "};",
           'static const PartRow k_soc_host_parts[] = {{"", "soc_host", k_soc_host_ports, '
           "MMCS_COUNT(k_soc_host_ports)}};",
           "static const NetRow k_soc_host_nets[] = {"]  # fmt: skip
    out += [f'  {{"{p.name}", {n}}},' for n, p in enumerate(met)]
    return "\n".join([*out, "};"]) + "\n"


def decoder_text(netlist: Netlist) -> str:
    """All that the decoder says by which a board hears."""
    rule = RULES["heard"]
    decoder = next(i for i in instances(netlist, boards(netlist)[rule["module"]])
                   if i.path == rule["decoder"])  # fmt: skip
    outputs = (p for p in decoder.module.ports if p.direction == "OUTPUT")
    return "".join(f"MMCS_SAYS({p.name}, {p.width})\n" for p in outputs)


def extra(folder: Path, netlist: Netlist) -> None:
    """What there is outside the boards: bus checkers, or the registers of a SoC's processor."""
    known = {"adaptor_vme", "adaptor_core", "mmcs_cards"}
    soc = netlist.top.name == "mmcs_soc"
    checkers = [(name, netlist.modules[key].name) for name, key, _ in netlist.top.cells
                if not soc and netlist.modules[key].name not in known]  # fmt: skip
    rows, lines = [], set()

    def visit(module: Module, path: str) -> None:
        for r in module.registers:
            scope, _, last = r.rpartition(".")
            rows.append(f'{{"{path}{scope and "." + scope}", "{last}"}},')
            lines.add(f'public_flat_rd -module "{module.name}" -var "{last}"')
        for name, key, _ in module.cells:
            below = netlist.modules[key]
            if below.name not in known:
                visit(below, f"{path}.{name}")

    if soc:
        visit(netlist.top, f"TOP.{netlist.top.name}")
    lines |= {f'forceable -module "{module}" -var "rst_ni"' for _, module in checkers}
    for module in {m.name for m in netlist.modules.values()} & set(RULES["soc"]):
        lines |= {f'public_flat_rd -module "{module}" -var "{n}"' for n in RULES["soc"][module]}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "extra.inc").write_text("\n".join(rows) + "\n")
    (folder / "checkers.inc").write_text("".join(f'"{name}",\n' for name, _ in checkers))
    (folder / "extra.vlt").write_text("\n".join(["`verilator_config", *sorted(lines)]) + "\n")
    write_ports(folder / "mmcs", netlist.top)
    for module in (netlist.modules[key] for _, key, _ in netlist.top.cells):
        if module.name == "soc_host":
            write_ports(folder / module.name, module)


def edges_text(model: Path) -> str:
    """The values whose edges a model looks for, the clock apart, each with that before."""
    text = model.read_text().split("___eval_triggers_vec__act(", 1)[1].split("\n}", 1)[0]
    pairs = re.findall(r"vlSelfRef\.(__Vtrigprev\w+)\s*=\s*([^;,]+);", text)
    if len(pairs) != len(re.findall(r"__Vtrigprev\w+\s*=", text)):
        raise SystemExit(f"generate: {model.name} looks for edges that are not understood")
    found = {old: " ".join(new.replace("vlSelfRef.", "root_->").split()) for old, new in pairs}
    return "".join(f"MMCS_EDGE({o}, {n})\n" for o, n in found.items() if n != "root_->clk_i")


def triggers_text(folder: Path) -> str:
    """Verilator's tables of triggers: index of each clock and reset, by its expression."""
    out = ["// Made by sim/model/generate.py."]
    for path in sorted(folder.glob("v/V*__Slow.cpp")):
        text = path.read_text()
        for model in set(re.findall(r"(V\w+?)___024root___dump_triggers__act", text)):
            body = text.split(f"{model}___024root___dump_triggers__act", 1)[1].split("\n}", 1)[0]
            found = re.findall(r"trigger index (\d+) is active: @\((\w+) ([^)]+)\)", body)
            for index, edge, name in found:
                out.append(f'{{"{model}", {index}, {int(edge == "posedge")}, "{name}"}},')
    return "\n".join(sorted(set(out))) + "\n"


def main() -> int:
    what, folder, *rest = sys.argv[1:]
    if what == "parts":
        own = RULES["boards"][rest[0]]
        print(*(own if folder == "boards" else [chip for chip in CHIPS if chip not in own]))
        return 0
    out = Path(folder)
    if what == "triggers":
        (out / "triggers.inc").write_text(triggers_text(out))
        for model in out.glob("v/V*___024root__*[0-9].cpp"):
            if "void" in model.read_text().partition("___eval_triggers_vec__act(")[0][-60:]:
                name = model.name.partition("___024root")[0]
                (out / f"{name}.edges").write_text(edges_text(model))
        return 0
    host, clk_hz, *number = rest
    cards = int(number[0]) if number else 1
    top, sets = ("mmcs_soc", ("rtl", "soc")) if host == "rv32" else ("mmcs", ("rtl",))
    if what == "extra":
        sets = sets if host == "rv32" else ("rtl", "checkers")
        extra(out, read_design(out / "tree", cards, clk_hz, top, sets))
        return 0
    netlist, soc = machine(read_design(out / "tree", cards, clk_hz, top, sets))
    if what == "wires":
        (out / "wires.cpp").write_text(wires_text(netlist, cards, soc))
    else:
        config(out, netlist)
        table = host_text(*soc[1:]) if soc else ""
        (out / "boards.inc").write_text(table + boards_text(netlist, soc is not None))
        (out / "decoder.inc").write_text(decoder_text(netlist))
        models = dict.fromkeys([*RULES["boards"][host], *CHIPS, *(["soc_host"] if soc else [])])
        (out / "models.inc").write_text("".join(f"MMCS_MODEL_OF({m})\n" for m in models))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
