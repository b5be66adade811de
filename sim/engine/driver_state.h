// SPDX-License-Identifier: Apache-2.0
// The driver's own state without its ties to the host that called mc_attach().
#pragma once

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "archive.h"

namespace mmcs {

// Where in the driver's memory its state begins; bus and host functions are in front of it.
size_t driver_state_begin();

template <class A>
void driver_state(A &a, std::vector<uint64_t> &memory) {
  const size_t begin = driver_state_begin();
  const size_t size = memory.size() * sizeof(uint64_t) - begin;
  size_t saved = size;
  a(saved);
  if (saved != size) throw std::invalid_argument("the snapshot holds another driver");
  a.raw(reinterpret_cast<uint8_t *>(memory.data()) + begin, size);
}

}  // namespace mmcs
