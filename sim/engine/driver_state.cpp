// SPDX-License-Identifier: Apache-2.0
// The layout of the driver's memory: see driver_state.h.

#include "driver_state.h"

#include <cstddef>

extern "C" {
#include "mc_priv.h"
}

namespace mmcs {

static_assert(offsetof(struct mc, bus) == 0 && offsetof(struct mc, os) == sizeof(struct mc_bus) &&
                  offsetof(struct mc, config) == sizeof(struct mc_bus) + sizeof(struct mc_os),
              "nothing that must be saved lies in front of the configuration");

size_t driver_state_begin() {
  return offsetof(struct mc, config);
}

namespace {

bool within(int64_t value, int64_t low, int64_t high) {
  return value >= low && value <= high;
}

bool is_possible(const struct mc_axis &x, int axis) {
  const struct mc_param &p = x.par;
  return p.which == axis && p.b0 != 0 && p.clkdivisor >= 1 && within(x.wait, 0, p.clkdivisor - 1) &&
         p.ilim >= 0 && p.ilimax >= 0 && within(p.ipole, 0, MC_FSCALE - 1) && x.code <= 0xFFF &&
         within(x.servo.filtered, -2048 * MC_FSCALE, 2048 * MC_FSCALE) && x.servo.over >= 0 &&
         within(x.servo.triangle, -SERVO_DAC_MAX - 1, SERVO_DAC_MAX + 1) && x.law.shift <= 32;
}

bool has_timers(const struct mc &mc) {
  return within(mc.n0, 2, 65536) && within(mc.n1, 2, 65536);
}

}  // namespace

bool driver_is_possible(const std::vector<uint64_t> &memory) {
  const struct mc &mc = *reinterpret_cast<const struct mc *>(memory.data());
  int opens = 0;
  for (const struct mc_client &client : mc.client) opens += client.used != 0;
  if (mc.opens != opens || !within(mc.cards, 0, MC_MAX_CARDS) || mc.axes != 2 * mc.cards)
    return false;
  int power;  // as a number: any other one is no enum mc_power
  std::memcpy(&power, &mc.power, sizeof power);
  if (!within(mc.joints, 0, mc.axes) || !within(power, MC_IDLE, MC_RUNNING)) return false;
  const uint32_t hz = mc.config.sysclk_hz;
  if (hz != 8000000 && hz != 4000000 && hz != 2000000 && hz != 1000000) return false;
  if (opens > 0 && !has_timers(mc)) return false;
  const struct mc_stats &s = mc.stats;
  for (int count : {s.total, s.missed, s.overrun, s.panics, s.spurious, s.clips, mc.adc_timeouts}) {
    if (count < 0) return false;
  }
  for (int axis = 0; axis < mc.axes; ++axis) {
    if (!is_possible(mc.axis[axis], axis)) return false;
  }
  return true;
}

bool mirror_is_possible(const std::vector<uint64_t> &memory) {
  const struct mc &mc = *reinterpret_cast<const struct mc *>(memory.data());
  int power;
  std::memcpy(&power, &mc.power, sizeof power);
  return within(mc.joints, 0, MC_MAX_AXES) && within(power, MC_IDLE, MC_RUNNING);
}

}  // namespace mmcs
