// SPDX-License-Identifier: Apache-2.0
// The layout of the driver's memory: see driver_state.h.

#include "driver_state.h"

#include <cstddef>

extern "C" {
#include "mc_priv.h"
}

namespace mmcs {

static_assert(offsetof(struct mc, bus) == 0 && offsetof(struct mc, os) == sizeof(struct mc_bus) &&
                  offsetof(struct mc, config) == sizeof(struct mc_bus) + sizeof(struct mc_os),
              "nothing that must be saved lies in front of the configuration");

size_t driver_state_begin() {
  return offsetof(struct mc, config);
}

}  // namespace mmcs
