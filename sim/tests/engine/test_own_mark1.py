# SPDX-License-Identifier: Apache-2.0
"""Motors on a card of one's own: rtl/mark1/ as such a card, in the place of the machine's own."""

import re
import subprocess

import pytest

from mmcs import ROOT, load
from mmcs.engine.own_card import inputs
from mmcs.engine.script import Serving
from mmcs.errors import InputError, RunError
from mmcs.runs.machine import card_of, machine
from mmcs.runs.session import Session

WRAP = """
module own_mark1 #(parameter int ClkHz = 8_000_000, parameter int Slot = 0) (
  input wire logic clk_i, rst_ni, pc_clk_en_i, pc_reset_drv_i, pc_aen_i, pc_ior_ni, pc_iow_ni,
  input wire logic [15:0] pc_a_i, input wire logic [7:0] pc_d_i, input wire logic [3:1] pc_drq_i,
  output logic [7:0] pc_d_o, output logic pc_d_oe_o, output logic [7:3] pc_irq_o,
  input wire logic [1:0] enc_a_i, enc_b_i, enc_i_i, axis_enable_i, input wire logic [31:0] adc_v_i,
  output logic [31:0] drive_v_o);
  logic [10:0] leds;
  mark1 #(.ClkHz(ClkHz)) u_card (.*, .dip_i(4'(Slot)), .power_i(1'b1), .leds_o(leds));
endmodule
"""
# What mark1 is made of.
PARTS = ("regs/mmcs_regs_pkg", "lib/*", "mark1/*", "chips/ad*", "chips/oneshot", "chips/i8255",
         "chips/thct2000")  # fmt: skip


@pytest.fixture(scope="module")
def mark1(tmp_path_factory):
    files = [file for part in PARTS for file in sorted((ROOT / "rtl").glob(f"{part}.sv"))]
    words = ["verilator", "-E", "-P", "-DMMCS_NO_ASSERT", f"-I{ROOT / 'rtl'}", *files]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    path = tmp_path_factory.mktemp("card") / "own_mark1.sv"
    path.write_text(done.stdout + WRAP)
    return path


def setup(name, *cards, duration=None, **slots):
    return load(name, duration=duration, card=[{"file": str(c)} | slots for c in cards])


def result(plan, kind="speed"):
    with machine(plan, kind) as sim:
        return Session(sim, plan).run()


@pytest.mark.req("API-1", "ENC-1", "DAC-1")
@pytest.mark.parametrize(("name", "kind"), [
    ("lab500", "speed"), ("lab500", "trust"), ("puma560", "speed"), ("fault_seu_dac", "speed"),
    ("lab500", "checked"),
])  # fmt: skip
def test_a_mark_i_in_its_place_is_a_mark_i(mark1, name, kind, monkeypatch):
    """Every sample, bus cycle, voltage and line. checked: each bus cycle as one step as well."""
    duration = None if kind == "speed" else 0.2
    if kind == "checked":
        kind = monkeypatch.setenv("MMCS_CHECK", "1") or "speed"
    own, before = (result(setup(name, *cards, duration=duration), kind) for cards in ((mark1,), ()))
    assert own.checkpoints == before.checkpoints and len(own.checkpoints) > 4
    assert own.log.tobytes() == before.log.tobytes() and own.states == before.states
    assert own.truth.tobytes() == before.truth.tobytes() and own.hash != before.hash


def test_a_snapshot_while_it_moves(mark1):
    """The same future in the same machine and in another build."""
    plan = setup("lab500", mark1)
    with machine(plan) as sim, machine(plan, "trust") as whole:
        Session(sim, plan).begin()
        sim.run(0.13)
        number = sim.snapshot()
        sim.run(0.16)
        end = sim.hash()
        sim.restore(number)
        assert sim.hash() != end
        whole.restore_bytes(sim.snapshot_bytes(number), sim.history_bytes())
        for one in (sim, whole):
            one.run(0.16)
            assert one.hash() == end
        state = sim.snapshot_bytes(sim.snapshot()), sim.history_bytes()
    with (
        machine(setup("lab500")) as sim,
        pytest.raises(ValueError, match="belongs to another mach"),
    ):
        sim.restore_bytes(*state)


@pytest.mark.parametrize(("cards", "slot", "why"), [
    (1, 1, "slot 1 is not free for card a and its joints, "
           "of which a slot has two: 2; free slots: 0"),
    (2, 0, "slot 0 is not free for card a "), (2, None, "no slot is left for card a "),
])  # fmt: skip
def test_slots_are_those_of_the_crate(mark1, tmp_path, cards, slot, why):
    files = [tmp_path / f"{name}.sv" for name in "ab"[:cards]]
    for file, text in zip(files, (mark1.read_text(), WRAP), strict=False):
        file.write_text(text.replace("own_mark1", file.stem))
    with pytest.raises(InputError, match=re.escape(why)):
        card_of(setup("lab500", *files, slot=slot))


def test_faults_of_the_mark_i_that_is_out_are_refused(mark1):
    event = [{"at": 0.1, "input": "dac_stuck1", "index": 0, "value": 4}]
    plan = load("lab500", event=event, card=[{"file": str(mark1)}])
    with pytest.raises(RunError, match="an own card is in that slot, not a Mark I"):
        result(plan)


ANSWERS = """
module {} (input wire logic clk_i, rst_ni, pc_aen_i, pc_ior_ni, pc_iow_ni,
  input wire logic [15:0] pc_a_i, input wire logic [7:0] pc_d_i,
  output logic [7:0] pc_d_o, output logic pc_d_oe_o);
  logic [3:0] slot_q;
  always_ff @(posedge clk_i or negedge rst_ni) if (!rst_ni) slot_q <= 4'd{};
  assign pc_d_oe_o = !pc_ior_ni && pc_a_i[13:5] == {{slot_q, 5'h18}};
  assign pc_d_o = 8'h5A;
endmodule
"""


def test_two_cards_that_answer_end_the_run(tmp_path):
    """Not the first alone, nor the last, which a flipped bit brings; the third is at a Mark I's."""
    files = [tmp_path / f"{name}.sv" for name in "abcd"]
    for file, slot in zip(files, (14, 14, 0, 15), strict=True):
        file.write_text(ANSWERS.format(file.stem, slot))
    with machine(setup("lab500", files[0])) as sim:
        sim.bus_write(0x409, 0x18)
        assert sim.bus_read(14 << 6 | 1) == 0x5A
    for kind in ("speed", "trust"):
        for cards, slot in ((files[:2], 14), (files[2:3], 0)):
            with pytest.raises(RunError, match=f"two cards answer a read .* slot {slot}"):
                result(setup("lab500", *cards), kind)
        plan = setup("lab500", files[0], files[3])
        with machine(plan, kind) as sim:
            number = len(sim.input_names()) + inputs(card_of(plan)).index("seu.d.slot_q")
            sim.add_event(0, number, 0, 1)
            sim.bus_write(0x409, 0x18)
            assert sim.run(1e-4) and sim.bus_read(14 << 6 | 1) == 0x5A and sim.run(2e-4)
        with machine(setup("lab500", *files[:2]), kind) as sim:
            server = Serving(sim)
            sim.bus_write(0x409, 0x18)
            server.bus(server.enter("device", 1), 0x6000 | 14 << 6 | 1, 1, None)
            assert not sim.run(sim.time + 1) and not sim.run(sim.time) and sim.time < 1
            assert server.request(None, {"op": "snapshot"})["text"].startswith(
                "no snapshot: an ass"
            )
            for at in (None, 0.5):
                with pytest.raises(RunError, match="an assertion of the machine has failed"):
                    sim.snapshot(at)
            assert [note["kind"] for note in sim.notes()].count("assert") == 1
    with pytest.raises(InputError, match="card a has no joints, so it takes no slot"):
        card_of(setup("lab500", files[0], slot=0))


def test_its_registers_are_watched(mark1):
    """As mctool's Waves does."""
    with machine(setup("lab500", mark1), skip=False) as sim:
        assert sim.watch([], ["own_mark1.u_card.u_ppi.d_q", "own_mark1.nobody"]) == [
            "own_mark1.u_card.u_ppi.d_q"
        ]
        sim.bus_write(0x409, 0x18)
        sim.bus_write(0x7, 0x5A)
        assert 0x5A in sim.changes()["value"]
