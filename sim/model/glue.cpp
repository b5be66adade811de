// SPDX-License-Identifier: Apache-2.0
// See glue.h. Compiled for each number of cards, with the model that Verilator made. The logic has
// no clock, so after the first eval() the outputs of the boards matter to ___eval_ico alone.

#include "glue.h"

#include "Vglue.h"
#include "Vglue___024root.h"
#include "wires.h"

void Vglue___024root___eval_ico(Vglue___024root *);

namespace mmcs {
namespace {

const std::string kTop = "GLUE";

}  // namespace

struct Glue::Verilated {
  explicit Verilated(VerilatedContext *context) : top(context, kTop.c_str()) { top.eval(); }
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

void Glue::put_card(uint64_t data, bool drives, uint64_t irq) {
  model_->top.pcx_d_i = static_cast<uint8_t>(data);
  model_->top.pcx_d_oe_i = drives;
  model_->top.pcx_irq_i = static_cast<uint8_t>(irq);
}

void Glue::eval() {
  Vglue___024root *const root = model_->top.rootp;
  root->__VicoTriggered[0] = 1;
  Vglue___024root___eval_ico(root);
}

}  // namespace mmcs
