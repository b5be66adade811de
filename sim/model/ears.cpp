// SPDX-License-Identifier: Apache-2.0
// See ears.h.

#include "ears.h"

namespace mmcs {

uint32_t Ears::hear(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n,
                    const std::vector<unsigned> &dips) {
  const uint32_t key = address << 3 | aen << 2 | ior_n << 1 | iow_n;
  Entry &entry = known_[key * 2654435761u >> 16];
  if (entry.key != key || entry.age != age_) {
    entry = {key, 0, age_};
    for (size_t n = 0; n < dips.size(); ++n) {
      if (hears(address, aen, ior_n, iow_n, dips[n])) entry.cards |= 1u << n;
    }
  }
  return entry.cards;
}

void Ears::forget() {
  ++age_;  // emptied instead, it would be most of what a restore costs
}

}  // namespace mmcs
