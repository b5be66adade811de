// SPDX-License-Identifier: Apache-2.0
// The models of this build, by the name of their module.

#include <stdexcept>

#include "board.h"

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

}  // namespace mmcs
