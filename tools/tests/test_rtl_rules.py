# SPDX-License-Identifier: Apache-2.0
"""What rtl/ and fpga/ may hold: green as it is, red for each name and each decision put back."""

import re
import shutil

import pytest

from tools import rtl_rules

PUT_BACK = [
    ("rtl/mmcs.sv", "  parameter bit Skip = 1'b0,"),
    ("rtl/mmcs.sv", "  parameter bit Gate = 1'b0,"),
    ("rtl/mark1/mark1.sv", "  parameter bit Sleeps = 1'b0,"),
    ("rtl/mark1/mark1.sv", "  input  wire logic asleep_i,"),
    ("rtl/mark1/mark1_relay.sv", "  input  wire logic clk_free_i,"),
    ("rtl/mark1/mark1_relay.sv", "  output logic due_o,"),
    ("rtl/adaptor/adaptor_core.sv", "  output logic awake_o,"),
    ("rtl/adaptor/panic.sv", "  output logic settled_o,"),
    ("rtl/adaptor/pccsr.sv", "  input  wire logic irq_lost_i,"),
    ("rtl/chips/ad574.sv", "  output logic [15:0] horizon_o,"),
    ("rtl/chips/thct2000.sv", "  input  wire logic [15:0] extra_i,"),
    ("rtl/mmcs.sv", "  input  wire logic [2:0] card_absent_i,"),
    ("rtl/mmcs.sv", "  input  wire logic [2:0] sclock_open_i,"),
    ("rtl/mmcs.sv", "  input  wire logic [11:0] dip_xor_i,"),
    ("rtl/mmcs.sv", "  input  wire logic [71:0] dac_stuck1_i,"),
    ("rtl/adaptor/reg_window.sv", "  input  wire logic fault_i,"),
    ("rtl/adaptor/adaptor_vme.sv", "  // when skipping, the next edge matters"),
    ("rtl/chips/i8255.sv", "  // so that a simulator keeps the result"),
    ("fpga/bus/vme_adaptor.sv", "    .skip_extra_i('0),"),
    ("fpga/bus/spi_converters.sv", "  // nothing that a simulator need know"),
]


def test_the_hardware_is_hardware():
    assert rtl_rules.complaints(rtl_rules.ROOT) == []


def with_text(folder, file, text):
    """What is found where a file has another text."""
    for place in ("rtl", "fpga"):
        shutil.copytree(rtl_rules.ROOT / place, folder / place)
    (folder / file).write_text(text)
    return rtl_rules.complaints(folder)


@pytest.mark.parametrize(("file", "line"), PUT_BACK)
def test_a_name_put_back_is_found(tmp_path, file, line):
    found = with_text(tmp_path, file, f"{(rtl_rules.ROOT / file).read_text()}\n{line}\n")
    assert len(found) == 1 and found[0].startswith(f"{file}:"), found


DECIDED = [  # file, what holds `q <= d`, what decides instead
    ("rtl/adaptor/panic.sv", "else trip_q <= trip_d;", "else if (tripped) trip_q <= 1'b0;"),
    ("rtl/adaptor/panic.sv", "hold_q  <= hold_d;", "if (tripped) hold_q <= '0;"),
    ("rtl/adaptor/vme_slave.sv", "busy_q     <= busy_d;", "busy_q <= ds0_valid & ds_any_sync;"),
    ("rtl/adaptor/sysclk.sv", "phase_q <= phase_d;", "phase_q <= phase_q + 1'b1;"),
    ("fpga/bus/pcbus_pins.sv", "pc_ale       <= ale_d;", "pc_ale <= ~(|ior_q);"),
]


@pytest.mark.parametrize(("file", "old", "new"), DECIDED)
def test_next_state_within_always_ff_is_found(tmp_path, file, old, new):
    text = (rtl_rules.ROOT / file).read_text()
    assert text.count(old) == 1
    line = text[: text.index(old)].count("\n") + 1
    found = with_text(tmp_path, file, text.replace(old, new))
    assert found[0].startswith(f"{file}:{line}: next state"), found


UNKNOWN = [("vme_slave", "bus_write_q"), ("vme_slave", "bus_d_q"), ("vme_strobe", "begun_q"),
           ("vme_strobe", "ds0_stale_q"), ("vme_interrupter", "iackin_stale_q")]  # fmt: skip


@pytest.mark.parametrize(("module", "net"), UNKNOWN)
def test_a_flip_flop_of_a_pin_without_an_initial_value_is_found(tmp_path, module, net):
    file = f"rtl/adaptor/{module}.sv"
    text = re.sub(rf"({net}) = [^;]*;", r"\1;", (rtl_rules.ROOT / file).read_text(), count=1)
    found = with_text(tmp_path, file, text)
    assert found == [f"{file}: {net}: a pin clocks it: give it an initial value as well"]
