// SPDX-License-Identifier: Apache-2.0
// The tap: see tap.h.

#include "tap.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace mmcs {
namespace {

// Bits of a row's lines.
constexpr int32_t kPanicBit = 1, kBrakesBit = 2, kEnabledBit = 4, kStoppedBit = 8, kIrqBit = 16;

// Lights of a card (Table 5.2) that do not blink with the encoders: heartbeats, gp1, gp2.
constexpr int kHeartbeat1 = 6, kGp1 = 8;

std::string words(int axis, uint32_t fresh, uint32_t errcode) {
  static const struct {
    uint32_t flag;
    const char *text;
  } kWords[] = {{MERR_PLO, "low position limit crossed"},
                {MERR_PHI, "high position limit crossed"},
                {MERR_ILIM, "sustained current overload"},
                {MERR_PANIC, "hardware PANIC"},
                {MERR_ZINDEX, "index found"}};
  std::string out = "axis " + std::to_string(axis) + ": ";
  bool first = true;
  for (const auto &word : kWords) {
    if (!(fresh & word.flag)) continue;
    out += first ? "" : ", ";
    out += word.text;
    first = false;
  }
  if (fresh & MERR_ZINDEX) {
    out += " at count " + std::to_string(static_cast<int16_t>(errcode >> 16));
  }
  return out;
}

}  // namespace

void Tap::keep(int64_t rows, int64_t events) {
  rows_kept_ = rows;
  events_kept_ = events;
  row_ring_.assign(static_cast<size_t>(rows * row_bytes_), 0);
  event_ring_.assign(static_cast<size_t>(events), mmcs_tap_event{});
  lights_.assign(static_cast<size_t>(cards_), 0);
  params_.assign(static_cast<size_t>(axes_), mc_param{});
  errcodes_.assign(static_cast<size_t>(axes_), 0);
}

// --- what happens ------------------------------------------------------------------------------

void Tap::sample(const struct mc *mc, const Model &model, int64_t number, int64_t clock) {
  if (rows_kept_ == 0) return;
  uint8_t *row = row_ring_.data() + (rows_ % rows_kept_) * row_bytes_;
  std::memset(row, 0, static_cast<size_t>(row_bytes_));
  const auto put = [&row](const auto &value) {
    std::memcpy(row, &value, sizeof value);
    row += sizeof value;
  };
  const unsigned now = model.lines();
  const int32_t joints = std::min(mc_joints(mc), axes_);
  put(static_cast<double>(number));
  put(static_cast<double>(clock) / Model::clk_hz());
  put((now & kLinePanic ? kPanicBit : 0) | (now & kLineBrakeRelease ? kBrakesBit : 0) |
      (mc_is_enabled(mc) ? kEnabledBit : 0) | (mc_is_stopped(mc) ? kStoppedBit : 0) |
      (now & kLineIrq ? kIrqBit : 0));
  put(joints);
  for (int axis = 0; axis < axes_; ++axis) {
    if (axis >= joints) {
      row += 4 * kFields;
      continue;
    }
    static_assert(sizeof(struct mc_state) == 28, "seven fields of mc_state");
    put(*mc_state_of(mc, axis));
    put(mc_setpoint(mc, axis));
    put(mc_demand(mc, axis));
    put(static_cast<int32_t>(mc_current(mc, axis)));
  }
  for (int card = 0; card < cards_; ++card) put(static_cast<int32_t>(model.leds(card)));
  ++rows_;
}

void Tap::lines(double t, unsigned lines) {
  const unsigned changed = lines ^ lines_;
  lines_ = lines;
  if (!on()) return;
  if (changed & kLinePanic) {
    const bool high = (lines & kLinePanic) != 0;
    event(t, "panic", -1, high, high ? "PANIC goes high" : "PANIC goes low");
  }
  if (changed & kLineBrakeRelease) {
    const bool released = (lines & kLineBrakeRelease) != 0;
    event(t, "brake", -1, released, released ? "brakes released" : "brakes on");
  }
}

void Tap::lights(double t, const Model &model) {
  static const char *const kNames[] = {"heartbeat", "heartbeat", "gp1", "gp2"};
  for (int card = 0; card < cards_; ++card) {
    const unsigned now = model.leds(card);
    unsigned &known = lights_[static_cast<size_t>(card)];
    for (int bit = kHeartbeat1; ((now ^ known) >> kHeartbeat1 & 15u) != 0 && bit < kGp1 + 2;
         ++bit) {
      if (!((now ^ known) >> bit & 1u)) continue;
      const char *name = kNames[bit - kHeartbeat1];
      event(t, bit < kGp1 ? "heartbeat" : "light", 2 * card + (bit & 1), now >> bit & 1, name);
    }
    known = now;
  }
}

void Tap::errors(double t, const struct mc *mc, int axis) {
  const int32_t errcode = mc_state_of(mc, axis)->errcode;
  int32_t &known = errcodes_[static_cast<size_t>(axis)];
  const uint32_t fresh = static_cast<uint32_t>(errcode & ~known) & MERR_MASK;
  known = errcode;
  if (fresh) event(t, "error", axis, errcode, words(axis, fresh, static_cast<uint32_t>(errcode)));
}

void Tap::driver(double t, const struct mc *mc) {
  const int joints = std::min(mc_joints(mc), axes_);
  for (int axis = 0; axis < joints; ++axis) {
    errors(t, mc, axis);
    const struct mc_param &now = *mc_param_of(mc, axis);
    struct mc_param &known = params_[static_cast<size_t>(axis)];
    if (now.mode != known.mode) event(t, "mode", axis, now.mode, "");
    if (std::memcmp(&now, &known, sizeof now) != 0) event(t, "param", axis, now.mode, "");
    known = now;
  }
  const Settings now{mc_interval(mc), mc_diag(mc), mc_double_buffer(mc), joints};
  if (std::memcmp(&now, &settings_, sizeof now) != 0) event(t, "setting", -1, 0, "");
  settings_ = now;
  const int enabled = mc_is_enabled(mc), stopped = mc_is_stopped(mc);
  if (enabled != enabled_) event(t, "enabled", -1, enabled, enabled ? "enabled" : "at rest");
  if (stopped != stopped_) event(t, "stopped", -1, stopped, stopped ? "stop latched" : "no stop");
  enabled_ = enabled;
  stopped_ = stopped;
}

void Tap::event(double t, const char *kind, int axis, int32_t value, const std::string &text) {
  if (!on()) return;
  mmcs_tap_event &e = event_ring_[static_cast<size_t>(events_ % events_kept_)];
  e = {};
  e.n = events_++;
  e.t = t;
  e.axis = axis;
  e.value = value;
  std::snprintf(e.kind, sizeof e.kind, "%s", kind);
  std::snprintf(e.text, sizeof e.text, "%s", text.c_str());
}

// --- reading -----------------------------------------------------------------------------------

Tap::Read Tap::read_rows(int64_t from, int32_t every, uint8_t *buffer, int32_t limit) const {
  const int64_t oldest = std::max<int64_t>(0, rows_ - rows_kept_);
  Read read{std::max(from, oldest), std::max<int64_t>(0, oldest - from), 0};
  read.next = (read.next + every - 1) / every * every;
  for (; read.next < rows_ && read.count < limit; read.next += every, ++read.count) {
    std::memcpy(buffer + int64_t{read.count} * row_bytes_,
                row_ring_.data() + (read.next % rows_kept_) * row_bytes_,
                static_cast<size_t>(row_bytes_));
  }
  return read;
}

Tap::Read Tap::read_events(int64_t from, mmcs_tap_event *buffer, int32_t limit) const {
  const int64_t oldest = std::max<int64_t>(0, events_ - events_kept_);
  Read read{std::max(from, oldest), std::max<int64_t>(0, oldest - from), 0};
  for (; read.next < events_ && read.count < limit; ++read.next, ++read.count) {
    buffer[read.count] = event_ring_[static_cast<size_t>(read.next % events_kept_)];
  }
  return read;
}

}  // namespace mmcs
