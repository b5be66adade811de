# SPDX-License-Identifier: Apache-2.0
"""A card of one's own in the loop: its registers, hash, snapshots, upsets; RTL that is no card."""

import json
import random
import re
import subprocess
import sys
from contextlib import suppress

import pytest
import pywellen

from mmcs.engine.own_card import inputs
from mmcs.errors import InputError
from mmcs.inputs import INPUTS
from mmcs.place import ROOT
from mmcs.runs.machine import card_of, machine
from mmcs.scenario.load import load
from mmcs.tests.conftest import call, good, one_clear_line

EXAMPLE = ROOT / "firmware" / "examples" / "pwm_card.sv"
PORTS = """(
  input  wire logic clk_i, rst_ni, pc_clk_en_i, pc_reset_drv_i, pc_aen_i, pc_ior_ni, pc_iow_ni,
  input  wire logic [15:0] pc_a_i, input wire logic [7:0] pc_d_i, input wire logic [3:1] pc_drq_i,
  output logic [7:0] pc_d_o, output logic pc_d_oe_o, pc_wait_o, output logic [7:3] pc_irq_o,
  input wire logic enc_a_i, enc_b_i, enc_i_i, axis_enable_i,
  input wire logic [15:0] adc_v_i, output logic [15:0] drive_v_o);
"""
# Never idle: random bits, a memory, wide, partial and unreset registers, one that bus or index
# clear without a clock; wait states, PANIC, read data that follow the address; a random drive.
MOVING = f"""
module delay #(parameter int N = 3) (input wire logic ck, d, output logic [N-1:0] q);
  always_ff @(posedge ck) q <= {{q[N-2:0], d}};
endmodule
module moving {PORTS}
  logic selected, command, clear_n;
  logic [30:0] bits_q;
  logic [7:0] memory_q [16], blocking;
  logic [99:0] wide_q;
  logic [15:0] bus_q;
  logic [2:0] waited_q, delayed;
  logic [3:0] cleared_q;
  assign selected = !pc_aen_i && pc_a_i[13:5] == 9'b1101_11000;
  assign command = selected && !(pc_ior_ni && pc_iow_ni);
  assign clear_n = !(command && pc_a_i[4:0] == 7) && !(enc_i_i && enc_a_i);
  assign drive_v_o = {{bits_q[30], bits_q[29:17], enc_a_i, enc_b_i}};
  initial bits_q = 1;
  delay #(.N(3)) u_delay (.ck(clk_i), .d(bits_q[0]), .q(delayed));
  for (genvar n = 0; n < 2; n++) begin : g_half
    logic [3:0] count_q;
    always_ff @(posedge clk_i or negedge rst_ni)
      count_q <= rst_ni ? count_q + 4'(n) + pc_drq_i[3] : 0;
  end
  always_ff @(posedge clk_i) begin
    bits_q <= {{bits_q[29:0], bits_q[30] ^ bits_q[27] ^ (command & ~pc_iow_ni & pc_d_i[0])}};
    bus_q <= pc_a_i ^ {{8'b0, pc_d_i}} ^ adc_v_i ^ {{13'b0, enc_a_i, enc_b_i, axis_enable_i}};
    for (int n = 0; n < 16; n++)
      if (bits_q[3:0] == 4'(n)) memory_q[n] <= memory_q[n] + 8'(n) + bus_q[7:0];
    wide_q <= {{wide_q[98:0], bits_q[5]}};
    waited_q <= !command ? 0 : waited_q == 5 ? 5 : waited_q + 1;
    blocking = blocking + 8'(waited_q);
  end
  always_ff @(posedge clk_i or negedge clear_n)
    if (!clear_n) cleared_q <= 0;
    else if (bits_q[1]) cleared_q <= cleared_q + 1;
  assign pc_wait_o = command && waited_q < 3;
  assign pc_d_oe_o = selected && !pc_ior_ni;
  assign pc_d_o = pc_a_i[4] ? {{cleared_q, delayed, pc_clk_en_i}}
      : memory_q[pc_a_i[3:0]] ^ wide_q[98:91] ^ {{g_half[0].count_q, g_half[1].count_q}} ^ blocking;
  assign pc_irq_o = {{bits_q[20:8] == 13'h1123, 4'b0}};
endmodule
"""


def setup(*files):
    cards = [{"file": str(file), "slot": n} for n, file in enumerate(files)]
    return load("lab500", (), card=cards, cards=2)


@pytest.fixture
def moving(tmp_path):
    (tmp_path / "moving.sv").write_text(MOVING)
    return tmp_path / "moving.sv"


# Of the machine, in the loop with the card: lines that are held, resets, a clock that stops.
FAULTS = {"pc_a_stuck1": 12, "pc_d_stuck0": 5, "pc_control_stuck0": 1, "sysreset": 1, "cable": 0,
          "pc_power": 0, "clock_stop": 1, "card_absent": 1}  # fmt: skip


def traffic(sim, seed, steps=100, back_at=None, faults=False):
    """Random accesses to the cards. The hash after each step; back_at: at that one a snapshot is
    taken, a different future run, and the snapshot restored. faults: each of FAULTS for a while."""
    chance, out = random.Random(seed), []
    sim.bus_write(0x409, 0x18)
    for n, (name, value) in enumerate(FAULTS.items() if faults else ()):
        for t, state in ((1e-3 * n + 1e-4, value), (1e-3 * n + 6e-4, INPUTS[name].healthy)):
            index = int(name == "card_absent")  # the Mark I beside it
            sim.add_event(sim.time + t, sim.input_names().index(name), index, state)
    for step in range(steps):
        if step == back_at:
            number = sim.snapshot()
            sim.bus_write(0x341, 77)
            sim.run(sim.time + 3e-4)
            sim.restore(number)
        register = chance.choice((0x41, 0x341)) + 2 * chance.randrange(24)
        with suppress(TimeoutError):
            if chance.random() < 0.5:
                sim.bus_write(register, chance.randrange(256))
            else:
                out.append(sim.bus_read(register))
        with suppress(TimeoutError):
            if chance.random() < 0.3:
                out.append(sim.bus_read(1 + 2 * chance.randrange(8)))
        if chance.random() < 0.5:
            sim.run(sim.time + chance.randrange(1, 200) * 1e-6)
        out.append(sim.hash())
    return out


def test_every_build_and_way_gives_one_hash(moving):
    """With the cache, without it, and the machine as a whole, clock by clock; with and without a
    snapshot between, taken while the card moves."""
    found = set()
    for kind, skip in (("speed", True), ("speed", False), ("trust", False)):
        for back_at in (None, 30, 71):
            with machine(setup(moving, EXAMPLE), kind, skip) as sim:
                found.add(tuple(traffic(sim, 53, back_at=back_at)))
                assert not [n for n in sim.notes() if n["kind"] == "assert"]
    assert len(found) == 1


def test_faults_of_the_machine_meet_it(moving):
    found = set()
    for kind, back_at in (("speed", None), ("speed", 120), ("trust", None), ("trust", 120)):
        with machine(setup(moving), kind) as sim:
            found.add(tuple(traffic(sim, 9, 260, back_at, faults=True)))
            assert sim.time > 8e-3
    assert len(found) == 1


def test_a_snapshot_goes_to_another_build(moving):
    with machine(setup(moving)) as quick, machine(setup(moving), "trust") as whole:
        traffic(quick, 1, 40)
        whole.restore_bytes(quick.snapshot_bytes(quick.snapshot()), quick.history_bytes())
        assert traffic(quick, 2, 40) == traffic(whole, 2, 40)


def test_its_registers_have_names_and_upsets(moving):
    plan = setup(moving)
    names = inputs(card_of(plan))
    assert {"seu.moving.g_half[1].count_q", "seu.moving.memory_q[15]", "seu.moving.wide_q[96+:32]",
            "seu.moving.u_delay.q", "seu.moving.cleared_q"} <= {*names}  # fmt: skip
    assert len(names) == len(set(names))
    plan.data["event"] = [{"at": 0.1, "input": "seu.moving.wide_q[96+:32]", "value": 4}]
    found = set()
    for kind in ("speed", "trust"):
        with machine(plan, kind) as sim:
            number = len(sim.input_names()) + names.index("seu.moving.cleared_q")
            sim.add_event(sim.time + 1e-4, number, 0, 5)
            hashes = traffic(sim, 3, 30)
            assert [n["text"] for n in sim.notes()] == ["seu.moving.cleared_q[0] = 5"]
            with pytest.raises(Exception, match="value out of range"):
                sim.add_event(1, number, 0, 16)
            found.add(tuple(hashes))
        with machine(plan, kind) as sim:
            assert traffic(sim, 3, 30) != hashes
    assert len(found) == 1


def test_run_record_replay_and_upset_by_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(
        'extends = "lab500"\nduration = 0.05\ncards = 2\nmotion = []\nexpect = []\n'
        '[[card]]\nfile = "pwm_card.sv"\n'
        '[[event]]\nat = 0.01\ninput = "seu.pwm_card.duty_q"\nvalue = 255\n'
    )
    card = tmp_path / "pwm_card.sv"
    card.write_text(EXAMPLE.read_text())
    good(call("run", "my.toml"))
    (tmp_path / "no.toml").write_text((tmp_path / "my.toml").read_text().replace("duty", "none"))
    one_clear_line(call("check", "no.toml"), '"seu.pwm_card.none_q": this machine has no such')
    report = json.loads((tmp_path / "runs" / "my" / "report.json").read_text())
    assert any("seu.pwm_card.duty_q" in event["text"] for event in report["events"])
    card.unlink()  # the record has it
    assert report["hash"] in good(call("replay", "runs/my"))
    good(call("trace", "runs/my", "--at", "0.01"))
    (trace,) = (tmp_path / "runs" / "my").glob("*.fst")
    found = {var.full_name: var for var in pywellen.Waveform(str(trace)).all_vars()}
    before, after = (int(value) for _, value in found["CARD.pwm_card.duty_q"].tv)
    assert before ^ after == 255
    view = trace.with_suffix(".gtkw").read_text()
    assert "+{pwm_card/duty_q[7:0]} CARD.pwm_card.duty_q[7:0]\n" in view


def test_a_program_drives_it(tmp_path):
    """The three files of the example."""
    for file in EXAMPLE.parent.glob("pwm_card.*"):
        (tmp_path / file.name).write_text(file.read_text())
    compiler = ["cc", "-Wall", "-Wextra", "-Werror", "-o", "pwm_card", "pwm_card.c"]
    subprocess.run(compiler, cwd=tmp_path, check=True)
    words = "-m mmcs exec --lockstep --scenario pwm_card.toml -- ./pwm_card 500"
    done = subprocess.run([sys.executable, *words.split()], cwd=tmp_path, check=True,
                          capture_output=True, text=True)  # fmt: skip
    assert done.stdout == "the joint is at 493 of 500 counts\n"


# A line in the example's module, and what is said of it.
BAD = {
    "logic l; always_comb if (run_q) l = out;": "Latch inferred for signal 'mmcs_card.pwm_card.l' ",
    "logic l; always_latch if (run_q) l = out;": "a latch: a card has flip-flops only",
    "assign out = 1'b0;": "out has several drivers; another is at pwm_card.sv:",
    "always_ff @(posedge clk_i) duty_q <= 8'd1;": "duty_q has several drivers; another is at ",
    "logic l; always_ff @(posedge pc_iow_ni) l <= out;": "pc_iow_ni is a second clock; ",
    "logic l; always_ff @(negedge clk_i) l <= out;": "clk_i is a second clock; ",
    "logic l, m_q; assign l = !(l & out); always_ff @(posedge clk_i) m_q <= l;":
        "Signal unoptimizable: Circular combinational logic",
    "logic l = nothing;": "Can't find definition of variable: 'nothing'",
    "logic l": "syntax error, unexpected ",
    "initial $finish;": "$finish is not for a card",
    'initial $system("ls");': "$system is not for a card",
    '`include "/etc/passwd"': "`include is not for a card",
    'import "DPI-C" function int f();': "DPI is not for a card",
}  # fmt: skip


@pytest.mark.parametrize("line", BAD)
def test_rtl_that_is_no_card_is_one_line(tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    lines = EXAMPLE.read_text().splitlines()
    at = next(n for n, text in enumerate(lines) if text.startswith("  logic run_q"))
    lines[at + 1 : at + 1] = [f"  {line}"]
    (tmp_path / "pwm_card.sv").write_text("\n".join(lines) + "\n")
    answer = call("run", "lab500", "--card", "pwm_card.sv", "--out", "out")
    one_clear_line(answer, BAD[line], start="pwm_card.sv:")
    assert re.match(r"mmcs: pwm_card\.sv:\d+: ", answer[2])


def test_a_missing_file_is_of_the_option(tmp_path):
    answer = call("run", "lab500", "--card", "nosuch.sv", "--out", str(tmp_path / "out"))
    one_clear_line(answer, start='--card = "nosuch.sv": ')


@pytest.mark.parametrize(("port", "other", "why"), [
    ("pc_a_i", "pc_address_i", "card pwm_card has no port pc_a_i"),
    ("[15:0] pc_a_i", "[13:0] pc_a_i", "port pc_a_i of card pwm_card must be an input of 16 bits"),
    ("clk_i,", "clk_i, input reset_i,", "card pwm_card has a port reset_i, which no slot has"),
])  # fmt: skip
def test_ports_are_those_of_the_bus(tmp_path, port, other, why):
    (tmp_path / "a.sv").write_text(EXAMPLE.read_text().replace(port, other))
    with pytest.raises(InputError, match=re.escape(why)):
        card_of(setup(tmp_path / "a.sv"))
