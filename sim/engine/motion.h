// SPDX-License-Identifier: Apache-2.0
// Motions: what a user program writes as setpoints, as functions of time. No libm but sqrt.
#pragma once

#include <cstdint>
#include <vector>

#include "mmcs_sim.h"

namespace mmcs {

class Motion {
 public:
  explicit Motion(int axes) : axes_(static_cast<size_t>(axes)) {}

  // After those of its axis so far; table: of a TABLE, else NULL. False: there is no such axis, or
  // the table is empty.
  bool add(const mmcs_segment &segment, const double *table);
  // The value that the axis has when its first segment begins.
  void start(int axis, double value) { axes_[static_cast<size_t>(axis)].from = value; }
  // Of an axis without a motor: no.
  bool moves(int axis) const {
    const size_t n = static_cast<size_t>(axis);
    return n < axes_.size() && !axes_[n].segments.empty();
  }
  template <class A>
  void state(A &a) {
    for (Axis &axis : axes_) {
      size_t count = axis.segments.size();
      if constexpr (A::kReads) {
        a.count(count, sizeof(mmcs_segment));
        axis.segments.resize(count);
      } else {
        a(count);
      }
      for (Segment &segment : axis.segments) {
        mmcs_segment &s = segment.s;  // its table stands beside it
        for (int32_t *value : {&s.axis, &s.kind, &s.table_len}) a(*value);
        for (double *value :
             {&s.t0, &s.duration, &s.to, &s.amplitude, &s.f0, &s.f1, &s.v_max, &s.a_max})
          a(*value);
        a(segment.table);
      }
      a(axis.next);
      a(axis.from);
    }
  }
  // Value at t; t must not go back. Before the first segment: the start value.
  int32_t at(int axis, double t);

 private:
  struct Segment {
    mmcs_segment s;
    std::vector<double> table;
  };
  struct Axis {
    std::vector<Segment> segments;
    size_t next = 0;    // segments before this one have begun
    double from = 0.0;  // value at the beginning of segment next - 1, or the start value
  };
  static double value(const Segment &segment, double from, double t);

  std::vector<Axis> axes_;
};

}  // namespace mmcs
