// SPDX-License-Identifier: Apache-2.0
// See unit.h.

#include "unit.h"

#include <algorithm>

namespace mmcs {
Words::Word &Words::at(size_t offset) {
  auto found = std::find_if(words_.begin(), words_.end(),
                            [offset](const Word &w) { return w.offset >= offset; });
  if (found == words_.end() || found->offset != offset) {
    found = words_.insert(found, Word{{0, 0}, {0, 0}, offset});
  }
  return *found;
}

void Words::add(const char *base, const Net &net) {
  for (int n = 0; n < net.bytes; ++n) {
    const size_t byte = static_cast<size_t>(net.at - base) + static_cast<size_t>(n);
    at(byte & ~size_t{15}).mask[byte % 16 / 8] |= uint64_t{0xFF} << 8 * (byte % 8);
  }
}

void Unit::count(int64_t clocks) {
  for (Counter &c : counters) {
    if (c.delta == 0) continue;
    c.kept = (c.kept - c.delta * static_cast<uint64_t>(clocks)) & c.net.mask();
    c.net.put(c.kept);
  }
  if (room_ != kNever) room_ -= clocks;
  stale = true;
}

// True if each stood or went down by a stride; then room_ is how often it may.
bool Unit::look_at_counters() {
  bool still = true;
  moving_ = false;
  for (Counter &c : counters) {
    const uint64_t now = c.net.get();
    const uint64_t before = c.kept;
    c.delta = (before - now) & c.net.mask();
    c.kept = now;
    if (c.delta == 0) continue;
    // Down by a stride, not through 0.
    const bool regular = before > now && (c.delta == c.strides[0] || c.delta == c.strides[1]) &&
                         !(c.unless && c.unless.get() != 0);
    if (!regular || now <= c.margin) {
      still = false;
      c.delta = 0;
      continue;
    }
    moving_ = true;
    room_ = std::min(room_, static_cast<int64_t>((now - c.margin) / c.delta));
  }
  return still;
}

void Unit::renew(int64_t t) {
  known_ = moving_ = false;
  last_ = t;
  due = t + 1;
  for (Counter &c : counters) {
    c.kept = c.net.get();
    c.delta = 0;
  }
}

void Unit::poke() {
  bool changed = false;
  for (const Poke &p : pokes) {
    const uint64_t before = p.net.get(), after = (before & ~p.clear) | p.set;
    changed = changed || before != after;
    p.net.put(after);
  }
  if (changed) model->settle();
}

}  // namespace mmcs
