// SPDX-License-Identifier: Apache-2.0
// Motions: see motion.h. Only +, -, *, / and sqrt, which IEEE 754 makes the same everywhere.

#include "motion.h"

#include <cmath>

namespace mmcs {
namespace {

// sin(2 pi turns): the turn is reduced exactly, then a Taylor polynomial on a quarter turn
// (error under 1e-12).
double sin_turns(double turns) {
  double x = turns - static_cast<double>(static_cast<int64_t>(turns));
  if (x < 0) x += 1.0;
  double sign = 1.0;
  if (x >= 0.5) {
    x -= 0.5;
    sign = -1.0;
  }
  if (x > 0.25) x = 0.5 - x;
  const double a = 6.283185307179586477 * x;
  const double q = a * a;
  double sum = 1.0;
  for (int n = 8; n >= 1; --n) sum = 1.0 - sum * q / (2.0 * n * (2.0 * n + 1.0));
  return sign * a * sum;
}

// Position after t of a move over d >= 0 with speed v and acceleration a (triangle if short).
double trapezoid(double d, double v, double a, double t) {
  if (v * v / a > d) v = std::sqrt(a * d);
  if (v <= 0.0) return d;
  const double ramp = v / a;
  const double total = d / v + ramp;
  if (t >= total) return d;
  if (t < ramp) return 0.5 * a * t * t;
  if (t < total - ramp) return v * (t - 0.5 * ramp);
  const double rest = total - t;
  return d - 0.5 * a * rest * rest;
}

double table_at(const std::vector<double> &table, double tau) {
  const double position = tau * static_cast<double>(table.size() - 1);
  const size_t i = static_cast<size_t>(position);
  if (i + 1 >= table.size()) return table.back();
  return table[i] + (table[i + 1] - table[i]) * (position - static_cast<double>(i));
}

double trapezoid_move(const mmcs_segment &s, double from, double t) {
  const double way = s.to - from;
  const double d = way < 0 ? -way : way;
  // Without limits: a third of the time each for speeding up, cruising, slowing down.
  const double v = s.v_max > 0 ? s.v_max : 1.5 * d / s.duration;
  const double a = s.a_max > 0 ? s.a_max : s.duration > 0 ? 3.0 * v / s.duration : v * 1e3;
  if (d <= 0.0 || v <= 0.0) return s.to;
  const double done = trapezoid(d, v, a, t);
  return from + (way < 0 ? -done : done);
}

}  // namespace

double Motion::value(const Segment &segment, double from, double t) {
  const mmcs_segment &s = segment.s;
  double tau = s.duration > 0 ? t / s.duration : 1.0;
  if (tau > 1.0) {
    tau = 1.0;
    if (s.kind != MMCS_SEG_TRAPEZOID) t = s.duration;
  }
  switch (s.kind) {
    case MMCS_SEG_RAMP:
      return from + (s.to - from) * tau;
    case MMCS_SEG_QUINTIC:
      return from + (s.to - from) * (tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau));
    case MMCS_SEG_TRAPEZOID:
      return trapezoid_move(s, from, t);
    case MMCS_SEG_SINE:
      return s.to + s.amplitude * sin_turns(s.f0 * t);
    case MMCS_SEG_CHIRP:
      return s.to + s.amplitude * sin_turns(s.f0 * t + 0.5 * (s.f1 - s.f0) * t * tau);
    case MMCS_SEG_SQUARE: {
      const double turns = s.f0 * t;
      const double part = turns - static_cast<double>(static_cast<int64_t>(turns));
      return s.to + (part < 0.5 ? s.amplitude : -s.amplitude);
    }
    case MMCS_SEG_TABLE:
      return table_at(segment.table, tau);
    default:
      return s.to;  // HOLD, STEP
  }
}

bool Motion::add(const mmcs_segment &segment, const double *table) {
  const bool has_table = table && segment.table_len > 0;
  if (segment.axis < 0 || static_cast<size_t>(segment.axis) >= axes_.size()) return false;
  if (segment.kind == MMCS_SEG_TABLE && !has_table) return false;
  Segment kept{segment, {}};
  if (has_table) kept.table.assign(table, table + segment.table_len);
  axes_[static_cast<size_t>(segment.axis)].segments.push_back(kept);
  return true;
}

int32_t Motion::at(int axis, double t) {
  Axis &a = axes_[static_cast<size_t>(axis)];
  while (a.next < a.segments.size() && a.segments[a.next].s.t0 <= t) {
    const double begins = a.segments[a.next].s.t0;
    if (a.next > 0) {
      const Segment &before = a.segments[a.next - 1];
      a.from = value(before, a.from, begins - before.s.t0);
    }
    ++a.next;
  }
  double v = a.from;
  if (a.next > 0) {
    const Segment &now = a.segments[a.next - 1];
    v = value(now, a.from, t - now.s.t0);
  }
  if (v >= 2147483647.0) return INT32_MAX;
  if (v <= -2147483648.0) return INT32_MIN;
  return static_cast<int32_t>(v < 0 ? v - 0.5 : v + 0.5);
}

}  // namespace mmcs
