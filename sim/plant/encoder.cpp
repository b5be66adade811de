// SPDX-License-Identifier: Apache-2.0
// Incremental encoder with index, see encoder.h. §5.3.2
#include "encoder.h"

#include <algorithm>

namespace mmcs {

namespace {

constexpr int64_t kNever = INT64_C(1) << 62;

// Keeps edges in order of clock; equal clocks stay in order of arrival. Few edges: from the back.
void insert_by_clock(std::vector<PinEdge> &edges, const PinEdge &edge) {
  edges.push_back(edge);
  PinEdge *at = &edges.back(), *first = edges.data();
  for (; at > first && at[-1].clk > edge.clk; --at) *at = at[-1];
  *at = edge;
}

}  // namespace

Encoder::Encoder(const mmcs_motor &motor, int axis, int clks_per_step, int min_gap)
    : counts_per_rad_(motor.counts_per_rev / (2.0 * kPi)),
      offset_(motor.encoder_offset * counts_per_rad_),
      counts_per_rev_(motor.counts_per_rev),
      index_(motor.index_per_rev != 0),
      axis_(static_cast<uint8_t>(axis)),
      clks_(clks_per_step),
      min_gap_(min_gap) {}

EncoderState Encoder::initial(double motor_angle, uint64_t seed) const {
  EncoderState s = {};
  s.state = s.start = nearest(motor_angle * counts_per_rad_ + offset_);
  s.turn = ((s.state % counts_per_rev_) + counts_per_rev_) % counts_per_rev_;
  s.last_edge = -min_gap_;
  s.random = seed;
  std::fill(s.glitch_at, s.glitch_at + 3, kNever);
  s.pins = pins_of(s, EncoderFaults{});
  return s;
}

int64_t Encoder::pins_of(const EncoderState &s, const EncoderFaults &f) const {
  // A leads B by a quarter turn: 0, A, A and B, B.
  const auto phase = static_cast<unsigned>(s.state & 3);
  unsigned pins = phase ^ phase >> 1;
  if (f.swapped) pins = (pins & 1) << 1 | pins >> 1;
  if (index_ && !f.no_index && s.turn == 0) pins |= 4;
  for (int w = 0; w < 3; ++w) pins ^= static_cast<unsigned>(s.glitch_on[w]) << w;
  return (pins & ~f.cut) | f.high;
}

// Draws whether a spurious pulse begins in this step, and when. A pulse is 1 to 8 gaps long.
void Encoder::start_glitches(EncoderState &s, const EncoderFaults &f) const {
  for (int w = 0; w < 3; ++w) {
    if (f.glitch_rate[w] <= 0.0 || s.glitch_at[w] != kNever) continue;
    if (random_unit(s.random) >= f.glitch_rate[w] * (kStepUs * 1e-6)) continue;
    s.glitch_at[w] = floor_int(random_unit(s.random) * static_cast<double>(clks_));
  }
}

void Encoder::end_glitches(EncoderState &s, const EncoderFaults &f) const {
  s.noisy = 0;
  for (int w = 0; w < 3; ++w) {
    if (s.glitch_at[w] != kNever) s.glitch_at[w] -= clks_;
    if (s.glitch_at[w] != kNever || f.glitch_rate[w] > 0.0) s.noisy = 1;
  }
}

void Encoder::turn(EncoderState &s, const EncoderFaults &f, double c0, double c1, int64_t target,
                   std::vector<PinEdge> &edges) const {
  const auto emit = [&](int64_t clk) {
    const int64_t pins = pins_of(s, f);
    if (pins == s.pins) return;
    s.pins = pins;
    s.last_edge = clk;
    insert_by_clock(edges,
                    {static_cast<int32_t>(clk), axis_, static_cast<uint8_t>(pins & 1),
                     static_cast<uint8_t>((pins >> 1) & 1), static_cast<uint8_t>((pins >> 2) & 1)});
  };
  // A fault that was set or cleared since the last step shows at once.
  if (s.refresh != 0 && s.last_edge + min_gap_ <= 0) {
    s.refresh = 0;
    s.noisy = 1;
    emit(0);
  }
  if (s.noisy != 0) start_glitches(s, f);

  const double clks_per_count = c1 != c0 ? static_cast<double>(clks_) / (c1 - c0) : 0.0;
  while (target != s.state || s.noisy != 0) {
    int64_t clk = kNever;
    int wire = -1;
    const int64_t way = target > s.state ? 1 : -1;
    if (target != s.state) {
      // When the border to the next state is passed; at once if that was in an earlier step.
      const double border = static_cast<double>(s.state) + 0.5 * static_cast<double>(way);
      const double at = (border - c0) * clks_per_count;
      clk = at > 0.0 && at <= static_cast<double>(clks_) ? static_cast<int64_t>(at) : 0;
    }
    for (int w = 0; s.noisy != 0 && w < 3; ++w) {
      if (s.glitch_at[w] < clk) clk = s.glitch_at[w], wire = w;
    }
    clk = std::max(std::max(clk, s.last_edge + min_gap_), INT64_C(0));
    if (clk >= clks_) break;
    if (wire < 0) {
      s.state += way;
      s.turn += way;
      if (s.turn == counts_per_rev_) s.turn = 0;
      if (s.turn < 0) s.turn = counts_per_rev_ - 1;
    } else {
      s.glitch_on[wire] ^= 1;
      const auto length = static_cast<int64_t>(1 + random_bits(s.random) % 8) * min_gap_;
      s.glitch_at[wire] = s.glitch_on[wire] != 0 ? clk + length : kNever;
    }
    emit(clk);
  }
}

}  // namespace mmcs
