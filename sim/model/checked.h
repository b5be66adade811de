// SPDX-License-Identifier: Apache-2.0
// The machine as a whole and its parts beside it, doing the same: parts with postponed clocks are
// compared with the machine at every clock. The first difference is a failed assertion.
#pragma once

#include "plain.h"
#include "rack.h"

namespace mmcs {

class Checked final : public Plain {
 public:
  Checked(uint64_t seed, const std::string &card) : Plain(seed, card), rack_(true, seed, card) {
    rack_.check(kChecked);
    pins_.also(&rack_.pins());
  }

  Stop run(int64_t n, int dtack, int64_t *ran) override;
  bool bus_cycle(const BusRequest &request, BusReply *reply) override;
  void upset(int reg, uint64_t bits) override;
  void upset_card(size_t reg, uint64_t bits) override {
    Plain::upset_card(reg, bits);
    rack_.upset_card(reg, bits);
  }
  void restore(const std::vector<uint8_t> &state) override;
  std::vector<CacheFigures> cache_figures() const override { return rack_.cache_figures(); }

 private:
  static constexpr int kChecked = 64;
  void compare();

  Rack rack_;
  bool alone_ = false;  // the machine goes on without its parts
  unsigned runs_ = 0;
};

}  // namespace mmcs
