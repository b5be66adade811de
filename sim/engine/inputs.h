// SPDX-License-Identifier: Apache-2.0
// The table of the inputs (sim/abi/inputs.def) with what the engine does about each.
#pragma once

#include "mmcs_sim.h"
#include "model.h"

namespace mmcs {

enum class Action { kPin, kPlant, kUpset, kStall, kBusError, kHostDead, kWritesLost, kWriteFlip };

struct Input {
  mmcs_input about;
  Action action;
  int number;       // a Pin, or an input of the plant
  const char *reg;  // that is upset: its path, from the axis or from mmcs down

  // The host's and its program's own: a real processor does not have them.
  bool native() const { return action >= Action::kHostDead; }
};

extern const Input kInputs[];
extern const int kInputCount;

}  // namespace mmcs
