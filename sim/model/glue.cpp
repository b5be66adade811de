// SPDX-License-Identifier: Apache-2.0
// See glue.h. Compiled for each number of cards, with the model that Verilator made.

#include "glue.h"

#include "Vglue.h"
#include "wires.h"

namespace mmcs {
namespace {

const std::string kTop = "GLUE";

}  // namespace

struct Glue::Verilated {
  explicit Verilated(VerilatedContext *context) : top(context, kTop.c_str()) {}
  Vglue top;
};

Glue::Glue(VerilatedContext &context)
    : context_(context), model_(std::make_unique<Verilated>(&context)) {}
Glue::~Glue() = default;

Net Glue::board_output(const std::string &board, const std::string &port) const {
  return find_net(context_, scope_of(kTop + ".mmcs", board), port);
}

Net Glue::net(const std::string &name) const {
  return find_net(context_, kTop + ".mmcs", name);
}

void Glue::eval() {
  model_->top.eval();
}

}  // namespace mmcs
