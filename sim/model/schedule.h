// SPDX-License-Identifier: Apache-2.0
// The clock edges that parts need next: those of the next edge, of the next kSoon clocks, and later
// ones, as sets, since of many parts few need an edge soon.
#pragma once

#include <cstdint>

#include "part.h"

namespace mmcs {

class Schedule {
 public:
  static constexpr size_t kMostParts = 64;

  // A part needs this edge next, after edge `now`; kNever: none.
  void plan(size_t part, int64_t edge, int64_t now);
  void clear() {
    soon_ = late_ = 0;
    late_from_ = first_later_ = 0;
  }
  bool any_next() const { return next_ != 0; }
  // The first edge of the parts that do not need the next one.
  int64_t first_later();
  // The parts that need edge t, by bit.
  uint64_t due(int64_t t);

 private:
  static constexpr int64_t kSoon = 4096;

  int64_t first(uint64_t parts) const;

  uint64_t next_ = 0, soon_ = 0, late_ = 0;  // parts, by bit
  int64_t late_from_ = 0;                    // the first edge of `late_`
  int64_t first_later_ = 0;                  // 0: to be found
  int64_t at_[kMostParts] = {};              // the edge of each part in `soon_` or `late_`
};

}  // namespace mmcs
