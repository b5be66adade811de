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

std::unique_ptr<Model> Model::create(bool two_evals, bool skip, uint64_t seed,
                                     const std::string &card) {
#if !MMCS_PLAIN
  auto rack = std::make_unique<Rack>(two_evals, skip, seed, card);
  rack->power_on();
  return rack;
#else
  static_cast<void>(two_evals);
  static_cast<void>(skip);
#if MMCS_TRACE
  auto plain = std::make_unique<Plain>(seed, card);
  plain->power_on();
  return plain;
#else
  return std::make_unique<Checked>(seed, card);
#endif
#endif
}

bool Model::skip() {
  return !MMCS_PLAIN;
}

bool Model::traced() {
  return MMCS_TRACE;
}

}  // namespace mmcs
