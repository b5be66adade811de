# SPDX-License-Identifier: Apache-2.0
"""How rtl/mmcs.sv wires its boards: nets, the pins on them, and the nets of its own logic.

That logic is Verilated with empty boards around it (glue.cpp).
"""

import re

from netlist import Module, Netlist, NetlistError, cpp, reads, walk, writes
from parts import Board


class Wires:
    """The nets of a machine of so many cards, by number; the boards; the rows of wires.cpp."""

    def __init__(self, netlist: Netlist, cards: int):
        self.top, self.cards = netlist.top, cards
        self.nets = {v.name: n for n, v in enumerate(
            v for v in self.top.vars.values() if not v.is_param and v.width)}  # fmt: skip
        self.boards = [(path, netlist.modules[key], pins) for path, key, pins in self.top.cells]
        if self.top.registers:
            raise NetlistError("wires: mmcs.sv holds registers")
        logic = (self._logic(block) for block in self.top.blocks)
        self.logic = [(sources, targets) for sources, targets in logic
                      if not all(t.startswith("unused") for t in targets)]  # fmt: skip
        self.pins = [(number, port, *self._place(path, port, expr), module.vars[port])
                     for number, (path, module, pins) in enumerate(self.boards)
                     for port, expr in pins.items()
                     if expr is not None and port != "clk_i"]  # fmt: skip
        self.inside = {m.name: Board(netlist, m).ports()[1] for m in self.modules()}

    def _logic(self, block: dict) -> tuple[set[str], set[str]]:
        """Nets that an always_comb or assign reads, and those that it drives."""
        targets = writes(block) & set(self.nets)
        inside = {n["name"] for n in walk(block) if n.get("type") == "VAR"}
        return (reads(block) - inside) & set(self.nets) - targets, targets

    def _place(self, path: str, port: str, expr: dict) -> tuple[str, int]:
        """The net at a pin, and its lowest bit there."""
        if expr["type"] == "VARREF":
            return expr["name"], 0
        if expr["type"] == "SEL" and expr["fromp"][0]["type"] == "VARREF":
            lsb = expr["lsbp"][0]
            if lsb["type"] == "CONST":
                return expr["fromp"][0]["name"], int(re.sub(r".*'s?h", "", lsb["name"]), 16)
        raise NetlistError(f"wires: {path}.{port} is on no plain net")

    def glue_ports(self) -> set[tuple[str, str]]:
        """What must be visible of the logic: nets of mmcs that it drives, outputs that it reads."""
        read = set().union(*(sources for sources, _ in self.logic))
        driven = set().union(*(targets for _, targets in self.logic))
        return {("mmcs", net) for net in driven} | {
            (self.boards[board][1].name, port) for board, port, net, _, var in self.pins
            if net in read and var.direction == "OUTPUT"
        }  # fmt: skip

    def modules(self) -> list[Module]:
        """The boards' modules, one of a name."""
        return [*{module.name: module for _, module, _ in self.boards}.values()]

    def text(self) -> str:
        widths = {v.name: v.width for v in self.top.vars.values()}
        numbers = lambda names: [self.nets[name] for name in sorted(names)]  # noqa: E731
        rows = (
            self.cards,
            [(name, widths[name]) for name in self.nets],
            [(path, module.name) for path, module, _ in self.boards],
            [
                (
                    board,
                    port,
                    self.inside[self.boards[board][1].name][port],
                    self.nets[net],
                    lsb,
                    v.width,
                    v.direction == "OUTPUT",
                )
                for board, port, net, lsb, v in self.pins
            ],
            [(numbers(sources), numbers(targets)) for sources, targets in self.logic],
        )
        return f'#include "wires.h"\n\nconst mmcs::WireTable mmcs::kWires = {cpp(rows)};\n'
