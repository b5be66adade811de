// SPDX-License-Identifier: Apache-2.0
// The clock edges that parts need next: those of the next edge, of the next kSoon clocks, and later
// ones, as sets, since of many parts few need an edge soon.
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
    if ((soon_ | late_) & bit) {
      if (edge == before) return;
      if (before == first_later_) first_later_ = 0;
      soon_ &= ~bit;
      late_ &= ~bit;
    }
    if (edge <= now + 1) {
      next_ |= bit;
      return;
    }
    next_ &= ~bit;
    if (edge == kNever) return;
    before = edge;
    if (edge >= late_from_) {
      late_ |= bit;
      if (!soon_) first_later_ = 0;
      return;
    }
    soon_ |= bit;
    if (edge < first_later_) first_later_ = edge;
  }
  void clear() {
    soon_ = late_ = 0;
    late_from_ = first_later_ = 0;
  }
  bool any_next() const { return next_ != 0; }
  // The first edge of the parts that do not need the next one.
  int64_t first_later() {
    if (first_later_ != 0) return first_later_;
    if (!soon_ && late_) {
      late_from_ = first(late_) + kSoon;
      for (uint64_t rest = late_; rest; rest &= rest - 1) {
        if (at_[__builtin_ctzll(rest)] < late_from_) soon_ |= rest & -rest;
      }
      late_ &= ~soon_;
    }
    return first_later_ = first(soon_);
  }
  // The parts that need edge t, by bit.
  uint64_t due(int64_t t) {
    uint64_t due = next_;
    if (first_later() > t) return due;
    for (uint64_t rest = soon_; rest; rest &= rest - 1) {
      if (at_[__builtin_ctzll(rest)] <= t) due |= rest & -rest;
    }
    return due;
  }

 private:
  static constexpr int64_t kSoon = 4096;

  int64_t first(uint64_t parts) const {
    int64_t edge = kNever;
    for (; parts; parts &= parts - 1) edge = std::min(edge, at_[__builtin_ctzll(parts)]);
    return edge;
  }

  uint64_t next_ = 0, soon_ = 0, late_ = 0;  // parts, by bit
  int64_t late_from_ = 0;                    // the first edge of `late_`
  int64_t first_later_ = 0;                  // 0: to be found
  int64_t at_[kMostParts] = {};              // the edge of each part in `soon_` or `late_`
};

}  // namespace mmcs
