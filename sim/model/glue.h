// SPDX-License-Identifier: Apache-2.0
// The combinational logic of rtl/mmcs.sv between its boards: mmcs.sv Verilated with empty boards.
#pragma once

#include <memory>
#include <string>

#include "board.h"

namespace mmcs {

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

}  // namespace mmcs
