# SPDX-License-Identifier: Apache-2.0
"""Makes of the design what the model needs: `generate.py boards|wires|checkers ...`.

boards DIR CLK        registers.vlt (what Verilator keeps visible), *.args (parameters), *.ports
                      *_shell.sv, *_shell.vlt: a chip without contents, for other parts
                      plain.vlt: registers of rtl/mmcs.sv as a whole, where wires can be cut
                      boards.inc: registers and ports of each part, by name
                      decoder.inc: the outputs of a card's address decoder
wires DIR CLK N       wires.cpp: how rtl/mmcs.sv wires the boards of N cards
                      *_shell.sv, glue.vlt: empty boards, and what is visible between them
checkers DIR CLK N    checkers.inc, checkers.vlt: the bus checkers, whose reset can be forced
"""

import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(HERE), str(ROOT / "tools")]

from netlist import Instance, Module, Netlist, cpp, dissolve, instances  # noqa: E402
from parts import CHIPS, RULES, Board  # noqa: E402
from wires import Wires  # noqa: E402


def read_design(folder: Path, cards: int, clk_hz: str, *sets: str) -> Netlist:
    from sources import sources

    folder.mkdir(parents=True, exist_ok=True)
    files = [str(f) for name in sets for f in sources(name)]
    subprocess.run(
        ["verilator", "--json-only", "--no-timing", "-Wno-fatal", "-Wno-lint", "--quiet",
         f"-GNumCards={cards}", f"-GClkHz={clk_hz}",
         *os.environ.get("MMCS_RTL_PARAMETERS", "").split(), "--top-module", "mmcs",
         "--prefix", "Vtree",
         f"-I{ROOT / 'rtl'}", "-Mdir", str(folder), "-DMMCS_NO_ASSERT", "-DMMCS_NO_BUS_TIMES",
         *files],
        check=True)  # fmt: skip
    return Netlist(folder / "Vtree.tree.json")


def by_name(modules: Iterable[Module]) -> dict[str, Module]:
    found: dict[str, Module] = {}
    for module in modules:
        if found.setdefault(module.name, module) is not module:
            raise SystemExit(f"generate: {module.name} has different parameters")
    return found


def boards(netlist: Netlist) -> dict[str, Module]:
    """The modules that mmcs.sv is made of, one of a name."""
    return by_name(netlist.modules[key] for _, key, _ in netlist.top.cells)


def chips(netlist: Netlist) -> dict[str, Module]:
    """The chips that are models of their own, one of a name."""
    inside = (i for board in boards(netlist).values() for i in instances(netlist, board) if i.path)
    return by_name(i.module for i in inside if i.module.name in CHIPS)


def config(folder: Path, netlist: Netlist) -> None:
    lines = set()
    for module in {i.module.key: i.module for i in instances(netlist, netlist.top)}.values():
        for name in (v.rpartition(".")[2] for v in module.registers):
            lines.add(f'public_flat_rd -module "{module.name}" -var "{name}"')
    # The whole machine's registers may be written between clocks.
    plain = sorted(lines)
    for board in map(lambda m: Board(netlist, m), boards(netlist).values()):
        for path, name, _ in board.decides:
            module, net = board.modules[path].name, name.strip("!")
            lines.add(f'public_flat_rd -module "{module}" -var "{net}"')
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
        "\n".join(f"-G{v.name}={v.value}" for v in values).replace("'sh", "'h") + "\n"
    )


def shell(module: Module) -> str:
    """A chip or board without contents: its outputs are written by the model."""
    parameters = ", ".join(f"parameter {v.name} = 0" for v in module.vars.values() if v.is_param)
    ports = ",\n".join(f"  {p.direction.lower()} logic [{p.width - 1}:0] {p.name}"
                       for p in module.ports)  # fmt: skip
    return f"module {module.name} #({parameters}) (\n{ports}\n);\nendmodule\n"


def port_rows(board: Board, part: Instance, rows: list[tuple]) -> list[tuple]:
    """Rows of PortRow. Data that a chip does not drive are ones: while which port is 0."""
    at = {(path, v.name): index for index, (path, v, *_) in enumerate(rows)}
    rule = CHIPS.get(part.module.name, {}) if part.path else {}
    select = {p: at["", rule["select"]] for p in rule.get("bus", ())}

    def driven(path: str, out: bool, kind: str) -> int:
        if not path or out or kind == "Kind::kControl":
            return -1
        chip = board.modules[f"{part.path}.{path}".strip(".")].name
        return at.get((path, CHIPS.get(chip, {}).get("driven")), -1)

    return [(path, v.name, v.lsb, v.width, out, kind, selected, driven(path, out, kind),
             select.get(v.name, -1), net)
            for path, v, out, kind, selected, net in rows]  # fmt: skip


def boards_text(netlist: Netlist) -> str:
    """The rows of tables.h."""
    tables = []
    for name, module in boards(netlist).items():
        board = Board(netlist, module)
        registers: list[tuple] = []
        slices: list[tuple] = []
        for i, r in sorted(board.registers, key=lambda x: (x[0].path, x[1])):
            scope, _, last = r.rpartition(".")
            path = ".".join(x for x in (i.path, scope) if x)
            margin = RULES["counters"].get(f"{i.module.name}.{r}")
            kind = board.kind(i.path, r) if margin is None else "Kind::kCounter"
            var = i.module.vars[r]
            slices += [(len(registers), v.lsb, v.width, of_bits)
                       for v, of_bits in board.slices(i, var)
                       if of_bits != "Kind::kControl"]  # fmt: skip
            least = -1 if margin is None else margin
            registers.append((path, last, var.width, board.part(i.path), kind, least))
        ports, _ = board.ports()
        parts = [(part.path, part.module.name, port_rows(board, part, rows))
                 for part, rows in zip(board.parts, ports, strict=True)]  # fmt: skip
        decides = [(path, net.strip("!"), part, net[0] != "!") for path, net, part in board.decides]
        tables.append((name, registers, slices, parts, decides))
    return f"static const std::vector<BoardTable> kBoards = {cpp(tables)};\n"


def wires(folder: Path, netlist: Netlist, cards: int) -> None:
    found = Wires(netlist, cards)
    (folder / "wires.cpp").write_text(found.text())
    visible = [f'public_flat_{"rd" if module == "mmcs" else "rw"} -module "{module}" -var "{name}"'
               for module, name in sorted(found.glue_ports())]  # fmt: skip
    (folder / "glue.vlt").write_text("\n".join(["`verilator_config", *visible]) + "\n")
    for board in found.modules():
        (folder / f"{board.name}_shell.sv").write_text(shell(board))


def decoder_text(netlist: Netlist) -> str:
    """All outputs of a card's address decoder."""
    card, rule = next(iter(RULES["selected"].items()))  # all cards have the same decoder
    decoder = next(i for i in instances(netlist, boards(netlist)[card])
                   if i.path == rule["decoder"])  # fmt: skip
    outputs = (p for p in decoder.module.ports if p.direction == "OUTPUT")
    return "".join(f"MMCS_DECODED({p.name}, {p.width})\n" for p in outputs)


def checkers(folder: Path, netlist: Netlist) -> None:
    """The bus checkers, which are outside the boards."""
    known = {*RULES["boards"], "mmcs_cards"}
    found = [(name, netlist.modules[key].name) for name, key, _ in netlist.top.cells
             if netlist.modules[key].name not in known]  # fmt: skip
    lines = {f'forceable -module "{module}" -var "rst_ni"' for _, module in found}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "checkers.inc").write_text("".join(f'"{name}",\n' for name, _ in found))
    (folder / "checkers.vlt").write_text("\n".join(["`verilator_config", *sorted(lines)]) + "\n")
    write_ports(folder / "mmcs", netlist.top)


def main() -> int:
    what, folder, *rest = sys.argv[1:]
    out = Path(folder)
    clk_hz, *number = rest
    cards = int(number[0]) if number else len(RULES["selected"])  # one of each type
    if what == "checkers":
        checkers(out, read_design(out / "tree", cards, clk_hz, "rtl", "checkers"))
        return 0
    netlist = read_design(out / "tree", cards, clk_hz, "rtl")
    dissolve(netlist, netlist.top, "u_cards")
    if what == "wires":
        wires(out, netlist, cards)
    else:
        config(out, netlist)
        (out / "boards.inc").write_text(boards_text(netlist))
        (out / "decoder.inc").write_text(decoder_text(netlist))
        models = dict.fromkeys([*RULES["boards"], *CHIPS])
        (out / "models.inc").write_text("".join(f"MMCS_MODEL_OF({m})\n" for m in models))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
