// SPDX-License-Identifier: Apache-2.0
// Which machine a build has.

#include "model.h"
#if MMCS_TRACE
#include "plain.h"
#elif MMCS_PLAIN
#include "checked.h"
#else
#include "rack.h"
#endif

namespace mmcs {

std::unique_ptr<Model> Model::create([[maybe_unused]] bool skip, uint64_t seed,
                                     const std::string &card) {
#if MMCS_TRACE
  return std::make_unique<Plain>(seed, card);
#elif MMCS_PLAIN
  return std::make_unique<Checked>(seed, card);
#else
  return std::make_unique<Rack>(skip, seed, card);
#endif
}

}  // namespace mmcs
