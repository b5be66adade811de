// SPDX-License-Identifier: Apache-2.0
// The clock edges that parts need next: those of the next edge, and later ones, as sets.
#pragma once

#include <algorithm>
#include <cstdint>

#include "part.h"

namespace mmcs {

class Schedule {
 public:
  static constexpr size_t kMostParts = 64;

  // A part needs this edge next, after edge `now`; kNever: none.
  void plan(size_t part, int64_t edge, int64_t now) {
    const uint64_t bit = uint64_t{1} << part;
    int64_t &before = at_[part];
    if (later_ & bit) {
      if (edge == before) return;
      if (before == first_later_) first_later_ = kUnknown;
      later_ &= ~bit;
    }
    next_ &= ~bit;
    if (edge <= now + 1) {
      next_ |= bit;
    } else if (edge != kNever) {
      later_ |= bit;
      before = edge;
      first_later_ = std::min(first_later_, edge);
    }
  }
  void clear() {
    later_ = 0;
    first_later_ = kUnknown;
  }
  bool any_next() const { return next_ != 0; }
  // The first edge of the parts that do not need the next one.
  int64_t first_later() {
    if (first_later_ != kUnknown) return first_later_;
    first_later_ = kNever;
    for (uint64_t rest = later_; rest; rest &= rest - 1)
      first_later_ = std::min(first_later_, at_[__builtin_ctzll(rest)]);
    return first_later_;
  }
  // The parts that need edge t, by bit.
  uint64_t due(int64_t t) {
    uint64_t due = next_;
    if (first_later() > t) return due;
    for (uint64_t rest = later_; rest; rest &= rest - 1) {
      if (at_[__builtin_ctzll(rest)] <= t) due |= rest & -rest;
    }
    return due;
  }

 private:
  static constexpr int64_t kUnknown = INT64_MIN;

  uint64_t next_ = 0, later_ = 0;  // parts, by bit
  int64_t first_later_ = kNever;   // or kUnknown
  int64_t at_[kMostParts] = {};    // the edge of each part in `later_`
};

}  // namespace mmcs
