// SPDX-License-Identifier: Apache-2.0
// The table of the inputs (sim/abi/inputs.def) with what the engine does about each.
#pragma once

#include "axis.h"
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

constexpr mmcs_input about(int lasting, const char *name, Scope scope, double low, double high,
                           double healthy, const char *draw, const char *sort,
                           const char *meaning) {
  return {name, static_cast<int32_t>(scope), lasting, low, high, healthy, draw, sort, meaning};
}

constexpr Scope kMachine = Scope::kMachine, kCard = Scope::kCard, kAxis = Scope::kAxis;

inline constexpr Input kInputs[] = {
#define PIN(pin, ...) {about(1, __VA_ARGS__), Action::kPin, static_cast<int>(Pin::pin), nullptr},
#define HOST(action, ...) {about(0, __VA_ARGS__), Action::action, 0, nullptr},
#define UPSET(reg, ...) {about(0, __VA_ARGS__), Action::kUpset, 0, reg},
#define PLANT(input, ...) {about(1, __VA_ARGS__), Action::kPlant, input, nullptr},
#include "inputs.def"
};
constexpr int kInputCount = sizeof kInputs / sizeof kInputs[0];

}  // namespace mmcs
