// SPDX-License-Identifier: Apache-2.0
// The table of the machine's named inputs.

#include "inputs.h"

namespace mmcs {

const Input kInputs[] = {
    // hand-held button: 1 = pressed (loop open)
    {"estop", Action::kPin, Scope::kGlobal, Pin::kEstop, 1, false},
    // ribbon between adaptor and cards: 1 = plugged in
    {"cable", Action::kPin, Scope::kGlobal, Pin::kCableCut, 1, true},
    // supply of the card cage: 1 = on
    {"pc_power", Action::kPin, Scope::kGlobal, Pin::kPcOff, 1, true},
    // SYSRESET* of the VME bus: 1 = asserted
    {"sysreset", Action::kPin, Scope::kGlobal, Pin::kSysreset, 1, false},
    // front switch of an axis: 1 = enabled
    {"axis_enable", Action::kPin, Scope::kAxis, Pin::kAxisEnable, 1, false},
    // card pulled: 1
    {"card_absent", Action::kPin, Scope::kCard, Pin::kCardAbsent, 1, false},
    // DIP switch misset: XOR with the right value
    {"dip_xor", Action::kPin, Scope::kCard, Pin::kDipXor, 15, false},
    // jumpers of the SCLOCK and PANIC lines lifted: 1
    {"sclock_open", Action::kPin, Scope::kCard, Pin::kSclockOpen, 1, false},
    {"panic_open", Action::kPin, Scope::kCard, Pin::kPanicOpen, 1, false},
    // D/A bits stuck at 1 or 0: a mask of 12 bits
    {"dac_stuck1", Action::kPin, Scope::kAxis, Pin::kDacStuck1, 4095, false},
    {"dac_stuck0", Action::kPin, Scope::kAxis, Pin::kDacStuck0, 4095, false},
    // A/D that keeps its last code: 1
    {"adc_stuck", Action::kPin, Scope::kAxis, Pin::kAdcStuck, 1, false},
    // SCLOCK edges do not reach the interrupt latch: 1
    {"irq_lost", Action::kPin, Scope::kGlobal, Pin::kIrqLost, 1, false},
    // the host takes no interrupt for so many milliseconds
    {"host_stall", Action::kStall, Scope::kGlobal, Pin::kCount, 1000000, false},
    // so many of the next bus cycles end in BERR*
    {"bus_error", Action::kBusError, Scope::kGlobal, Pin::kCount, 1000000, false},
    // lines of the VME bus, then of the ribbon, that are held at 0 or 1: masks
    {"vme_a_stuck0", Action::kPin, Scope::kGlobal, Pin::kVmeA0, 32767, false},
    {"vme_a_stuck1", Action::kPin, Scope::kGlobal, Pin::kVmeA1, 32767, false},
    {"vme_am_stuck0", Action::kPin, Scope::kGlobal, Pin::kVmeAm0, 63, false},
    {"vme_am_stuck1", Action::kPin, Scope::kGlobal, Pin::kVmeAm1, 63, false},
    {"vme_d_stuck0", Action::kPin, Scope::kGlobal, Pin::kVmeD0, 65535, false},
    {"vme_d_stuck1", Action::kPin, Scope::kGlobal, Pin::kVmeD1, 65535, false},
    {"vme_control_stuck0", Action::kPin, Scope::kGlobal, Pin::kVmeControl0, 127, false},
    {"vme_control_stuck1", Action::kPin, Scope::kGlobal, Pin::kVmeControl1, 127, false},
    {"pc_a_stuck0", Action::kPin, Scope::kGlobal, Pin::kPcA0, 1023, false},
    {"pc_a_stuck1", Action::kPin, Scope::kGlobal, Pin::kPcA1, 1023, false},
    {"pc_d_stuck0", Action::kPin, Scope::kGlobal, Pin::kPcD0, 255, false},
    {"pc_d_stuck1", Action::kPin, Scope::kGlobal, Pin::kPcD1, 255, false},
    {"pc_control_stuck0", Action::kPin, Scope::kGlobal, Pin::kPcControl0, 3, false},
    {"pc_control_stuck1", Action::kPin, Scope::kGlobal, Pin::kPcControl1, 3, false},
    // the clock of adaptor and cards has stopped: 1
    {"clock_stop", Action::kPin, Scope::kGlobal, Pin::kClockStop, 1, false},
    // the host executes nothing any more, in the middle of whatever it does: 1
    {"host_dead", Action::kHostDead, Scope::kGlobal, Pin::kCount, 1, false},
    // so many of the program's next writes of setpoints are lost
    {"writes_lost", Action::kWritesLost, Scope::kGlobal, Pin::kCount, 1000000, false},
    // bits that are wrong in its next write
    {"write_flip", Action::kWriteFlip, Scope::kAxis, Pin::kCount, 0xFFFFFFFF, false},
    // a particle flips these bits of a register, once
    {"seu_encoder", Action::kUpset, Scope::kAxis, Pin::kCount, 65535, false, "u_encoder.count_q"},
    {"seu_dac_input", Action::kUpset, Scope::kAxis, Pin::kCount, 4095, false, "u_dac.rank1_q"},
    {"seu_dac_output", Action::kUpset, Scope::kAxis, Pin::kCount, 4095, false, "u_dac.rank2_q"},
    {"seu_index_latch", Action::kUpset, Scope::kAxis, Pin::kCount, 1, false, "index_latch_q"},
    {"seu_heartbeat", Action::kUpset, Scope::kAxis, Pin::kCount, 1, false, "u_heartbeat.run_q"},
    {"seu_pccsr", Action::kUpset, Scope::kGlobal, Pin::kCount, 255, false,
     "u_adaptor.u_core.u_pccsr.csr_q"},
    {"seu_vector", Action::kUpset, Scope::kGlobal, Pin::kCount, 255, false,
     "u_adaptor.u_core.vector_q"},
};
const int kInputCount = sizeof kInputs / sizeof kInputs[0];

}  // namespace mmcs
