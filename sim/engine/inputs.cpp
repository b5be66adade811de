// SPDX-License-Identifier: Apache-2.0
// See inputs.h.

#include "inputs.h"

#include "axis.h"

namespace mmcs {

static constexpr mmcs_input about(int lasting, const char *name, Scope scope, double low,
                                  double high, double healthy, const char *draw, const char *sort,
                                  const char *meaning) {
  return {name, static_cast<int32_t>(scope), lasting, low, high, healthy, draw, sort, meaning};
}

static constexpr Scope kMachine = Scope::kMachine, kCard = Scope::kCard, kAxis = Scope::kAxis;

const Input kInputs[] = {
#define PIN(pin, ...) {about(1, __VA_ARGS__), Action::kPin, static_cast<int>(Pin::pin), nullptr},
#define HOST(action, ...) {about(0, __VA_ARGS__), Action::action, 0, nullptr},
#define UPSET(reg, ...) {about(0, __VA_ARGS__), Action::kUpset, 0, reg},
#define PLANT(input, ...) {about(1, __VA_ARGS__), Action::kPlant, input, nullptr},
#include "inputs.def"
};
const int kInputCount = sizeof kInputs / sizeof kInputs[0];

}  // namespace mmcs
