# SPDX-License-Identifier: Apache-2.0
"""The same bus and pin traffic on other simulators: recorded once, replayed clock by clock.

A closed loop of three cards is run on the tracing build; every input of module `mmcs` and every
output is taken from the trace. The inputs become a file of changes, which a testbench without any
other business plays into the RTL: on Icarus Verilog, and on Verilator as its manual begins (default
flags, both clock edges evaluated). A digest of all output changes shows that it was the same run.
"""

from __future__ import annotations

import re
import resource
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from mmcs import BUILD, ROOT, Sim, ensure_library
from studies.bench.machines import LEAST_CPU_S, Machine, start

sys.path.insert(0, str(ROOT / "tools"))
from sources import sources  # noqa: E402

CARDS, LOAD = 3, "typical"
RECORD_S = 0.012  # of which 3.4 ms until the motion starts
FOLDER = BUILD / "bench" / "replay"
MACHINE = "TOP.mmcs."
OUTPUTS = ("vme_d_o", "vme_d_oe_o", "vme_dtack_no", "vme_iackout_no", "vme_irq_no",
           "brake_release_o", "panic_o", "sclock_o", "led_irq_o", "drive_v_o",
           "card_leds_o")  # fmt: skip
IGNORED = ("clk_i", "rst_ni")
MASK = (1 << 64) - 1
MOST_RUNS = 5  # of one simulator in a measurement
PS_PER_CLOCK = 125_000
RESET_CLKS = 64  # before the first clock of a run, sim/model/model.cpp


def ports() -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """(name, width) of the inputs played back and of the outputs compared, from rtl/mmcs.sv."""
    text = (ROOT / "rtl" / "mmcs.sv").read_text()
    head = text[text.index(") (") : text.index(");", text.index(") ("))]
    found = re.findall(
        r"^  (input|output)\s+(?:wire\s+)?logic\s*(?:\[([^\]]*)\])?\s*(\w+)", head, re.M
    )
    ins, outs = [], []
    for way, span, name in found:
        width = 1
        if span:
            high, low = (_bound(part) for part in span.split(":"))
            width = high - low + 1
        if way == "input" and name not in IGNORED:
            ins.append((name, width))
        elif name in OUTPUTS:
            outs.append((name, width))
    return ins, outs


def _bound(text: str) -> int:
    value = 0
    for sign, term in re.findall(r"([+-]?)\s*([\w*]+)", text.replace("NumCards", str(CARDS))):
        factors = [int(f) for f in term.split("*")]
        product = factors[0] * (factors[1] if len(factors) > 1 else 1)
        value += -product if sign == "-" else product
    return value


# --- recording ---------------------------------------------------------------------------------


@dataclass
class Traffic:
    clocks: int  # of the recorded run
    changes: int  # of inputs
    events: int  # changes of outputs
    digest: int  # of them
    bus_cycles: int


def record() -> Traffic:
    """Traces the run, and writes changes.hex: clock and all inputs, at every change of one."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    setup = Machine(CARDS, False).setup(LOAD)
    trace = FOLDER / "traffic.fst"
    with Sim(ensure_library(CARDS, "trace"), setup.config(), setup.motors(), setup.links()) as sim:
        sim.trace(trace)
        start(sim, setup)
        sim.run(RECORD_S)
        clocks, bus_cycles = sim.clock, sim.stats()["bus_cycles"]
    waves = _waves(trace)
    ins, outs = ports()
    digits = -(-sum(width for _, width in ins) // 4)
    changes = _merge(ins, waves, clocks)
    lines = [f"{clock:08x}{value:0{digits}x}" for clock, value in changes]
    (FOLDER / "changes.hex").write_text("\n".join(lines) + "\n")
    digest, events = 0, _merge(outs, waves, clocks)
    words = _words(outs)
    for clock, value in events:
        digest = fold(digest, clock, value, words)
    return Traffic(clocks, len(changes), len(events), digest, int(bus_cycles))


def fold(digest: int, clock: int, value: int, words: int) -> int:
    """A digest with one more change of outputs; the testbenches do the same."""
    for n in range(words):
        digest = (digest << 5 & MASK | digest >> 59) ^ (value >> 64 * n & MASK)
    return (digest << 5 & MASK | digest >> 59) ^ clock


def _words(signals: list[tuple[str, int]]) -> int:
    return -(-sum(width for _, width in signals) // 64)


def _waves(trace: Path) -> dict[str, list[tuple[int, int]]]:
    """Per port, (clock after which it has the value, value)."""
    import pywellen

    wave = pywellen.Waveform(str(trace))
    names, wanted, out = {}, [], {}
    for var in wave.all_vars():
        name = var.full_name.removeprefix(MACHINE).partition("[")[0].strip()
        if var.full_name.startswith(MACHINE) and "." not in name and name not in out:
            names.setdefault(str(var.signal_id), []).append(name)
            out[name] = []
            wanted.append(var)

    def take(time: int, signal, raw) -> None:
        for name in names.get(str(signal), ()):
            out[name].append((time // PS_PER_CLOCK, _number(raw)))

    wave.stream_changes(take, wanted)
    return out


def _number(raw) -> int:
    return raw if isinstance(raw, int) else int(str(raw).replace("x", "0"), 2)


def _merge(signals, waves, clocks: int) -> list[tuple[int, int]]:
    """The signals as one vector, the first in the lowest bits: (clock, value) at each change."""
    changes: dict[int, dict[int, int]] = {}
    low, places = 0, []
    for place, (name, width) in enumerate(signals):
        places.append((low, width))
        low += width
        for clock, value in waves[name]:
            changes.setdefault(clock, {})[place] = value
    out, vector = [], 0
    for clock in sorted(changes):
        before = vector
        for place, value in changes[clock].items():
            low, width = places[place]
            vector = vector & ~((1 << width) - 1 << low) | value << low
        if (vector != before or not out) and clock < RESET_CLKS + clocks:
            out.append((clock, vector))
    return out


# --- testbenches -------------------------------------------------------------------------------

VERILOG = """// SPDX-License-Identifier: Apache-2.0
// Made by studies/bench/replay.py: plays recorded inputs into `mmcs`.
`timescale 1ns/1ps
module bench_replay;
  localparam Inputs = %(inputs)d, Entry = %(entry)d, Outputs = %(outputs)d, Changes = %(changes)d;
  reg clk = 1'b0, rst_n = 1'b0;
  reg [Inputs-1:0] in;
  reg [Entry-1:0] change [0:Changes-1];
  reg [31:0] n = 0, next = 0, at = 0, clocks, events = 0;
  wire [Outputs-1:0] out;
  reg [Outputs-1:0] last;
  reg [63:0] digest = 0;
  wire [%(padded)d-1:0] padded = out;
  wire [31:0] clock = n - 1;
  integer word;

  mmcs #(.NumCards(%(cards)d)) u_mmcs (
    .clk_i(clk), .rst_ni(rst_n),
%(pins)s
  );

  initial begin
    if (!$value$plusargs("clocks=%%d", clocks)) clocks = 0;
    $readmemh("changes.hex", change);
    in = change[0][Inputs-1:0];
    in[%(sysreset)d] = 1'b0;
    at = change[1][Entry-1-:32];
    next = 1;
  end

  always #62.5 clk = !clk;

  always @(posedge clk) begin
    if (n == 7) rst_n <= 1'b1;
    if (n == 32) in[%(sysreset)d] <= 1'b1;
    if (n == at && next < Changes) begin
      in   <= change[next][Inputs-1:0];
      next <= next + 1;
      at   <= change[next+1][Entry-1-:32];
    end
    if (n > %(reset)d && out !== last) begin  // what the clock before this one left
      last <= out;
      for (word = 0; word < %(words)d; word = word + 1)
        digest = {digest[58:0], digest[63:59]} ^ padded[64*word+:64];
      digest = {digest[58:0], digest[63:59]} ^ {32'd0, clock};
      events <= events + 1;
    end
    n <= n + 1;
    if (n == clocks) begin
      $display("digest %%h events %%0d", digest, events);
      $finish;
    end
  end
endmodule
"""

CPP = """// SPDX-License-Identifier: Apache-2.0
// Made by studies/bench/replay.py: the same in C++, as Verilator's manual begins: eval() on
// both edges.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>
#include "Vmmcs.h"

struct Change { uint32_t clock; uint32_t in[%(in_words)d]; };

static uint32_t digit(char c) { return static_cast<uint32_t>(c <= '9' ? c - '0' : c - 'a' + 10); }

static Change parse(const char *line) {
  Change c{};
  const int digits = %(digits)d;
  for (int i = 0; i < 8; ++i) c.clock = c.clock << 4 | digit(line[i]);
  for (int i = 0; i < digits; ++i) {
    const int bit = 4 * (digits - 1 - i);
    c.in[bit / 32] |= digit(line[8 + i]) << bit %% 32;
  }
  return c;
}

static uint32_t bits(const uint32_t *in, int low, int width) {  // width <= 32
  uint64_t v = in[low / 32];
  if (low %% 32 + width > 32) v |= static_cast<uint64_t>(in[low / 32 + 1]) << 32;
  return static_cast<uint32_t>(v >> low %% 32 & (width == 32 ? ~0u : (1u << width) - 1));
}

int main(int argc, char **argv) {
  std::vector<Change> changes;
  char line[512];
  std::FILE *file = std::fopen("changes.hex", "r");
  while (std::fgets(line, sizeof line, file)) changes.push_back(parse(line));
  std::fclose(file);
  const uint32_t clocks = std::strtoul(argv[1], nullptr, 10);
  Vmmcs top;
  auto drive = [&](const uint32_t *in) {
%(drive)s
  };
  top.clk_i = 0;
  top.rst_ni = 0;
  drive(changes[0].in);
  top.vme_sysreset_ni = 0;
  top.eval();
  uint64_t out[%(words)d], last[%(words)d], digest = 0;
  uint32_t events = 0;
  size_t next = 1;
  for (uint32_t n = 0; n < clocks; ++n) {
    if (n == 8) top.rst_ni = 1;
    top.clk_i = 1;
    top.eval();
    if (n == 32) top.vme_sysreset_ni = 1;
    if (next < changes.size() && changes[next].clock == n) drive(changes[next++].in);
    top.clk_i = 0;
    top.eval();
    if (n >= %(reset)d) {
%(collect)s
      bool differs = events == 0;
      for (int w = 0; w < %(words)d; ++w) differs |= out[w] != last[w];
      if (differs) {
        for (int w = 0; w < %(words)d; ++w) {
          digest = (digest << 5 | digest >> 59) ^ (last[w] = out[w]);
        }
        digest = (digest << 5 | digest >> 59) ^ n;
        ++events;
      }
    }
  }
  std::printf("digest %%016llx events %%u\\n", static_cast<unsigned long long>(digest), events);
}
"""


def _write(name: str, text: str) -> Path:
    path = FOLDER / name
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    return path


def _fill(traffic: Traffic) -> dict:
    """What the two testbenches need to know of the ports."""
    ins, outs = ports()
    inputs, outputs, words = (sum(w for _, w in ins), sum(w for _, w in outs), _words(outs))
    pins, drive, collect, low = [], [], ["for (auto &w : out) w = 0;"], 0
    fill = {}
    for name, width in ins:
        pins.append(f".{name}(in[{low}+:{width}]),")
        if name == "vme_sysreset_ni":
            fill["sysreset"] = low
        if width <= 32:
            drive.append(f"top.{name} = bits(in, {low}, {width});")
        else:
            for n in range(-(-width // 32)):
                part = min(32, width - 32 * n)
                drive.append(f"{_word(name, width, n)} bits(in, {low + 32 * n}, {part});")
        low += width
    low = 0
    for name, width in outs:
        pins.append(f".{name}(out[{low}+:{width}]),")
        for n in range(-(-width // 32)):
            value = (
                f"static_cast<uint32_t>(top.{name}{f'[{n}]' if width > 64 else f' >> {32 * n}'})"
            )
            at = low + 32 * n
            collect.append(f"out[{at // 64}] |= uint64_t{{{value}}} << {at % 64};")
            if at % 64 + min(32, width - 32 * n) > 64:
                collect.append(f"out[{at // 64 + 1}] |= uint64_t{{{value}}} >> {64 - at % 64};")
        low += width
    return fill | {
        "inputs": inputs, "digits": -(-inputs // 4), "entry": 32 + 4 * -(-inputs // 4),
        "in_words": -(-inputs // 32) + 1, "outputs": outputs, "words": words,
        "padded": 64 * words, "changes": traffic.changes, "cards": CARDS, "reset": RESET_CLKS,
        "pins": "\n".join(f"    {p}" for p in pins).rstrip(","),
        "drive": "\n".join(f"    {d}" for d in drive),
        "collect": "\n".join(f"      {c}" for c in collect),
    }  # fmt: skip


def _word(name: str, width: int, n: int) -> str:
    if width > 64:
        return f"top.{name}[{n}] ="
    return f"top.{name} =" if n == 0 else f"top.{name} |= (QData)"


def build(traffic: Traffic) -> dict[str, list[str]]:
    """Compiles both; the command of each, but for the number of clocks."""
    fill = _fill(traffic)
    bench = _write("bench_replay.sv", VERILOG % fill)
    main = _write("main.cpp", CPP % fill)
    files = [str(f) for f in sources("rtl")]
    rtl = str(ROOT / "rtl")
    bare = "-DMMCS_NO_ASSERT"  # as in the speed build
    _run(["iverilog", "-g2012", bare, "-o", "replay.vvp", "-I", rtl, "-s", "bench_replay",
          *files, str(bench)])  # fmt: skip
    _run(["verilator", "--cc", "--exe", "--build", "-Wno-fatal", "-Wno-lint", "-Wno-style",
          bare, "--top-module", "mmcs", f"-GNumCards={CARDS}", f"-I{rtl}", "-Mdir", "plain",
          *files, str(main)])  # fmt: skip
    return {"icarus": ["vvp", "-n", "replay.vvp"], "plain": ["plain/Vmmcs"]}


def _run(command: list[str]) -> str:
    done = subprocess.run(command, cwd=FOLDER, text=True, capture_output=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed: {(done.stderr or done.stdout).strip()[-1500:]}")
    return done.stdout


def replay(name: str, command: list[str], traffic: Traffic) -> float:
    """CPU seconds for the recorded clocks, start-up taken off; checks the digest."""
    times = []
    for n in (RESET_CLKS + 2, RESET_CLKS + traffic.clocks):
        cpu, runs = 0.0, 0
        while cpu < LEAST_CPU_S and runs < MOST_RUNS:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            text = _run([*command, f"+clocks={n}" if name == "icarus" else str(n)])
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpu += after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
            runs += 1
        times.append(cpu / runs)
    expected = f"digest {traffic.digest:016x} events {traffic.events}"
    if expected not in text:
        raise RuntimeError(f"{name} ran something else: {text.strip()}, not {expected}")
    return times[1] - times[0]
