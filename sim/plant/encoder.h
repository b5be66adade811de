// SPDX-License-Identifier: Apache-2.0
// Incremental encoder with index: motor angle in, timed pin levels out. §5.3.2
//
// A leads B while the angle grows. The disc is in state n while the angle is within half a count of
// n counts; the index is high during one state per revolution. Edges are placed inside the step by
// linear interpolation of the angle, at least min_gap clocks apart; what does not fit comes later.
#pragma once

#include <cstdint>
#include <vector>

#include "maths.h"
#include "plant.h"

namespace mmcs {

// Faults on the wires, as the inputs of the same names set them.
struct EncoderFaults {
  unsigned cut = 0, high = 0;  // bit 0 A, bit 1 B, bit 2 index: cut wires, those of them stuck high
  bool swapped = false;        // A and B exchanged
  bool no_index = false;
  double glitch_rate[3] = {0, 0, 0};  // spurious pulses per second on A, B, index
};

// All members are eight bytes wide so that the state has no padding and can be compared by bytes.
struct EncoderState {
  int64_t state;      // disc state shown on the pins
  int64_t start;      // disc state at t = 0
  int64_t turn;       // disc state within the revolution; the index is at 0
  int64_t last_edge;  // clock of the last edge, from the start of the step to come
  int64_t pins;       // levels now, bit 0 A, bit 1 B, bit 2 index
  int64_t refresh;    // 1: a fault has changed since the pins were last worked out
  int64_t noisy;      // 1: spurious pulses may come, or one is on the wires
  double slip;        // counts that the disc has slipped on the shaft
  uint64_t random;
  int64_t glitch_at[3];  // next change of a spurious pulse; kNever
  int64_t glitch_on[3];  // 1 while a wire is inverted
};

class Encoder {
 public:
  Encoder() = default;
  Encoder(const mmcs_motor &motor, int axis, int clks_per_step, int min_gap);

  EncoderState initial(double motor_angle, uint64_t seed) const;
  // Whether some machine holds this, at this angle of the motor.
  // Moves the shaft from one angle to the next during one step; inserts the edges by clock.
  void step(EncoderState &s, const EncoderFaults &f, double from, double to,
            std::vector<PinEdge> &edges) const {
    const double c1 = to * counts_per_rad_ + offset_ + s.slip;
    const int64_t target = nearest(c1);
    if (target != s.state || s.refresh != 0 || s.noisy != 0) {
      turn(s, f, from * counts_per_rad_ + offset_ + s.slip, c1, target, edges);
    }
    s.last_edge = s.last_edge - clks_ < -min_gap_ ? -min_gap_ : s.last_edge - clks_;
    if (s.noisy != 0) end_glitches(s, f);
  }

 private:
  static int64_t nearest(double x) { return floor_int(x + 0.5); }
  // From count c0 to c1, which is the disc's state `target`.
  void turn(EncoderState &s, const EncoderFaults &f, double c0, double c1, int64_t target,
            std::vector<PinEdge> &edges) const;
  int64_t pins_of(const EncoderState &s, const EncoderFaults &f) const;
  void start_glitches(EncoderState &s, const EncoderFaults &f) const;
  void end_glitches(EncoderState &s, const EncoderFaults &f) const;

  double counts_per_rad_ = 0;
  double offset_ = 0;  // counts
  int64_t counts_per_rev_ = 4;
  bool index_ = false;
  uint8_t axis_ = 0;
  int64_t clks_ = 1;
  int64_t min_gap_ = 1;
};

}  // namespace mmcs
