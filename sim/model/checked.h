// SPDX-License-Identifier: Apache-2.0
// The machine as a whole and its parts beside it, doing the same: parts with postponed clocks are
// compared with the machine at every clock. The first difference is a failed assertion.
#pragma once

#include "plain.h"
#include "rack.h"

namespace mmcs {

class Checked final : public Plain {
 public:
  explicit Checked(uint64_t seed) : Plain(seed), rack_(false, true, seed) {
    power_on();
    rack_.power_on();
    rack_.check(kChecked);
    pins_.also(rack_.pins());
  }

  Stop run(int64_t n, int dtack, int64_t *ran) override;
  void upset(int reg, uint64_t bits) override;
  void restore(const std::vector<uint8_t> &state) override;
  std::vector<CacheFigures> cache_figures() const override { return rack_.cache_figures(); }

 private:
  static constexpr int kChecked = 64;
  void compare();

  Rack rack_;
  unsigned runs_ = 0;
};

}  // namespace mmcs
