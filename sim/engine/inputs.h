// SPDX-License-Identifier: Apache-2.0
// The named inputs of a simulation: what can go wrong, or be switched, while it runs.
#pragma once

#include "model.h"

namespace mmcs {

// Inputs of the machine come first, those of the plant follow.
enum class Scope { kGlobal, kCard, kAxis };
enum class Action { kPin, kStall, kBusError, kUpset, kHostDead, kWritesLost, kWriteFlip };

struct Input {
  const char *name;
  Action action;
  Scope scope;
  Pin pin;
  unsigned mask;              // values allowed: 0..mask
  bool inverted;              // the pin is 1 when the value is 0 (healthy at 1)
  const char *reg = nullptr;  // that is upset: its path, from the axis or from mmcs down
};

// The machine's inputs, kInputCount of them.
extern const Input kInputs[];
extern const int kInputCount;

}  // namespace mmcs
