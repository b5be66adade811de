// SPDX-License-Identifier: Apache-2.0
// The models of this build, by the name of their module; and the decoder's, which has no registers.

#include <stdexcept>

#include "Vmark1_decode.h"
#include "board.h"
#include "ears.h"

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

struct Ears::Decoder {
  VerilatedContext context;
  Vmark1_decode top{&context, "EARS"};
};

Ears::Ears() : decoder_(std::make_unique<Decoder>()), known_(1 << 16) {}
Ears::~Ears() = default;

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

bool Ears::hears(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n, unsigned dip) {
  Vmark1_decode &d = decoder_->top;
  const auto said = [&d] {
    d.eval();
    uint64_t all = 0;  // everything that a decoder says, as one number to compare
#define MMCS_SAYS(output, width) all = all << width | d.output;
#include "decoder.inc"
#undef MMCS_SAYS
    return all;
  };
  d.pc_a_i = static_cast<SData>(address & 0x3FFF);
  d.pc_aen_i = aen & 1;
  d.dip_i = dip & 15;
  d.pc_ior_ni = d.pc_iow_ni = 1;
  const uint64_t silent = said();
  d.pc_ior_ni = ior_n & 1;
  d.pc_iow_ni = iow_n & 1;
  return said() != silent;
}

}  // namespace mmcs
