// SPDX-License-Identifier: Apache-2.0
// The models of this build, by the name of their module; and that of the card's address decoder.

#include <stdexcept>

#include "Vmark1_decode.h"
#include "board.h"
#include "glue.h"

namespace mmcs {

#define MMCS_MODEL_OF(module) \
  std::unique_ptr<Board> create_V##module(VerilatedContext &, const std::string &);
#include "models.inc"
#undef MMCS_MODEL_OF

std::unique_ptr<Board> Board::create(const std::string &module, VerilatedContext &context,
                                     const std::string &name) {
#define MMCS_MODEL_OF(known) \
  if (module == #known) return create_V##known(context, name);
#include "models.inc"
#undef MMCS_MODEL_OF
  throw std::runtime_error("no model of the board " + module);
}

struct Decoder::Verilated {
  VerilatedContext context;
  Vmark1_decode top{&context, "DECODER"};
};

Decoder::Decoder() : model_(std::make_unique<Verilated>()), known_(1 << 16) {}
Decoder::~Decoder() = default;

uint32_t Decoder::select(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n,
                         const std::vector<unsigned> &dips) {
  const uint32_t key = address << 3 | aen << 2 | ior_n << 1 | iow_n;
  Entry &entry = known_[key * 2654435761u >> 16];
  if (entry.key != key || entry.switches != switches_) {
    entry = {key, 0, switches_};
    for (size_t n = 0; n < dips.size(); ++n) {
      if (selects(address, aen, ior_n, iow_n, dips[n])) entry.cards |= 1u << n;
    }
  }
  return entry.cards;
}

void Decoder::forget() {
  ++switches_;  // to empty the table would be most of what a restore costs
}

// A card is selected if any output of its decoder differs from that without a command.
bool Decoder::selects(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n,
                      unsigned dip) {
  Vmark1_decode &d = model_->top;
  const auto outputs = [&d] {
    d.eval();
    uint64_t all = 0;
#define MMCS_DECODED(output, width) all = all << width | d.output;
#include "decoder.inc"
#undef MMCS_DECODED
    return all;
  };
  d.pc_a_i = static_cast<SData>(address & 0x3FFF);
  d.pc_aen_i = aen & 1;
  d.dip_i = dip & 15;
  d.pc_ior_ni = d.pc_iow_ni = 1;
  const uint64_t idle = outputs();
  d.pc_ior_ni = ior_n & 1;
  d.pc_iow_ni = iow_n & 1;
  return outputs() != idle;
}

}  // namespace mmcs
