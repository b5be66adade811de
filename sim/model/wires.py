# SPDX-License-Identifier: Apache-2.0
"""What rtl/mmcs.sv says between its boards, as C++: nets, the pins on them, and its own logic."""

from netlist import Module, Netlist, NetlistError, children, reads, writes

OPERATORS = {"AND": "&", "OR": "|", "XOR": "^", "ADD": "+", "SUB": "-", "MULS": "*", "MUL": "*",
             "EQ": "==", "NEQ": "!=", "LOGAND": "&&", "LOGOR": "||"}  # fmt: skip
COMPARE = {"GTS": ">", "GT": ">", "GTES": ">=", "GTE": ">=", "LTS": "<", "LT": "<"}


def constant(node: dict) -> int:
    width, _, value = node["name"].partition("'")
    if not value:
        return int(width)
    base = {"h": 16, "d": 10, "b": 2, "o": 8}[value.lstrip("s")[0]]
    return int(value.lstrip("s")[1:].replace("_", ""), base)


class Wires:
    def __init__(self, netlist: Netlist, cards: int):
        self.netlist, self.top, self.cards = netlist, netlist.top, cards
        self.nets = {v.name: n for n, v in enumerate(
            v for v in self.top.vars.values() if not v.is_param and v.width)}  # fmt: skip
        self.pins: list[str] = []
        self.logic: list[str] = []
        self.rows: list[str] = []

    # --- expressions ---

    def value(self, node: dict, local: set[str]) -> str:
        kind = node["type"]
        if kind == "CONST":
            return f"{constant(node)}ull"
        if kind == "VARREF":
            name = node["name"]
            if name in local:
                return f"{name}_"
            return f"w.get({self.nets[name]}, 0, {self.top.vars[name].width})"
        if kind == "SEL":
            inner = node["fromp"][0]
            lsb = self.value(node["lsbp"][0], local)
            if inner["type"] == "VARREF" and inner["name"] not in local:
                return f"w.get({self.nets[inner['name']]}, int({lsb}), {node['widthConst']})"
            mask = (1 << node["widthConst"]) - 1
            return f"(({self.value(inner, local)} >> {lsb}) & {mask}ull)"
        if kind in OPERATORS or kind in COMPARE:
            a, b = (self.value(node[k][0], local) for k in ("lhsp", "rhsp"))
            if kind in COMPARE:
                return f"(int64_t({a}) {COMPARE[kind]} int64_t({b}))"
            return f"({a} {OPERATORS[kind]} {b})"
        if kind == "NOT":
            inner = node["lhsp"][0]
            mask = (1 << self.netlist.width(inner["dtypep"])) - 1
            return f"(~{self.value(inner, local)} & {mask}ull)"
        if kind == "COND":
            c, a, b = (self.value(node[k][0], local) for k in ("condp", "thenp", "elsep"))
            return f"({c} ? {a} : {b})"
        if kind == "CONCAT":
            a, b = node["lhsp"][0], node["rhsp"][0]
            shift = self.netlist.width(b["dtypep"])
            return f"({self.value(a, local)} << {shift} | {self.value(b, local)})"
        if kind == "REDXOR":
            return f"(uint64_t(__builtin_parityll({self.value(node['lhsp'][0], local)})))"
        if kind in ("EXTEND", "EXTENDS"):
            return self.value(node["lhsp"][0], local)
        raise NetlistError(f"wires: mmcs.sv holds an expression {kind}")

    def statement(self, node: dict, local: set[str], out: list[str]) -> None:
        kind = node["type"]
        if kind in ("ASSIGN", "ASSIGNW"):
            target, value = node["lhsp"][0], self.value(node["rhsp"][0], local)
            if target["type"] != "VARREF":
                raise NetlistError(f"wires: mmcs.sv assigns to {target['type']}")
            if target["name"] in local:
                out.append(f"{target['name']}_ = {value};")
            else:
                name = target["name"]
                out.append(f"w.put({self.nets[name]}, 0, {self.top.vars[name].width}, {value});")
        elif kind == "VAR":
            local.add(node["name"])
            out.append(f"uint64_t {node['name']}_ = 0;")
        elif kind == "IF":
            out.append(f"if ({self.value(node['condp'][0], local)}) {{")
            for inner in node["thensp"]:
                self.statement(inner, local, out)
            out.append("} else {")
            for inner in node.get("elsesp", []):
                self.statement(inner, local, out)
            out.append("}")
        elif kind == "LOOP":
            out.append("for (;;) {")
            for inner in children(node):
                self.statement(inner, local, out)
            out.append("}")
        elif kind == "LOOPTEST":
            out.append(f"if (!{self.value(node['condp'][0], local)}) break;")
        elif kind in ("BEGIN", "ALWAYS"):
            for inner in children(node):
                self.statement(inner, local, out)
        else:
            raise NetlistError(f"wires: mmcs.sv holds a statement {kind}")

    # --- pins and logic ---

    def range(self, expr: dict):
        """(net, lsb) of an expression that is a wire, else None."""
        if expr["type"] == "VARREF":
            return self.nets[expr["name"]], 0
        if expr["type"] != "SEL" or expr["fromp"][0]["type"] != "VARREF":
            return None
        lsb = expr["lsbp"][0]
        return (
            (self.nets[expr["fromp"][0]["name"]], constant(lsb)) if lsb["type"] == "CONST" else None
        )

    def add_logic(self, body: list[str], sources: set[str], targets: set[str]) -> None:
        number = len(self.logic)
        text = "\n  ".join(body)
        self.logic.append(f"static void logic{number}(Wires &w) {{\n  {text}\n}}")
        names = ", ".join(str(self.nets[s]) for s in sorted(sources) if s in self.nets)
        to = ", ".join(str(self.nets[t]) for t in sorted(targets))
        self.rows.append(f"  {{logic{number}, {{{names}}}, {{{to}}}}},")

    def add_block(self, block: dict) -> None:
        targets = writes(block) & set(self.nets)
        if not targets or all(t.startswith("unused") for t in targets):
            return
        inside = {n["name"] for n in _vars(block)}
        sources = (reads(block) - inside) & set(self.nets)
        body: list[str] = []
        # A target that is built step by step is looked at only when it is whole.
        for target in sorted(targets):
            body.append(f"w.hold({self.nets[target]});")
        self.statement(block, set(), body)
        for target in sorted(targets):
            body.append(f"w.release({self.nets[target]});")
        self.add_logic(body, sources - targets, targets)

    def add_cell(self, number: int, path: str, module: Module, pins: dict) -> None:
        for port, expr in pins.items():
            if expr is None:
                continue
            var = module.vars[port]
            place = self.range(expr)
            if place is None:
                if var.direction != "INPUT":
                    raise NetlistError(f"wires: {path}.{port} drives no plain net")
                name = f"{path}.{port}"
                self.nets[name] = len(self.nets)
                place = (self.nets[name], 0)
                self.extra[name] = var.width
                value = self.value(expr, set())
                self.add_logic([f"w.put({place[0]}, 0, {var.width}, {value});"],
                               reads(expr), {name})  # fmt: skip
            self.pins.append(f'  {{{number}, "{port}", {place[0]}, {place[1]}, {var.width}}},')

    def text(self) -> str:
        self.extra: dict[str, int] = {}
        cells = [(path, self.netlist.modules[key], pins) for path, key, pins in self.top.cells]
        for number, (path, module, pins) in enumerate(cells):
            self.add_cell(number, path, module, pins)
        for block in self.top.blocks:
            if not any(a.clocked for a in self.top.assigns):
                self.add_block(block)
        if any(a.clocked for a in self.top.assigns):
            raise NetlistError("wires: mmcs.sv holds registers")
        widths = {v.name: v.width for v in self.top.vars.values()} | self.extra
        inputs = {v.name for v in self.top.ports if v.direction == "INPUT"}
        out = ["// Made by sim/model/generate.py from rtl/mmcs.sv.", '#include "wires.h"', "",
               "namespace mmcs {", *self.logic, "const WireTable kWires = {", f"  {self.cards},",
               "  {  // nets"]  # fmt: skip
        out += [f'  {{"{n}", {widths[n]}, {int(n in inputs)}}},' for n in self.nets]
        out += ["  },", "  {  // boards"]
        out += [f'  {{"{path}", "{module.name}"}},' for path, module, _ in cells]
        out += ["  },", "  {  // pins", *self.pins, "  },", "  {  // logic", *self.rows, "  },",
                "};", "}  // namespace mmcs", ""]  # fmt: skip
        return "\n".join(out)


def _vars(node: dict):
    from netlist import walk

    return (n for n in walk(node) if n.get("type") == "VAR")


def wires_text(netlist: Netlist, cards: int) -> str:
    return Wires(netlist, cards).text()
