// SPDX-License-Identifier: Apache-2.0
// Logic that the rack evaluates beside the parts: that of rtl/mmcs.sv between its boards, and the
// address decoder of a card.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "board.h"

namespace mmcs {

// The combinational logic between boards: mmcs.sv Verilated with empty boards.
class Glue {
 public:
  explicit Glue(VerilatedContext &context);
  ~Glue();
  // An output of a board (kWires.boards), to be written; null if no logic reads it.
  Net board_output(const std::string &board, const std::string &port) const;
  // A net of mmcs.sv that the logic drives, to be read; null if it drives none of this name.
  Net net(const std::string &name) const;
  // Outputs of a card of one's own, on the PC-bus expansion.
  void put_card(uint64_t data, bool drives, uint64_t irq);
  // Computes all nets from the boards' outputs.
  void eval();

 private:
  struct Verilated;
  const VerilatedContext &context_;
  const std::unique_ptr<Verilated> model_;
};

// Which cards an address selects. The decoder of a card is Verilated by itself, and
// evaluated once for each address; its answers are kept.
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
