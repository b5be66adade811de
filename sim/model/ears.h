// SPDX-License-Identifier: Apache-2.0
// Which cards hear a command: the address decoder of the card, Verilated by itself, asked once for
// each address and remembered.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace mmcs {

class Ears {
 public:
  Ears();
  ~Ears();
  // The decoder's ports, by the names they have on the card; dip is the card's own.
  uint32_t hear(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n,
                const std::vector<unsigned> &dips);
  void forget();  // switches have moved

 private:
  struct Decoder;
  struct Entry {
    uint32_t key = UINT32_MAX, cards = 0;
    uint32_t age = 0;  // of the switches that it was asked under
  };
  bool hears(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n, unsigned dip);

  std::unique_ptr<Decoder> decoder_;
  std::vector<Entry> known_;
  uint32_t age_ = 0;
};

}  // namespace mmcs
