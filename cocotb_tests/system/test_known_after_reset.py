# SPDX-License-Identifier: Apache-2.0
"""No flip-flop stays unknown in a bench whose pins stand still from time 0.

Each top runs in a plain Verilog bench on Icarus (four states, no cocotb). Every input but clock and
reset has its idle level by declaration and so never has an edge. Ten clocks after the reset every
flip-flop must be known, but those that the report leaves without a reset.
"""

import re
import shutil
import subprocess

import pytest

from mmcs import ROOT
from tools.sources import reached, sources

PORT = re.compile(
    r"^ +(input|output|inout) +(?:wire +)?(?:logic +)?((?:\[[^\]]*\] *)*)(\w+),? *(?://.*)?$", re.M
)
PARAMETER = re.compile(r"parameter ([^=]*?)(\w+) *= *(.*?),? *(?://.*)?$", re.M)
HIGH = re.compile(r"_n$|_ni$|closed|cable_ok|power|enable|_en_i$")  # idle inputs that are 1
CLOCK, RESET = ("clk_i", "clk", "pclk"), ("rst_ni", "rst_n", "presetn")
TOPS = ["mmcs", "mark1", "adaptor_vme", "adaptor_axil", "adaptor_wb", "adaptor_apb", "vme_adaptor",
        "isa_mark1"]  # fmt: skip


BENCH = """`timescale 1ns/1ps
module bench;
{lines}
logic {clock} = 0, {reset} = {held};
always #5 {clock} = ~{clock};
{top} u_top (.*);
initial begin
  $dumpfile("idle.vcd");
  $dumpvars(0, u_top);
  #3 {reset} = 0;
  #100 {reset} = 1;
  #100 $dumpall;
  $finish;
end
endmodule
"""


def bench(top: str, text: str, held: int) -> str:
    """A module that drives the idle levels, and dumps the nets. held: the reset at time 0."""
    header = text[text.index(f"module {top}") : text.index(");\n")]
    lines = [f"localparam {kind}{name} = {v};" for kind, name, v in PARAMETER.findall(header)]
    ports = PORT.findall(header)
    for way, shape, name in ports:
        if way != "input":
            lines.append(f"wire {shape}{name};")
        elif name.lower() not in CLOCK + RESET:
            lines.append(f"logic {shape}{name} = {'~0' if HIGH.search(name) else '0'};")
    clock, reset = (next(n for *_, n in ports if n.lower() in known) for known in (CLOCK, RESET))
    return BENCH.format(lines="\n".join(lines), clock=clock, reset=reset, held=held, top=top)


def unknown(vcd: str) -> set[str]:
    """Flip-flops (nets named ..._q) that hold X at the end of a dump, by instance path."""
    names, path, last = {}, [], {}
    for line in vcd.splitlines():
        words = line.split()
        if line.startswith("$scope"):
            path.append(words[2])
        elif line.startswith("$upscope"):
            path.pop()
        elif line.startswith("$var") and words[4].endswith("_q"):
            names.setdefault(words[3], ".".join([*path[2:], words[4]]))
        elif line[:1] in "01xz":
            last[line[1:]] = line[0]
        elif line.startswith("b"):
            last[words[1]] = words[0]
    return {name for code, name in names.items() if "x" in last.get(code, "x")}


@pytest.mark.req("VME-3", "INT-2")
@pytest.mark.parametrize("held", [0, 1])
@pytest.mark.parametrize("top", TOPS)
def test_every_flip_flop_is_known_after_reset(top, held, tmp_path):
    """With the reset low from time 0, and with its fall."""
    if not shutil.which("iverilog"):
        pytest.skip("iverilog is missing; install it with: sudo apt-get install iverilog")
    files = [*sources("rtl"), *(ROOT / "fpga").rglob("*.sv")]
    made = reached([top], files)
    text = next(f for f in made if f.stem == top).read_text()
    (tmp_path / "bench.sv").write_text(bench(top, text, held))
    subprocess.run(["iverilog", "-g2012", f"-I{ROOT / 'rtl'}", "-s", "bench", "-o", "idle",
                    *made, "bench.sv"], cwd=tmp_path, check=True)  # fmt: skip
    subprocess.run(["vvp", "-n", "idle"], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    assert unknown((tmp_path / "idle.vcd").read_text()) == set()
