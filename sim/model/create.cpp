// SPDX-License-Identifier: Apache-2.0
// The machine of the speed build; plain.cpp and checked.cpp have those of the others.

#include "rack.h"

std::unique_ptr<mmcs::Model> mmcs::Model::create(bool skip, uint64_t seed,
                                                 const std::string &card) {
  return std::make_unique<Rack>(skip, seed, card);
}
