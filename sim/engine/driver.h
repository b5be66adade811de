// SPDX-License-Identifier: Apache-2.0
// The mc driver's interface, which is C, as C++ wants to see it; and the driver's own state,
// without its ties to the host that called mc_attach().
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "archive.h"

extern "C" {
#include "mc.h"
#include "mc_priv.h"
}

namespace mmcs {

static_assert(offsetof(struct mc, bus) == 0 && offsetof(struct mc, os) == sizeof(struct mc_bus) &&
                  offsetof(struct mc, config) == sizeof(struct mc_bus) + sizeof(struct mc_os),
              "nothing that must be saved lies in front of the configuration");

template <class A>
void driver_state(A &a, std::vector<uint64_t> &memory) {
  const size_t begin = offsetof(struct mc, config), size = memory.size() * sizeof(uint64_t) - begin;
  size_t saved = size;
  a(saved);
  if (saved != size) throw std::invalid_argument("the snapshot holds another driver");
  a.raw(reinterpret_cast<uint8_t *>(memory.data()) + begin, size);
}

}  // namespace mmcs
