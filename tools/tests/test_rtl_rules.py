# SPDX-License-Identifier: Apache-2.0
"""What rtl/ and fpga/ may hold: green as it is, red for each decision put back."""

import re
import shutil

import pytest

from tools import rtl_rules


def test_the_hardware_keeps_the_rules():
    assert rtl_rules.complaints(rtl_rules.ROOT) == []


def with_text(folder, file, text):
    """What is found where a file has another text."""
    for place in ("rtl", "fpga"):
        shutil.copytree(rtl_rules.ROOT / place, folder / place)
    (folder / file).write_text(text)
    return rtl_rules.complaints(folder)


@pytest.mark.parametrize("place", ["rtl/chips/x.sv", "fpga/bus/x.sv"])
@pytest.mark.parametrize("name", ["SkipExtra", "asleep_i", "awake_o", "horizon_o", "irq_lost_i",
                                  "card_absent_i", "dac_stuck1_i", "fault_i"])  # fmt: skip
def test_a_name_for_a_simulator_is_found(tmp_path, place, name):
    (tmp_path / place).parent.mkdir(parents=True)
    (tmp_path / place).write_text(f'module x (\n  input wire logic {name},  // fault\n  "lost"')
    found = rtl_rules.complaints(tmp_path)
    assert len(found) == 1 and found[0].startswith(f"{place}:2: "), found


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
