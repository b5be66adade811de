// SPDX-License-Identifier: Apache-2.0
// The machine as a whole and its parts beside it, doing the same: parts with postponed clocks are
// compared with the machine at every clock. The first difference is a failed assertion.

#include "plain.h"
#include "rack.h"

namespace mmcs {
namespace {

// Runs between two comparisons of all registers: a comparison makes the postponed clocks, of which
// there are to be many sometimes.
constexpr unsigned kEvery = 64;

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

}  // namespace

Stop Checked::run(int64_t n, int dtack, int64_t *ran) {
  const Stop stop = Plain::run(n, dtack, ran);
  int64_t also = 0;
  if (stop == Stop::kFailed || !failure_.empty() || alone_) return stop;
  const Stop other = rack_.run(*ran, dtack, &also);
  if (also != *ran || (other != stop && *ran == n)) {
    failure_ = "the boards stop after " + std::to_string(also) + " clocks, the machine after " +
               std::to_string(*ran);
  } else if (rack_.lines() != lines_ || rack_.dtack() != Plain::dtack()) {
    failure_ = "the boards have other lines than the machine";
  } else if (++runs_ % kEvery == 0) {
    compare();
  }
  return failure_.empty() ? stop : Stop::kFailed;
}

// The parts make it as one step, the machine clock by clock.
bool Checked::bus_cycle(const BusRequest &request, BusReply *reply) {
  BusReply parts;
  if (!rack_.bus_cycle(request, &parts)) return false;
  pins_.also(nullptr);
  alone_ = true;
  *reply = clock_by_clock(request);
  alone_ = false;
  pins_.also(&rack_.pins());
  if (!failure_.empty()) return true;
  if (reply->data != parts.data || reply->answered != parts.answered || reply->end != parts.end ||
      rack_.lines() != lines_) {
    failure_ = "a bus cycle as one step differs from the machine's";
  } else if (++runs_ % kEvery == 0) {
    compare();
  }
  return true;
}

void Checked::compare() {
  for (size_t n = 0; n < registers().size(); ++n) {
    const int reg = static_cast<int>(n);
    if (rack_.read(reg) != read(reg)) {
      failure_ = "postponed clocks: " + registers()[n].name + " is " +
                 std::to_string(rack_.read(reg)) + ", in the machine " + std::to_string(read(reg));
      return;
    }
  }
  for (size_t reg = 0; own_card() && reg < own_card()->size(); ++reg) {
    if (rack_.own_card()->read(reg) == own_card()->read(reg)) continue;
    failure_ = "postponed clocks: " + own_card()->name(reg) + " of the own card differs";
  }
}

void Checked::upset(int reg, uint64_t bits) {
  Plain::upset(reg, bits);
  rack_.upset(reg, bits);
}

void Checked::restore(const std::vector<uint8_t> &state) {
  Plain::restore(state);
  rack_.restore(state);
}

std::unique_ptr<Model> Model::create(bool, uint64_t seed, const std::string &card) {
  return std::make_unique<Checked>(seed, card);
}

}  // namespace mmcs
