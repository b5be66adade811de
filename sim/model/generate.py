# SPDX-License-Identifier: Apache-2.0
"""Makes of the design what the model needs: `generate.py boards|wires|extra|triggers ...`.

boards DIR HOST CLK   registers.vlt (what Verilator keeps visible), *.args (parameters), *.ports
                      shells.sv, shells.vlt: what stands for the chips in the boards
                      plain.vlt: registers of rtl/mmcs.sv as a whole, where wires can be cut
                      boards.inc: registers, inputs and counters of each board, by name
                      decoder.inc: what a card's decoder says
                      *.usual: values that registers and inputs have nearly always
wires DIR HOST CLK N  wires.cpp: what rtl/mmcs.sv wires and computes between the boards of N cards
extra DIR HOST CLK N  extra.inc, extra.vlt: registers of a SoC outside the boards
                      checkers.inc, extra.vlt: the bus checkers, whose reset can be forced
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

from netlist import Instance, Module, Netlist, Var, depends, dissolve, instances, reached  # noqa: E402
from wires import wires_text  # noqa: E402

RULES = tomllib.loads((HERE / "counters.toml").read_text())
# A chip moves its outputs by what the board does, and by nothing of its own: with Safety2026 the
# counter does not, and is part of its board.
SAFE = bool(os.environ.get("MMCS_RTL_PARAMETERS"))
CHIPS = [name for name in RULES["chips"] if not (SAFE and name == "thct2000")]


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


def chips(netlist: Netlist, names: list[str] = CHIPS) -> dict[str, Module]:
    """The chips that are models of their own, one of a name."""
    found: dict[str, Module] = {}
    for board in boards(netlist).values():
        for i in instances(netlist, board):
            if i.module.name in names and found.setdefault(i.module.name, i.module) is not i.module:
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
    counters = {r["register"] for r in RULES["counter"]}
    lines, rules = set(), set()
    for module in {i.module.key: i.module for i in instances(netlist, netlist.top)}.values():
        for name in (v.rpartition(".")[2] for v in module.registers):
            access = "rw" if f"{module.name}.{name}" in counters else "rd"
            lines.add(f'public_flat_{access} -module "{module.name}" -var "{name}"')
    for chip in chips(netlist).values():
        rules |= {f'public_flat_{"rw" if p.direction == "OUTPUT" else "rd"} '
                  f'-module "{chip.name}" -var "{p.name}"' for p in linked(chip)}  # fmt: skip
    # The whole machine's registers may be written between clocks.
    plain = [line.replace("flat_rw", "flat_rd") for line in sorted(lines)]
    own = boards(netlist)
    plain += [f'forceable -module "{c["module"]}" -var "{p}"' for c in RULES["cut"]
              if c["module"] in own for p in c["ports"]]  # fmt: skip
    for name, text in ("registers", sorted(lines)), ("shells", sorted(rules)), ("plain", plain):
        (folder / f"{name}.vlt").write_text("\n".join(["`verilator_config", *text]) + "\n")
    (folder / "shells.sv").write_text("\n".join(map(shell, chips(netlist).values())))
    for name, module in (boards(netlist) | chips(netlist, RULES["chips"])).items():
        write_ports(folder / name, module, usual(netlist, module))


def usual(netlist: Netlist, part: Module) -> str:
    """Registers and inputs of a part that have their usual values, as its model names them."""
    out = []
    inside = [i.path for i in instances(netlist, part) if i.module.name in CHIPS and i.path]
    for i in instances(netlist, part):
        if any(f"{i.path}.".startswith(f"{chip}.") for chip in inside):
            continue
        path = f"{part.name}.{i.path}.".replace("..", ".")
        ports = {p.name for p in part.ports if p.direction == "INPUT" and i.module is part}
        for name, value in RULES["usual"].get(i.module.name, {}).items():
            if i.module is not part and any(p.name == name for p in i.module.ports):
                continue  # of a part that is a board of its own elsewhere
            if name not in ports and name not in i.module.registers:
                raise SystemExit(f"generate: counters.toml: {i.module.name} has no {name}")
            net = name if name in ports else f"{path}{name}"
            net = net.replace(".", "__DOT__").replace("[", "__BRA__").replace("]", "__KET__")
            out.append(f"MMCS_USUAL({net}, {value})\n")
    return "".join(out)


def write_ports(path: Path, module: Module, usual: str = "") -> None:
    """A module's ports, the parameters that it has in this design, and its usual values."""
    path.with_name(f"{path.name}.usual").write_text(usual)
    ports = "".join(f"MMCS_PORT({p.name})\n" for p in module.ports)
    path.with_name(f"{path.name}.ports").write_text(ports)
    values = [v for v in module.vars.values() if v.is_param and "'" in (v.value or "")]
    path.with_name(f"{path.name}.args").write_text(
        "\n".join(f"-G{v.name}={_literal(v.value)}" for v in values) + "\n"
    )


def linked(chip: Module) -> list[Var]:
    """Ports of a chip that lead to the board around it."""
    # illegal_o leads nowhere without Safety2026, and with it the counter is no chip
    return [p for p in chip.ports if p.name not in ("clk_i", "illegal_o")]


def shell(chip: Module) -> str:
    """A chip without contents: its outputs are written by the model."""
    parameters = ", ".join(f"parameter {v.name} = 0" for v in chip.vars.values() if v.is_param)
    ports = ",\n".join(f"  {p.direction.lower()} logic [{p.width - 1}:0] {p.name}"
                       for p in chip.ports)  # fmt: skip
    return f"module {chip.name} #({parameters}) (\n{ports}\n);\nendmodule\n"


def _literal(value: str) -> str:
    return value.replace("'sh", "'h")


class Board:
    """A board's parts, as the tables name them: unit 0 is the board less its chips."""

    def __init__(self, netlist: Netlist, module: Module):
        self.module = module
        self.all = list(instances(netlist, module))
        self.chips = [i for i in self.all if i.module.name in CHIPS]
        self.forward = depends(netlist, module)
        self.registers = [(i, r) for i in self.all for r in i.module.registers]

    def unit(self, path: str) -> int:
        for number, chip in enumerate(self.chips, 1):
            if path == chip.path or path.startswith(chip.path + "."):
                return number
        return 0

    def looks(self, unit: int) -> list[tuple[Instance, str]]:
        """Nets whose change concerns the registers of a unit."""
        ends = {(i.path, r) for i, r in self.registers}
        own = {(i.path, r) for i, r in self.registers if self.unit(i.path) == unit}
        top = self.all[0]
        if unit:
            chip = self.chips[unit - 1]
            return [(chip, p.name) for p in chip.module.ports
                    if p.direction == "INPUT" and p.name not in ("clk_i", "rst_ni")]  # fmt: skip
        nets = [(top, p.name) for p in self.module.ports if p.direction == "INPUT"]
        nets += [(c, p.name) for c in self.chips for p in linked(c.module)
                 if p.direction == "OUTPUT"]  # fmt: skip
        return [(i, n) for i, n in nets if own & self._reached((i.path, n), ends)]

    def links(self, chip: Instance) -> list[Var]:
        """Ports of a chip on wires of the board."""
        pins = next(pins for i in self.all for name, _, pins in i.module.cells
                    if f"{i.path}.{name}".lstrip(".") == chip.path)  # fmt: skip
        return [p for p in linked(chip.module) if pins.get(p.name) is not None]

    def _reached(self, start, ends):
        return reached(self.forward, start, ends)


def boards_text(netlist: Netlist, soc: bool) -> str:
    out = ["// Made by sim/model/generate.py."]
    counters = {r["register"]: r for r in RULES["counter"]}
    rows = []
    for name, module in boards(netlist).items():
        board = Board(netlist, module)
        out.append(f"static const RegisterRow k_{name}_registers[] = {{")
        for i, r in sorted(board.registers, key=lambda x: (x[0].path, x[1])):
            rule = counters.get(f"{i.module.name}.{r}", {})
            strides = [*rule.get("strides", []), 0, 0][:2]
            scope, _, last = r.rpartition(".")
            path = ".".join(x for x in (i.path, scope) if x)
            unless = rule.get("unless", "")
            awake = any((a["module"], a["register"]) == (i.module.name, r) for a in RULES["awake"])
            out.append(
                f'  {{"{path}", "{last}", {i.module.vars[r].width}, {board.unit(i.path)}, '
                f'{strides[0]}, {strides[1]}, {rule.get("margin", 0)}, "{unless}", {int(awake)}}},'
            )
        out += ["};", f"static const NetRow k_{name}_nets[] = {{"]
        for unit in range(len(board.chips) + 1):
            for i, n in board.looks(unit):
                quiet, guard = 0, 0
                for number, rule in enumerate(RULES["quiet"], 1):
                    if rule["module"] == i.module.name and n in rule["inputs"]:
                        quiet, guard = 1, number if "while" in rule else 0
                out.append(f'  {{"{i.path}", "{n}", {unit}, {quiet}, {guard}}},')
        out += ["};", f"static const GuardRow k_{name}_guards[] = {{"]
        for unit, i in enumerate([board.all[0], *board.chips]):
            for number, rule in enumerate(RULES["quiet"], 1):
                if rule["module"] == i.module.name:
                    for n, value in rule.get("while", {}).items():
                        out.append(f'  {{"{i.path}", "{n}", {unit}, {number}, {value}}},')
        out += ['  {"", "", -1, 0, 0},', "};", f"static const PortRow k_{name}_ports[] = {{"]
        heard = next((d["inputs"] for d in RULES["deaf"] if d["module"] == name), [])
        always = {n for r in RULES["quiet"] if r["module"] == name and "while" not in r
                  for n in r["inputs"]}  # fmt: skip
        for p in module.ports:
            out.append(f'  {{"{p.name}", {p.width}, {int(p.direction == "OUTPUT")}, '
                       f"{int(p.name in heard)}, "
                       f"{int(p.name in always)}}},")  # fmt: skip
        out.append("};")
        for unit, chip in enumerate(board.chips, 1):
            out.append(f"static const LinkRow k_{name}_links{unit}[] = {{")
            out += [f'  {{"{p.name}", {int(p.direction == "OUTPUT")}}},' for p in board.links(chip)]
            out.append("};")
        out.append(f"static const UnitRow k_{name}_units[] = {{")
        out.append(f'  {{"", "{name}", nullptr, 0}},')
        out += [f'  {{"{c.path}", "{c.module.name}", k_{name}_links{unit}, '
                f"MMCS_COUNT(k_{name}_links{unit})}},"
                for unit, c in enumerate(board.chips, 1)]  # fmt: skip
        out += ["};"]
        rows.append(f'  {{"{name}", k_{name}_registers, k_{name}_nets, k_{name}_guards, '
                    f"k_{name}_ports, k_{name}_units, MMCS_COUNT(k_{name}_registers), "
                    f"MMCS_COUNT(k_{name}_nets), MMCS_COUNT(k_{name}_guards), "
                    f"MMCS_COUNT(k_{name}_ports), MMCS_COUNT(k_{name}_units)}},")  # fmt: skip
    if soc:
        rows.append('  {"soc_host", nullptr, nullptr, nullptr, k_soc_host_ports, '
                    "k_soc_host_units, 0, 0, 0, MMCS_COUNT(k_soc_host_ports), 1},")  # fmt: skip
    out += ["static const BoardTable kBoards[] = {", *rows, "};"]
    return "\n".join(out) + "\n"


def host_text(module: Module) -> str:
    """The table of a SoC's host: ports only, as it rests by rules of its own (soc_core.cpp)."""
    out = ['static const UnitRow k_soc_host_units[] = {{"", "soc_host", nullptr, 0}};',
           "static const PortRow k_soc_host_ports[] = {"]  # fmt: skip
    out += [f'  {{"{p.name}", {p.width}, {int(p.direction == "OUTPUT")}, 0, 0}},'
            for p in module.ports]  # fmt: skip
    return "\n".join([*out, "};"]) + "\n"


def decoder_text(netlist: Netlist) -> str:
    """All that the decoder says by which a board hears."""
    rule = RULES["deaf"][0]
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
        table = host_text(soc[1]) if soc else ""
        (out / "boards.inc").write_text(table + boards_text(netlist, soc is not None))
        (out / "decoder.inc").write_text(decoder_text(netlist))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
