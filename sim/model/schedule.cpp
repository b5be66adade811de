// SPDX-License-Identifier: Apache-2.0
// See schedule.h.

#include "schedule.h"

#include <algorithm>

namespace mmcs {

void Schedule::plan(size_t part, int64_t edge, int64_t now) {
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

int64_t Schedule::first(uint64_t parts) const {
  int64_t edge = kNever;
  for (; parts; parts &= parts - 1) edge = std::min(edge, at_[__builtin_ctzll(parts)]);
  return edge;
}

int64_t Schedule::first_later() {
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

uint64_t Schedule::due(int64_t t) {
  uint64_t due = next_;
  if (first_later() > t) return due;
  for (uint64_t rest = soon_; rest; rest &= rest - 1) {
    if (at_[__builtin_ctzll(rest)] <= t) due |= rest & -rest;
  }
  return due;
}

}  // namespace mmcs
