/* SPDX-License-Identifier: Apache-2.0 */
/* Integer arithmetic of servo.c: ranges of 32-bit numbers, and 64-bit sums that saturate. */
#ifndef SERVO_MATH_H
#define SERVO_MATH_H

#include <stdint.h>

/* Out of the way of the usual path. */
#define RARE __attribute__((noinline))

static inline uint32_t magnitude(int32_t v) {
  return v < 0 ? 0u - (uint32_t)v : (uint32_t)v;
}

/* 1 if -bound <= v < bound. */
static inline int is_within(int32_t v, uint32_t bound) {
  return (uint32_t)v + bound < 2 * bound;
}

static inline int fits(int64_t v) {
  return v == (int32_t)v;
}

static inline int32_t sat32(int64_t v) {
  if (v > INT32_MAX) return INT32_MAX;
  if (v < INT32_MIN) return INT32_MIN;
  return (int32_t)v;
}

static inline int64_t sat_add(int64_t a, int64_t b) {
  int64_t sum;
  if (__builtin_add_overflow(a, b, &sum)) return a < 0 ? INT64_MIN : INT64_MAX;
  return sum;
}

static inline int64_t sat_sub(int64_t a, int64_t b) {
  int64_t difference;
  if (__builtin_sub_overflow(a, b, &difference)) return a < 0 ? INT64_MIN : INT64_MAX;
  return difference;
}

static inline int64_t sat_mul(int64_t a, int64_t b) {
  int64_t product;
  if (__builtin_mul_overflow(a, b, &product)) {
    return (a < 0) == (b < 0) ? INT64_MAX : INT64_MIN;
  }
  return product;
}

/* n / d truncated toward zero, and the remainder; a 32-bit division whenever that is enough,
 * because 64-bit ones are subroutines on the processors this runs on. */
static inline int64_t divide(int64_t n, int32_t d, int32_t *remainder) {
  *remainder = 0;
  if (d == 1) return n;
  if (d == -1) return n == INT64_MIN ? INT64_MAX : -n;
  if (fits(n)) {
    *remainder = (int32_t)n % d;
    return (int32_t)n / d;
  }
  int64_t quotient = n / d;
  *remainder = (int32_t)(n - quotient * d);
  return quotient;
}

#endif
