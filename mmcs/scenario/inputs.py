# SPDX-License-Identifier: Apache-2.0
"""What can be switched, or go wrong, during a run: the inputs that `event` entries name.

The engine has the same list (mmcs_sim_input_name), and after it an upset of each register of the
hardware; a test compares the two.
"""

from __future__ import annotations

from typing import NamedTuple


class Input(NamedTuple):
    scope: str  # "machine", "card" or "axis": what `index` counts
    healthy: float  # its value when nothing is wrong
    low: float
    high: float
    meaning: str


_ANY = 1e9
_CONTROL = "AS*, DS0*, DS1*, WRITE*, LWORD*, IACK*, IACKIN*"
INPUTS = {
    # the machine
    "estop": Input("machine", 0, 0, 1, "1: the hand-held button is pressed"),
    "cable": Input("machine", 1, 0, 1, "0: the ribbon cable is pulled"),
    "pc_power": Input("machine", 1, 0, 1, "0: the card cage has no power"),
    "sysreset": Input("machine", 0, 0, 1, "1: SYSRESET* of the VME bus is asserted"),
    "axis_enable": Input("axis", 1, 0, 1, "0: the front switch of the axis is at disable"),
    "card_absent": Input("card", 0, 0, 1, "1: the card does not answer"),
    "dip_xor": Input("card", 0, 0, 15, "bits of the DIP switch that are set wrong"),
    "sclock_open": Input("card", 0, 0, 1, "1: the card's SCLOCK jumper is on another line"),
    "panic_open": Input("card", 0, 0, 1, "1: the card's PANIC jumper is on another line"),
    "dac_stuck1": Input("axis", 0, 0, 4095, "bits of the D/A that are stuck at 1"),
    "dac_stuck0": Input("axis", 0, 0, 4095, "bits of the D/A that are stuck at 0"),
    "adc_stuck": Input("axis", 0, 0, 1, "1: the A/D keeps its last code"),
    "irq_lost": Input("machine", 0, 0, 1, "1: SCLOCK edges do not reach the interrupt latch"),
    "host_stall": Input("machine", 0, 0, 1e6, "the host takes no interrupt for so many ms"),
    "bus_error": Input("machine", 0, 0, 1e6, "so many of the next bus cycles end in BERR*"),
    "vme_a_stuck0": Input(
        "machine", 0, 0, 0x7FFF, "VME lines A01 (bit 0) to A15 that are held at 0"
    ),
    "vme_a_stuck1": Input("machine", 0, 0, 0x7FFF, "those held at 1"),
    "vme_am_stuck0": Input("machine", 0, 0, 63, "lines AM0 to AM5 that are held at 0"),
    "vme_am_stuck1": Input("machine", 0, 0, 63, "those held at 1"),
    "vme_d_stuck0": Input("machine", 0, 0, 0xFFFF, "lines D00 to D15 that are held at 0"),
    "vme_d_stuck1": Input("machine", 0, 0, 0xFFFF, "those held at 1"),
    "vme_control_stuck0": Input("machine", 0, 0, 127, f"of {_CONTROL}, those held at 0"),
    "vme_control_stuck1": Input("machine", 0, 0, 127, "those held at 1"),
    "pc_a_stuck0": Input("machine", 0, 0, 0x3FF, "address lines of the ribbon that are held at 0"),
    "pc_a_stuck1": Input("machine", 0, 0, 0x3FF, "those held at 1"),
    "pc_d_stuck0": Input("machine", 0, 0, 255, "its data lines that are held at 0"),
    "pc_d_stuck1": Input("machine", 0, 0, 255, "those held at 1"),
    "pc_control_stuck0": Input("machine", 0, 0, 3, "of IOR#, IOW#, those held at 0"),
    "pc_control_stuck1": Input("machine", 0, 0, 3, "those held at 1"),
    "clock_stop": Input("machine", 0, 0, 1, "1: the clock of adaptor and cards has stopped"),
    "host_dead": Input("machine", 0, 0, 1, "1: the host executes nothing any more, for good"),
    "writes_lost": Input("machine", 0, 0, 1e6, "so many of the program's next writes are lost"),
    "write_flip": Input("axis", 0, 0, 2**32 - 1, "bits that are wrong in the program's next write"),
    "seu_encoder": Input("axis", 0, 0, 65535, "a particle flips these bits of the counter, once"),
    "seu_dac_input": Input("axis", 0, 0, 4095, "the same in the D/A's input latch"),
    "seu_dac_output": Input("axis", 0, 0, 4095, "the same in the D/A's output latch"),
    "seu_index_latch": Input("axis", 0, 0, 1, "the same in the index latch"),
    "seu_heartbeat": Input("axis", 0, 0, 1, "the same in the heartbeat's one-shot"),
    "seu_pccsr": Input("machine", 0, 0, 255, "the same in the PCCSR"),
    "seu_vector": Input("machine", 0, 0, 255, "the same in the vector register"),
    # the plant
    "encoder_a_cut": Input("axis", 0, 0, 2, "wire A of the encoder is cut: reads 0 (1), 1 (2)"),
    "encoder_b_cut": Input("axis", 0, 0, 2, "wire B of the encoder is cut: reads 0 (1), 1 (2)"),
    "encoder_index_cut": Input("axis", 0, 0, 2, "the index wire is cut: reads 0 (1), 1 (2)"),
    "encoder_swap": Input("axis", 0, 0, 1, "1: wires A and B are swapped"),
    "encoder_glitch": Input("axis", 0, 0, _ANY, "spikes per second on A and B"),
    "index_glitch": Input("axis", 0, 0, _ANY, "spikes per second on the index wire"),
    "encoder_slip": Input("axis", 0, -_ANY, _ANY, "counts that the disc has slipped on its shaft"),
    "index_missing": Input("axis", 0, 0, 1, "1: the disc has no index mark"),
    "pot_noise": Input("axis", 0, 0, 10, "noise on the potentiometer, V rms"),
    "pot_cut": Input("axis", 0, 0, 1, "1: the potentiometer reads 0 V"),
    "amp_dead": Input("axis", 0, 0, 1, "1: the amplifier gives no current"),
    "amp_saturated": Input("axis", 0, -1, 1, "the amplifier is stuck at full current of this sign"),
    "drive_offset": Input("axis", 0, -10, 10, "volts added to the drive"),
    "brake_stuck": Input("axis", 0, 0, 2, "1: the brake stays off; 2: it stays on"),
    "load_torque": Input("axis", 0, -_ANY, _ANY, "N m at the motor, against positive turning"),
    "motor_jam": Input("axis", 0, 0, 1, "1: the shaft is blocked"),
}

UPSET = "seu."  # then the name of any register, as `mmcs faults` lists them


def find(name: str) -> Input | None:
    """The input of this name; the engine knows which registers there are, and how wide."""
    if name.startswith(UPSET) and name not in INPUTS:
        return Input("machine", 0, 0, 2**32 - 1, "a particle flips these bits, once")
    return INPUTS.get(name)
