// SPDX-License-Identifier: Apache-2.0
// Where the bits of data come from, as a cycle goes on that is worked out (cycle_trace.cpp).
//
//   Word    bits of one place: constants, and those that places had when the cycle began
//   Words   of all places, with what counters counted; conditions under which this holds
#pragma once

#include <algorithm>
#include <exception>
#include <map>
#include <vector>

#include "cycle.h"

namespace mmcs {

struct NoTrace : std::exception {};  // is thrown

inline uint32_t rotated(uint32_t word, unsigned left) {
  return word << (left & 31) | word >> (-left & 31);
}

inline uint32_t low_bits(int width) {
  return width >= 32 ? ~0u : (1u << width) - 1;
}

struct Word {
  static constexpr size_t kMostTerms = 8;
  uint32_t constant = 0;  // and what is inverted
  size_t count = 0;
  Term terms[kMostTerms];

  const Term *begin() const { return terms; }
  const Term *end() const { return terms + count; }
  static Word of(uint32_t constant) { return {constant, 0, {}}; }
  bool operator==(const Word &other) const {
    return constant == other.constant && std::equal(begin(), end(), other.begin(), other.end());
  }
  // Rotated; these bits of it.
  Word moved(int left, uint32_t mask) const {
    Word word = of(rotated(constant, static_cast<unsigned>(left)) & mask);
    for (const Term &t : *this) {
      const uint32_t bits = rotated(t.mask, static_cast<unsigned>(left)) & mask;
      const auto turned = static_cast<uint16_t>((t.left + left) & 31);
      if (bits) word.terms[word.count++] = {t.place, turned, bits};
    }
    return word;
  }
  // Bits that it does not have.
  void add(const Word &other) {
    constant ^= other.constant;
    for (const Term &t : other) {
      const auto order = [](const Term &a) { return a.place << 5 | a.left; };
      Term *at = terms;
      while (at != end() && order(*at) < order(t)) ++at;
      if (at != end() && order(*at) == order(t)) {
        at->mask |= t.mask;
        continue;
      }
      if (count == kMostTerms) throw NoTrace{};
      std::copy_backward(at, terms + count, terms + count + 1);
      *at = t;
      ++count;
    }
  }
};

class Words {
 public:
  struct Entry {
    Word word;
    uint32_t by, mask;  // what it has counted since
  };
  // data: as it is when the cycle begins; masks: bits that each place has.
  Words(const uint32_t *data, const std::vector<uint32_t> &masks) : data_(data), masks_(masks) {}

  Word own(size_t place) const { return {0, 1, {{static_cast<Place>(place), 0, masks_[place]}}}; }
  Entry &at(size_t place) {
    const auto found = entries_.lower_bound(place);
    if (found != entries_.end() && found->first == place) return found->second;
    return entries_.insert(found, {place, {own(place), 0, 0}})->second;
  }
  const Word &word(size_t place) { return at(place).word; }
  // Bits of a net that begins at this place.
  Word bits(size_t place, int lsb, int width) {
    place += static_cast<size_t>(lsb / 32);
    const int shift = lsb & 31;
    Word found = word(place).moved(-shift, low_bits(std::min(width, 32 - shift)));
    if (shift == 0 || shift + width <= 32) return found;
    const uint32_t rest = low_bits(width) << (32 - shift) & low_bits(width);
    found.add(word(place + 1).moved(32 - shift, rest));
    return found;
  }
  void put_bits(size_t place, int lsb, int width, const Word &value) {
    place += static_cast<size_t>(lsb / 32);
    const int shift = lsb & 31;
    put(place, value.moved(shift, low_bits(width) << shift), low_bits(width) << shift);
    if (shift + width <= 32) return;
    const uint32_t rest = low_bits(shift + width - 32);
    put(place + 1, value.moved(shift, rest), rest);
  }
  // Bits of it.
  void put(size_t place, const Word &value, uint32_t mask) {
    Word &own = at(place).word;
    own = own.moved(0, ~mask);
    own.add(value.moved(0, mask));
  }
  // To be copied: not a counter that has counted.
  const Word &copied(size_t place) {
    const Word &found = word(place);
    if (std::any_of(found.begin(), found.end(), [this](const Term &t) { return counts(t); }))
      throw NoTrace{};
    return found;
  }
  void count(size_t place, uint32_t by, uint32_t mask) {
    Entry &entry = at(place);
    if (entry.word == own(place)) {
      entry.by = (entry.by + by) & (entry.mask = mask);
    } else if (entry.word.count == 0) {
      entry.word.constant = (entry.word.constant + by) & mask;
    } else {
      throw NoTrace{};
    }
  }
  uint32_t value_of(size_t place) const {
    const auto found = entries_.find(place);
    if (found == entries_.end()) return data_[place];
    const auto &[word, by, mask] = found->second;
    return by ? (value_of(word) + by) & mask : value_of(word);
  }
  // The value of a word decides: all holds for this one.
  uint32_t decided(const Word &word) {
    for (const Term &t : word) {
      if (counts(t)) throw NoTrace{};
      const auto same = [&t](const Trace::Condition &c) { return c.place == t.place; };
      auto at = std::find_if(conditions.begin(), conditions.end(), same);
      if (at == conditions.end()) at = conditions.insert(at, {t.place, 0, 0});
      at->mask |= rotated(t.mask, -unsigned{t.left});
      at->value = data_[t.place] & at->mask;
    }
    return value_of(word);
  }
  const std::map<size_t, Entry> &all() const { return entries_; }

  std::vector<Trace::Condition> conditions;

 private:
  bool counts(const Term &t) const {
    const auto found = entries_.find(t.place);
    return found != entries_.end() && found->second.by != 0;
  }
  uint32_t value_of(const Word &word) const {
    uint32_t value = word.constant;
    for (const Term &t : word) value ^= t.bits(data_);
    return value;
  }

  const uint32_t *const data_;
  const std::vector<uint32_t> &masks_;
  std::map<size_t, Entry> entries_;  // of places that are not as they were
};

}  // namespace mmcs
