// SPDX-License-Identifier: Apache-2.0
// Bit fields of Verilator's port types, whatever width the number of cards gave them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "verilated.h"

namespace mmcs {

// Verilator's port members are references, hence T & without a cast to T.
template <typename T>
void put_field(T &port, int lsb, int width, uint64_t value) {
  const uint64_t mask = ((1ull << width) - 1) << lsb;
  port = (port & ~mask) | ((value << lsb) & mask);
}

template <std::size_t N>
void put_field(VlWide<N> &port, int lsb, int width, uint64_t value) {
  for (int bit = 0; bit < width; ++bit) {
    const int at = lsb + bit;
    const EData mask = EData{1} << (at % 32);
    if ((value >> bit) & 1) {
      port[at / 32] |= mask;
    } else {
      port[at / 32] &= ~mask;
    }
  }
}

template <typename T>
uint64_t get_field(const T &port, int lsb, int width) {
  return (static_cast<uint64_t>(port) >> lsb) & ((1ull << width) - 1);
}

template <std::size_t N>
uint64_t get_field(const VlWide<N> &port, int lsb, int width) {
  uint64_t value = port[lsb / 32] >> (lsb % 32);
  if (lsb % 32 + width > 32) value |= static_cast<uint64_t>(port[lsb / 32 + 1]) << (32 - lsb % 32);
  return value & ((1ull << width) - 1);
}

}  // namespace mmcs
