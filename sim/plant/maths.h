// SPDX-License-Identifier: Apache-2.0
// The few functions that the plant may use: the same last bit on every machine.
//
// libm's sin, cos and exp differ between C libraries in their last bit, and a run is compared by
// its hash. These use +, -, * and / only, in a fixed order; errors are below 1e-15 of the result's
// scale in the ranges that the plant needs (|x| < 1e5 for angles).
#pragma once

#include <cstdint>

namespace mmcs {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kInfinity = 1e300;  // as a bound only; never enters a sum

// Largest integer <= x, for |x| < 2^62; 0 for what is beyond, or no number.
inline int64_t floor_int(double x) {
  if (!(x > -0x1p62 && x < 0x1p62)) return 0;
  auto n = static_cast<int64_t>(x);
  return n - (static_cast<double>(n) > x ? 1 : 0);
}

// Two numbers side by side: the same operation on both at once, each with the operations, and so
// the bits, that it would get alone.
using Two = double __attribute__((vector_size(16)));

// sin and cos, side by side: on [-pi/4, pi/4] by their Taylor series, whose remainder there is
// below 2^-56; the sine's begins a term later.
inline void sin_cos(double x, double &sine, double &cosine) {
  // pi/2 in three parts of 33 bits and a rest: k times the first two is exact for |k| < 2^20.
  constexpr double kPart1 = 1.57079632673412561417e+00;
  constexpr double kPart2 = 6.07710050630396597660e-11;
  constexpr double kPart3 = 2.02226624879595063154e-21;
  const int64_t k = floor_int(x * (2.0 / kPi) + 0.5);
  const auto n = static_cast<double>(k);
  const double r = ((x - n * kPart1) - n * kPart2) - n * kPart3;
  const double z = r * r;
  const Two zz = {z, z};
  Two p = {0.0, 1.0 / 20922789888000.0};
  p = p * zz + Two{-1.0 / 1307674368000.0, -1.0 / 87178291200.0};
  p = p * zz + Two{1.0 / 6227020800.0, 1.0 / 479001600.0};
  p = p * zz + Two{-1.0 / 39916800.0, -1.0 / 3628800.0};
  p = p * zz + Two{1.0 / 362880.0, 1.0 / 40320.0};
  p = p * zz + Two{-1.0 / 5040.0, -1.0 / 720.0};
  p = p * zz + Two{1.0 / 120.0, 1.0 / 24.0};
  const double s = r + r * (z * (p[0] * z - 1.0 / 6.0));
  // 1 - z/2 loses bits; they are carried into the small term.
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  const double c = w + (((1.0 - w) - half) + z * (z * p[1]));
  const double a = (k & 1) != 0 ? c : s, b = (k & 1) != 0 ? s : c;
  sine = (k & 2) != 0 ? -a : a;
  cosine = ((k + 1) & 2) != 0 ? -b : b;
}

// exp(-x) for x >= 0: Taylor on x/2^n, then n squarings. Used once per parameter.
inline double exp_neg(double x) {
  if (x > 700.0) return 0.0;
  int n = 0;
  for (; x > 0.125; ++n) x *= 0.5;
  double e = 1.0;
  for (int i = 14; i > 0; --i) e = 1.0 - x / i * e;
  for (; n > 0; --n) e *= e;
  return e;
}

// SplitMix64: one word of state, no library whose sequence could change.
inline uint64_t random_bits(uint64_t &state) {
  uint64_t z = (state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

inline double random_unit(uint64_t &state) {  // [0, 1)
  return static_cast<double>(random_bits(state) >> 11) * 0x1p-53;
}

// Mean 0, variance 1, by the sum of twelve uniforms: bounded by +-6, no logarithm.
inline double random_normal(uint64_t &state) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += random_unit(state);
  return sum;
}

}  // namespace mmcs
