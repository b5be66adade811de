# SPDX-License-Identifier: Apache-2.0
"""Verilates cards of one's own into one model: `card.py DIR CLK`, DIR with card0.sv, card1.sv, ...
and slots.json: the machine's number of slots, and of each file the first slot or null.

Each module that no other instantiates is a card on the PC-bus expansion; one with ports for joints
stands in slots of Mark I cards. Makes in DIR a module that joins them (mmcs_card.sv), its model
(v/), registers.cpp and the ports for fast.cpp. A design that cannot be a card ends in one line,
`FILE:LINE: what is wrong`, and status 2.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "model"))

from netlist import Module, Netlist, children, instances, walk, writes  # noqa: E402

# ports of a card: their widths, and the net of rtl/mmcs.sv that each is on
NEEDED = {
    "clk_i": (1, "clk_i"), "rst_ni": (1, "rst_ni"), "pc_a_i": (16, "pcx_a_o"),
    "pc_aen_i": (1, "pcx_aen_o"), "pc_ior_ni": (1, "pcx_ior_no"), "pc_iow_ni": (1, "pcx_iow_no"),
    "pc_d_i": (8, "pcx_d_o"), "pc_d_o": (8, "pcx_d_i"), "pc_d_oe_o": (1, "pcx_d_oe_i"),
}  # fmt: skip
OPTIONAL = {
    "pc_clk_en_i": (1, "pcx_clk_en_o"), "pc_reset_drv_i": (1, "pcx_reset_drv_o"),
    "pc_drq_i": (3, "pcx_drq_o"), "pc_wait_o": (1, "pcx_wait_i"), "pc_irq_o": (5, "pcx_irq_i"),
}  # fmt: skip
KNOWN = NEEDED | OPTIONAL
# ports of a card with motors: their widths per joint. They are at the nets of the same names.
MOTOR = {"enc_a_i": 1, "enc_b_i": 1, "enc_i_i": 1, "drive_v_o": 16}
JOINTS = MOTOR | {"axis_enable_i": 1, "adc_v_i": 16}
OWN = {"clash_o": (1, "clash_o"), "slots_o": (16, "slots_o")}
PORTS = KNOWN | {name: (0, name) for name in JOINTS} | OWN  # of all cards together
# How the cards share an output: undriven data lines read 1, two drivers give their AND.
JOINED = {
    "pc_d_o": ("& ", "'1", "({0}_pc_d_oe_o ? {0}_pc_d_o : 8'hFF)"),
    "pc_d_oe_o": ("| ", "'0", "{0}_pc_d_oe_o"),
    "pc_wait_o": ("| ", "'0", "{0}_pc_wait_o"),
    "pc_irq_o": ("| ", "'0", "{0}_pc_irq_o"),
}
# What Verilator's warnings of these names say is wrong in a card.
ERRORS = ("LATCH", "MULTIDRIVEN", "UNOPTFLAT", "COMBDLY", "BLKANDNBLK", "STMTDLY", "PINMISSING")
# System functions that neither leave the model nor make it differ from run to run. A card may come
# with the record of somebody else's run.
ALLOWED = re.compile(
    "bits|clog2|(un)?signed|size|high|low|left|right|dimensions|countones|onehot0?|isunknown|cast|"
    "error|fatal|warning|info|display"
)
ESCAPES = re.compile(r"\$(\w+)|`(include|systemc\w*|verilator\w*)|\"(DPI)[^\"]*\"")


def fail(where: str, text: str) -> None:
    print(f"{where}: {text}")
    raise SystemExit(2)


def verilator(folder: Path, *args: str) -> str:
    """What it prints. Ends at the first error, with its place."""
    done = subprocess.run(
        ["verilator", "--no-timing", "-Wno-fatal", "--quiet", "--x-assign", "0", "--x-initial", "0",
         *args], cwd=folder, capture_output=True, text=True, check=False)  # fmt: skip
    if done.returncode:
        found = re.search(r"^%Error[^:]*: ([^:\s]+:\d+):\d+: (.*)", done.stderr, re.M)
        if not found:
            fail("verilator", (done.stderr.strip().splitlines() or ["no output"])[0])
        fail(*found.groups())
    return done.stdout


def check_text(folder: Path, files: list[str]) -> None:
    """No text of a card reads a file or calls what is outside, before or behind its macros."""
    lines = [(name, n, line) for name in files
             for n, line in enumerate((folder / name).read_text().splitlines(), 1)
             if "`include" in line]  # fmt: skip
    name, number = "", 0
    for line in [] if lines else verilator(folder, "-E", *files).splitlines():
        number += 1
        if found := re.match(r'`line (\d+) "([^"]*)"', line):
            name, number = found[2], int(found[1]) - 1
        else:
            lines.append((name, number, line))
    for name, number, line in lines:
        for function, directive, foreign in ESCAPES.findall(line):
            if not ALLOWED.fullmatch(function):
                what = f"${function}" if function else f"`{directive}" if directive else foreign
                fail(f"{name}:{number}", f"{what} is not for a card: it stands for itself")


class Design:
    """The cards as Verilator reads them."""

    def __init__(self, folder: Path, files: list[str]):
        verilator(folder, "--json-only", "-Wno-lint", "-Werror-STMTDLY", "--prefix", "Vtree",
                  "-Mdir", "tree", *files)  # fmt: skip
        path = folder / "tree" / "Vtree.tree.json"
        self.netlist = Netlist(path)
        names = json.loads(path.with_name("Vtree.tree.meta.json").read_text())["files"]
        self._files = {letter: about["filename"] for letter, about in names.items()}
        nodes = {m["addr"]: m for m in json.loads(path.read_text())["modulesp"]}
        self._nodes = nodes
        below = {key for m in self.netlist.modules.values() for _, key, _ in m.cells}
        self.cards = [m for key, m in self.netlist.modules.items() if key not in below]

    def place(self, node: dict) -> str:
        letter, line, *_ = re.split("[,:]", node["loc"])
        return f"{self._files[letter]}:{line}"

    def at(self, module: Module) -> str:
        return self.place(self._nodes[module.key])

    def check(self) -> None:
        for card in self.cards:
            self._check_ports(card)
            for path, module, clocks in clocked(self.netlist, card):
                for block in module.blocks:
                    self._check_clock(block, clocks, f"{card.name}{path}")
        for module in self.netlist.modules.values():
            self._check_drivers(module)
            for node in walk(self._nodes[module.key]):
                if node.get("type") in ("FINISH", "STOP"):
                    fail(self.place(node), "ends the simulator, which goes on without a card")

    def _check_ports(self, card: Module) -> None:
        at, ports = self.at(card), {p.name: p for p in card.ports}
        for name in [*NEEDED, *(MOTOR if ports.keys() & JOINTS else ())]:
            if name not in ports:
                fail(at, f"card {card.name} has no port {name}")
        for name, port in ports.items():
            if name not in KNOWN | JOINTS:
                fail(at, f"card {card.name} has a port {name}, which no slot has")
            width = KNOWN[name][0] if name in KNOWN else JOINTS[name] * joints(card)
            direction = "OUTPUT" if name.endswith("o") else "INPUT"
            if (port.width, port.direction) != (width, direction):
                allowed = f"must be an {direction.lower()} of {width} bit{'s' * (width > 1)}"
                fail(at, f"port {name} of card {card.name} {allowed}")

    def seats(self, number: int, given: list[int | None]) -> dict[str, range]:
        """The slots of each card with joints, two in a slot: from its file's on, or the last that
        are free."""
        free, found = set(range(number)), {}
        asked = [(given[int(self.at(card)[4:].partition(".")[0])], card) for card in self.cards]
        for slot, card in sorted(asked[::-1], key=lambda one: one[0] is None):
            if not (size := (joints(card) + 1) // 2):
                if slot is not None:
                    fail(self.at(card), f"card {card.name} has no joints, so it takes no slot")
                continue
            seats = (range(n, n + size) for n in (range(number)[::-1] if slot is None else [slot]))
            if not (seat := next(filter(free.issuperset, seats), None)):
                where = "no slot is left" if slot is None else f"slot {slot} is not free"
                left = ", ".join(map(str, sorted(free))) or "none"
                fail(self.at(card), f"{where} for card {card.name} and its joints, of which a slot "
                                    f"has two: {joints(card)}; free slots: {left}")  # fmt: skip
            found[card.name] = seat
            free -= {*seat}
        return found

    def _check_clock(self, block: dict, clocks: set[str], where: str) -> None:
        if block.get("keyword") == "always_latch":
            fail(self.place(block), "a latch: a card has flip-flops only")
        for tree in (c for c in children(block) if c.get("type") == "SENTREE"):
            edges = [(i["edgeType"], i["sensp"][0].get("name")) for i in tree["sensesp"]]
            if not any(edge == "POS" and name in clocks for edge, name in edges):
                name = edges[0][1] or "this"
                fail(self.place(tree), f"{name} is a second clock; {where} has clk_i, rising, only")

    def _check_drivers(self, module: Module) -> None:
        """A variable that one statement drives whole, and another, too. A flip-flop may have its
        first value from a statement of its own."""
        first: dict[str, dict] = {}
        whole: set[str] = set()
        for block in sorted(module.blocks, key=lambda b: not has_edges(b)):
            if block["type"] == "INITIAL" and any(map(has_edges, map(first.get, writes(block)))):
                continue
            for name in writes(block) & set(module.vars):
                other = first.setdefault(name, block)
                if other is not block and name in whole | wholly(block):
                    where = self.place(other)
                    fail(self.place(block), f"{name} has several drivers; another is at {where}")
            whole |= wholly(block)


def joints(card: Module) -> int:
    return card.vars["enc_a_i"].width if "enc_a_i" in card.vars else 0


def has_edges(block: dict | None) -> bool:
    return any(c.get("type") == "SENTREE" for c in children(block or {}))


def wholly(block: dict) -> set[str]:
    """Variables that a statement assigns as a whole."""
    kinds = ("ASSIGN", "ASSIGNW", "ASSIGNDLY")
    sides = (n["lhsp"][0] for n in walk(block) if n.get("type") in kinds)
    return {side["name"] for side in sides if side["type"] == "VARREF"}


def clocked(
    netlist: Netlist, module: Module, path: str = "", clocks: frozenset = frozenset({"clk_i"})
):
    """Path, module and the names of the clock in it, of this instance and all below."""
    yield path, module, clocks
    for name, key, pins in module.cells:
        inner = {port for port, expr in pins.items()
                 if expr and expr["type"] == "VARREF" and expr["name"] in clocks}  # fmt: skip
        yield from clocked(netlist, netlist.modules[key], f"{path}.{name}", frozenset(inner))


def joined(cards: list[Module], seats: dict[str, range], number: int, clk_hz: str) -> str:
    """The module that has all cards on one bus; its ports are named by nets of rtl/mmcs.sv. Its own
    register is there so that every model has a clock and a reset. clash_o: two cards, or one and a
    Mark I, answer a read; slots_o: the slots of cards with joints, by bit."""
    ports = [f"  {'output' if name.endswith('o') else 'input'} logic "
             f"[{(width or 2 * number * JOINTS[name]) - 1}:0] {net}"
             for name, (width, net) in PORTS.items()]  # fmt: skip
    lines = ["module mmcs_card (", ",\n".join(ports), ");",
             "  logic reset_q /*verilator public_flat_rd*/;",
             "  always_ff @(posedge clk_i or negedge rst_ni) reset_q <= rst_ni;"]  # fmt: skip
    terms: dict[str, list[str]] = {name: [] for name in JOINED}
    for card in cards:
        pins = []
        for port in card.ports:
            wire = KNOWN.get(port.name, (0, port.name))[1]
            if port.name in JOINTS:
                wire += f"[{2 * JOINTS[port.name] * seats[card.name][0]}+:{port.width}]"
            elif port.name in JOINED:
                wire = f"{card.name}_{port.name}"
                lines.append(f"  logic [{port.width - 1}:0] {wire};")
                terms[port.name].append(JOINED[port.name][2].format(card.name))
            pins.append(f".{port.name}({wire})")
        values = {"ClkHz": clk_hz, "Slot": seats.get(card.name, [None])[0]}
        given = [f".{n}({v})" for n, v in values.items() if v is not None and n in card.vars]
        lines.append(f"  {card.name} #({', '.join(given)}) {card.name} ({', '.join(pins)});")
    for name, (how, none, _) in JOINED.items():
        lines.append(f"  assign {KNOWN[name][1]} = {how.join(terms[name]) or none};")
    own = sum(1 << n for seat in seats.values() for n in seat)
    mark1 = f"1'(16'd{(1 << number) - 1 & ~own} >> pcx_a_o[13:10]) & pcx_a_o[9:5] == 5'h18"
    lines += [f"  assign slots_o = 16'd{own};", "  assign clash_o = !pcx_ior_no && "
              f"!$onehot0({{{', '.join([mark1, *terms['pc_d_oe_o']])}}});"]  # fmt: skip
    return "\n".join([*lines, "endmodule", ""])


def registers(netlist: Netlist, cards: list[Module]) -> dict[tuple[str, str, str], int]:
    """Path, name and module of whatever a clock writes; 0: a variable of a loop, perhaps."""
    found = {}
    for card in cards:
        for i in instances(netlist, card, card.name):
            clocked = filter(has_edges, i.module.blocks)
            for name in sorted(set().union(*map(writes, clocked)) & set(i.module.vars)):
                scope, _, last = name.rpartition(".")
                key = (".".join(x for x in (i.path, scope) if x), last, i.module.name)
                found[key] = int(name in i.module.registers)
    return found


def main() -> int:
    folder, clk_hz = Path(sys.argv[1]), sys.argv[2]
    number, slots = json.loads((folder / "slots.json").read_text())
    files = sorted((f.name for f in folder.glob("card*.sv")), key=lambda n: int(n[4:-3]))
    check_text(folder, files)
    design = Design(folder, files)
    design.check()
    found = registers(design.netlist, design.cards)
    # rw: not an alias of a wire that its module's port is connected to
    visible = {f'public_flat_rw -module "{module}" -var "{name}"' for _, name, module in found}
    texts = {
        "mmcs_card.sv": joined(design.cards, design.seats(number, slots), number, clk_hz),
        "registers.vlt": "\n".join(["`verilator_config", *sorted(visible), ""]),
        "registers.cpp": "const mmcs::CardRow mmcs::kCardRows[] = {"
        + "".join(f'{{"{path}", "{name}", {must}}},\n' for (path, name, _), must in found.items())
        + '{"", "reset_q", 1}, {}};\n',
        "card.ports": "".join(f"MMCS_PORT({net})\n" for _, net in PORTS.values()),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    verilator(folder, "--cc", "-O3", "--no-assert", "-Wall", "-Wno-style",
              *(f"-Werror-{name}" for name in ERRORS), "--prefix", "Vcard",
              "--top-module", "mmcs_card", "-Mdir", "v", "registers.vlt", *files,
              "mmcs_card.sv")  # fmt: skip
    aliases = set().union(*(c for m in design.cards for _, _, c in clocked(design.netlist, m)))
    made = "".join(f.read_text() for f in folder.glob("v/V*__Slow.cpp"))
    for trigger in re.findall(r"is active: @\(\w+ ([^)]+)\)", made):
        if trigger.rpartition(".")[2] in aliases - {"clk_i"}:
            fail(files[0] + ":1", f"{trigger} is not taken for clk_i: connect it directly")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
