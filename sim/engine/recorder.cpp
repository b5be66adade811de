// SPDX-License-Identifier: Apache-2.0
// The log: see recorder.h.

#include "recorder.h"

#include <cstdio>
#include <string>

#include "mmcs_sim.h"

namespace mmcs {
namespace {

constexpr uint32_t kFlags = 0xFF;  // bits 0-7 of errcode; the rest tells axis and count

uint64_t pair(int32_t a, int32_t b) {
  return (static_cast<uint64_t>(static_cast<uint32_t>(a)) << 32) | static_cast<uint32_t>(b);
}

constexpr size_t words(const char *text) {
  size_t count = 1;
  for (; *text; ++text) count += *text == ' ';
  return count;
}

}  // namespace

void Recorder::sample(const struct mc *mc, const Machine &machine) {
  const int64_t clock = sample_clock_;
  const bool keep = started() && clock >= start_clock_;
  hash_.add(static_cast<uint64_t>(clock));
  if (keep) log_.push_back(static_cast<double>(clock - start_clock_) / Model::clk_hz());
  const int joints = mc_joints(mc);
  static const struct mc_state kNone = {};
  for (int axis = 0; axis < axes_; ++axis) {
    const bool served = axis < joints;
    const struct mc_state &s = served ? *mc_state_of(mc, axis) : kNone;
    const int32_t setpoint = served ? mc_setpoint(mc, axis) : 0;
    const double angle = angles_[static_cast<size_t>(axis)];
    hash_.add(pair(setpoint, s.encnow));
    hash_.add(pair(s.vel, s.error));
    hash_.add(pair(s.inow, s.errcode));
    hash_.add(pair(s.fbnow, s.adcvai));
    hash_.add(angle);
    if (!keep) continue;
    const int32_t fields[] = {setpoint, s.encnow, s.vel, s.error, s.inow, s.errcode};
    static_assert(words(MMCS_SIM_LOG_FIELDS) == sizeof fields / sizeof *fields + 1, "and an angle");
    log_.insert(log_.end(), std::begin(fields), std::end(fields));
    log_.push_back(angle);
  }
  if (++samples_ % kCheckpointEvery == 0) {
    checkpoints_.push_back({samples_, clock, hash_.value(), machine.trail().value()});
  }
}

void Recorder::errors(Machine &machine, const struct mc *mc) {
  const int joints = mc_joints(mc);
  for (int axis = 0; axis < axes_ && axis < joints; ++axis) {
    const int32_t errcode = mc_state_of(mc, axis)->errcode;
    int32_t &known = errcodes_[static_cast<size_t>(axis)];
    if (errcode == known) continue;
    const uint32_t fresh = static_cast<uint32_t>(errcode) & ~static_cast<uint32_t>(known);
    if (fresh & kFlags) {
      char text[64];
      std::snprintf(text, sizeof text, "errcode 0x%08X", static_cast<unsigned>(errcode));
      machine.note("error", axis, text);
    }
    known = errcode;
  }
}

void Recorder::interrupt(Machine &machine, const struct mc_stats &stats) {
  static constexpr const char *kKinds[] = {"missed", "overrun", "spurious"};
  static constexpr const char *kTexts[] = {"SCLOCKs never served", "passes beyond the next SCLOCK",
                                           "interrupts without a cause"};
  const std::array<int32_t, 3> now{stats.missed, stats.overrun, stats.spurious};
  unsigned grew = 0;
  for (size_t n = 0; n < now.size(); ++n) {
    const int32_t fresh = now[n] - counts_[n];
    if (fresh <= 0) continue;  // below 0: MZEROSTATS
    grew |= 1u << n;
    if (counted_ >> n & 1u) continue;
    machine.note(kKinds[n], -1, std::to_string(fresh) + ' ' + kTexts[n]);
  }
  counts_ = now;
  counted_ = grew;
}

}  // namespace mmcs
