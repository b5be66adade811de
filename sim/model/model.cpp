// SPDX-License-Identifier: Apache-2.0
// What all builds of the machine share.

#include "model.h"

#include <string>

#include "wires.h"

namespace mmcs {

int Model::cards() {
  return kWires.cards;
}

int Model::clk_hz() {
  return MMCS_CLK_HZ;
}

uint16_t Model::encoder_register(int axis) {
  return static_cast<uint16_t>(read(find_register(axis_path(axis) + ".u_encoder.count_q")));
}

uint64_t Model::digest() {
  uint64_t hash = 0xCBF29CE484222325ull;
  for (size_t reg = 0; reg < registers().size(); ++reg) {
    hash = (hash ^ read(static_cast<int>(reg))) * 0x100000001B3ull;
  }
  return hash;
}

}  // namespace mmcs
