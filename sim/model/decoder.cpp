// SPDX-License-Identifier: Apache-2.0
// See ears.h: the decoder's model, and what it says.

#include "Vdecode.h"
#include "ears.h"

namespace mmcs {

struct Ears::Decoder {
  VerilatedContext context;
  Vdecode top{&context, "EARS"};
};

Ears::Ears() : decoder_(std::make_unique<Decoder>()), known_(1 << 16) {}
Ears::~Ears() = default;

bool Ears::hears(unsigned address, unsigned aen, unsigned ior_n, unsigned iow_n, unsigned dip) {
  Vdecode &d = decoder_->top;
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
