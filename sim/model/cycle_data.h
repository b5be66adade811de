// SPDX-License-Identifier: Apache-2.0
// Data while a cycle is worked out (cycle_trace.cpp).
//
//   Values     of one place: those of Patterns at once, and the actual one. Each bit of the begin
//              of the cycle has its own pattern over them, which shows where the bit goes
//   CycleData  the values of all places; conditions under which what was found holds
#pragma once

#include <algorithm>
#include <array>
#include <exception>
#include <map>
#include <vector>

#include "cycle.h"

namespace mmcs {

struct NoTrace : std::exception {};  // is thrown

inline uint32_t low_bits(int width) {
  return width >= 32 ? ~0u : (1u << width) - 1;
}

struct Values : std::array<uint32_t, kSets + 1> {
  static Values of(uint32_t constant) {
    Values values;
    values.fill(constant);
    return values;
  }
  uint32_t actual() const { return back(); }
  // The bits that are not alike in all.
  uint32_t varying() const {
    uint32_t found = 0;
    for (const uint32_t value : *this) found |= value ^ front();
    return found;
  }
  // These bits, of other values.
  void put(const Values &other, uint32_t mask) {
    for (size_t n = 0; n < size(); ++n) (*this)[n] = ((*this)[n] & ~mask) | (other[n] & mask);
  }
  Values rotated(int left) const {
    Values values;
    for (size_t n = 0; n < size(); ++n)
      values[n] = (*this)[n] << (left & 31) | (*this)[n] >> (-left & 31);
    return values;
  }
};

class CycleData {
 public:
  struct Entry {
    Values values;
    bool counted;  // since the cycle began
  };
  CycleData(const uint32_t *data, const Patterns &patterns) : data_(data), patterns_(patterns) {}

  // When the cycle begins. Counters with a margin have no patterns: one more in odd sets.
  Values start(size_t place) const {
    const uint32_t mask = patterns_.masks[place], actual = data_[place];
    Values values;
    for (size_t set = 0; set < kSets; ++set)
      values[set] = mask ? patterns_.value(place, set) : actual + (set & 1);
    values.back() = actual;
    return values;
  }
  Entry &at(size_t place) {
    const auto found = entries_.lower_bound(place);
    if (found != entries_.end() && found->first == place) return found->second;
    return entries_.insert(found, {place, {start(place), false}})->second;
  }
  uint32_t actual(size_t place) const {
    const auto found = entries_.find(place);
    return found == entries_.end() ? data_[place] : found->second.values.actual();
  }
  // To be copied: not a counter that has counted.
  const Values &copied(size_t place) {
    const Entry &entry = at(place);
    if (entry.counted) throw NoTrace{};
    return entry.values;
  }
  // Bits of a net that begins at this place.
  Values bits(size_t place, int lsb, int width) {
    place += static_cast<size_t>(lsb / 32);
    const int shift = lsb & 31;
    Values found = at(place).values.rotated(-shift);
    if (shift + width > 32)
      found.put(at(place + 1).values.rotated(-shift), low_bits(shift) << (32 - shift));
    found.put(Values::of(0), ~low_bits(width));
    return found;
  }
  void put_bits(size_t place, int lsb, int width, const Values &value) {
    place += static_cast<size_t>(lsb / 32);
    const int shift = lsb & 31;
    const Values moved = value.rotated(shift);
    at(place).values.put(moved, low_bits(width) << shift);
    if (shift + width > 32) at(place + 1).values.put(moved, low_bits(shift + width - 32));
  }
  void count(size_t place, uint32_t by, uint32_t mask) {
    Entry &entry = at(place);
    entry.counted = entry.counted || entry.values.varying() != 0;
    for (uint32_t &value : entry.values) value = (value + by) & mask;
  }
  // The values decide: all holds for the actual one.
  uint32_t decided(const Values &values) {
    for (uint32_t rest = values.varying(); rest; rest &= rest - 1) {
      const Patterns::Bit *from = patterns_.find(values, __builtin_ctz(rest));
      if (!from || from->constant) throw NoTrace{};
      const auto same = [from](const Trace::Condition &c) { return c.place == from->place; };
      auto at = std::find_if(conditions.begin(), conditions.end(), same);
      if (at == conditions.end()) at = conditions.insert(at, {from->place, 0, 0});
      at->mask |= 1u << from->bit;
      at->value = data_[from->place] & at->mask;
    }
    return values.actual();
  }
  const std::map<size_t, Entry> &all() const { return entries_; }

  std::vector<Trace::Condition> conditions;

  // What a place has then, by where its bits come from; as a constant if it can be one.
  void add_move(size_t place, const Values &now, bool of_event, Trace *trace) const {
    const uint32_t varying = now.varying();
    Patterns::Origin origin;
    if (!patterns_.find_origin(place, varying, now, &origin) || origin.constant) throw NoTrace{};
    const uint32_t constant = (now.front() & ~varying) | origin.inverted;
    const auto to = static_cast<Place>(place);
    const auto terms = static_cast<uint16_t>(origin.terms.size());
    for (const auto &[from, mask] : origin.terms)
      trace->terms.push_back({from.first, from.second, mask});
    if (terms == 0 && !of_event)
      trace->constants.push_back({to, origin.keep, constant});
    else
      trace->moves.push_back({to, terms, origin.keep, constant});
  }

 private:
  const uint32_t *const data_;
  const Patterns &patterns_;
  std::map<size_t, Entry> entries_;  // of places that were read or written
};

}  // namespace mmcs
