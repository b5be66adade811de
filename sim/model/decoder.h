// SPDX-License-Identifier: Apache-2.0
// Which cards a command on the PC bus selects: the card's address decoder, Verilated by itself,
// evaluated once for each address; its answers are kept.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace mmcs {

class Decoder {
 public:
  Decoder();
  ~Decoder();
  // The selected cards, a bit each. The decoder's ports, by the names they have on the card; dips:
  // each card's address switches.
  uint32_t select(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n,
                  const std::vector<unsigned> &dips);
  void forget();  // switches have changed

 private:
  struct Verilated;
  struct Entry {
    uint32_t key = UINT32_MAX, cards = 0;
    uint32_t switches = 0;  // number of the switch settings that it was computed for
  };
  bool selects(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n, unsigned dip);

  const std::unique_ptr<Verilated> model_;
  std::vector<Entry> known_;
  uint32_t switches_ = 0;
};

}  // namespace mmcs
