// SPDX-License-Identifier: Apache-2.0
// What parts of one module do, cached: states, and the transitions between them. Terms:
// docs/simulator/simulator.md.
//
// Where data decide (parts.toml), a transition is found by their values: a case. To learn a
// transition, the model makes the step with kPatterns sets of values in the data fields; every bit
// has its own pattern over the sets, which shows where it goes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace mmcs {

class Part;
struct State;

constexpr int kPatterns = 16;
constexpr size_t kMostFields = 32;
constexpr size_t kMostBytes = 256;  // of control registers

// A register or port whose bits are only moved, or a counter; no part of the key.
struct DataField {
  uint32_t mask;
  int margin;  // of a counter that is part of the key from this value on down; else -1
  bool counter, input, output;
  bool decides;     // its value, in the situations that parts.toml names
  uint64_t driven;  // of an input: all ones while this control input is 0; or 0
};

// Bits of a data field that another one gets.
struct Copy {
  uint8_t to, from, left;  // fields; rotation of what is copied
  // Of the field's bits: those it keeps; constants, and what is inverted; those of the other field.
  uint32_t keep, value, mask;

  uint32_t apply(uint32_t own, uint32_t other) const {
    return (own & keep) ^ value ^ ((other << left | other >> (-left & 31)) & mask);
  }
};
// By how much a counter goes on.
struct Count {
  uint8_t field;
  int8_t margin;  // the field's
  uint32_t by, mask;
};

// A hit touches little memory: copies and counts lie right behind the transition.
struct Transition {
  uint64_t key = 0;            // the inputs that lead to it; of a case, the values that decide
  State *to = nullptr;         // null: data decide, or the model computes the step
  Transition *next = nullptr;  // another one from the same state
  union {
    State *at_margin = nullptr;  // `to` with other counters at their margin
    Transition *cases;           // where data decide
  };
  uint32_t sources = 0;  // data inputs that are copied
  uint8_t copy_count = 0, count_count = 0, feedthrough_count = 0;
  bool decided : 1;      // by data: see `cases`
  bool is_case : 1;      // one of them
  bool idle : 1;         // leads to the same state, and k of them are k counts
  bool near_margin : 1;  // a counter may come to its margin, or leave it
  bool observed : 1;     // an observed output changes
  bool moves : 1;        // it has copies or counts
  bool overlaps : 1;     // a copy reads what one before it writes

  template <class T>
  struct Span {
    const T *first, *last;
    const T *begin() const { return first; }
    const T *end() const { return last; }
  };
  Span<Copy> copies() const {
    const Copy *first = reinterpret_cast<const Copy *>(this + 1);
    return {first, first + copy_count};
  }
  Span<Count> counts() const {
    const Count *first = reinterpret_cast<const Count *>(copies().last);
    return {first, first + count_count};
  }
  // Data inputs that outputs follow without a clock: copied if the input has changed.
  Span<Copy> feedthroughs() const {
    const Copy *first = reinterpret_cast<const Copy *>(counts().last);
    return {first, first + feedthrough_count};
  }
};

// A transition before its place in memory is known.
struct Draft {
  Transition transition{};
  bool computed = false;  // a field became what no other one was: there is no such transition
  std::vector<Copy> copies;
  std::vector<Count> counts;
  std::vector<Copy> feedthroughs;
};

// Control inputs and outputs of a part, its control registers behind them, and what leads on.
struct State {
  uint64_t inputs, outputs;  // of control
  uint64_t counters;  // a byte each counter with a margin: its value, or one above the margin
  Transition *on_clock = nullptr;
  Transition *on_data = nullptr;    // when data inputs alone change
  Transition *on_inputs = nullptr;  // a list, by the new control inputs
  // Clocks from here that change no observed output; -1: not known yet, or by the data fields.
  int16_t silent_clocks = -1;
  bool then_idle = false;  // after them the part is idle
  bool idle = false;       // from now on: a clock copies nothing

  uint8_t *registers() { return reinterpret_cast<uint8_t *>(this + 1); }
};

// The data fields before and after a step of the model.
struct Observation {
  uint32_t before[kMostFields], data[kMostFields],
      after[kMostFields];  // data: inputs alone changed
};

// Where data come from in a step that is made with several sets of values: each bit has a pattern
// of its own over the sets, and its inverse the inverse pattern.
class Patterns {
 public:
  using Place = uint16_t;
  struct Bit {
    Place place;
    uint8_t bit;
    bool inverted, constant;  // a constant: 0, inverted 1
  };
  struct Origin {                                         // of the bits of a place
    std::map<std::pair<Place, uint8_t>, uint32_t> terms;  // by place and rotation: which bits
    uint32_t keep = 0, inverted = 0, constant = 0;        // bits; the second of all three kinds
  };

  // masks: the bits of each place that have a pattern. shape(place, values): changes values that
  // were drawn, one of each set; false: others are to be drawn.
  template <class F>
  Patterns(size_t sets, std::vector<uint32_t> of, F shape)
      : masks(std::move(of)), sets_(sets), values_(masks.size(), std::vector<uint32_t>(sets)) {
    bits_ = {{0, {0, 0, false, true}}, {inverse(0), {0, 0, true, true}}};
    uint64_t random = 1;
    for (size_t place = 0; place < masks.size(); ++place) {
      do {
        for (uint32_t &value : values_[place]) {
          random ^= random << 13;
          random ^= random >> 7;
          random ^= random << 17;
          value = static_cast<uint32_t>(random >> 20) & masks[place];
        }
      } while (masks[place] && !(shape(place, values_[place]) && add(place)));
    }
  }
  uint32_t value(size_t place, size_t set) const { return values_[place][set]; }

  // Of a bit of what became of a place: where it was before; null: nowhere.
  template <class Values>
  const Bit *find(const Values &values, int bit) const {
    const auto found = bits_.find(pattern(values, bit));
    return found == bits_.end() ? nullptr : &found->second;
  }
  // Of these bits of a place; false: one was nowhere.
  template <class Values>
  bool find_origin(size_t place, uint32_t mask, const Values &values, Origin *origin) const {
    for (; mask; mask &= mask - 1) {
      const int bit = __builtin_ctz(mask);
      const uint32_t here = 1u << bit;
      const Bit *from = find(values, bit);
      if (!from) return false;
      if (from->constant)
        origin->constant |= here;
      else if (from->place == place && from->bit == bit && !from->inverted)
        origin->keep |= here;
      else
        origin->terms[{from->place, static_cast<uint8_t>((bit - from->bit) & 31)}] |= here;
      if (from->inverted) origin->inverted |= here;
    }
    return true;
  }

  const std::vector<uint32_t> masks;

 private:
  uint32_t inverse(uint32_t pattern) const { return ~pattern & ((1u << sets_) - 1); }
  template <class Values>
  uint32_t pattern(const Values &values, int bit) const {
    uint32_t found = 0;
    for (size_t set = 0; set < sets_; ++set) found |= (values[set] >> bit & 1) << set;
    return found;
  }
  // False: bits of the place have patterns that there are already.
  bool add(size_t place) {
    std::map<uint32_t, Bit> own;
    for (uint32_t rest = masks[place]; rest; rest &= rest - 1) {
      const auto bit = static_cast<uint8_t>(__builtin_ctz(rest));
      const uint32_t one = pattern(values_[place], bit);
      own[one] = {static_cast<Place>(place), bit, false, false};
      own[inverse(one)] = {static_cast<Place>(place), bit, true, false};
    }
    const auto is_known = [this](const auto &known) { return bits_.count(known.first) != 0; };
    if (own.size() != 2 * static_cast<size_t>(__builtin_popcount(masks[place])) ||
        std::any_of(own.begin(), own.end(), is_known))
      return false;
    bits_.insert(own.begin(), own.end());
    return true;
  }

  const size_t sets_;
  std::vector<std::vector<uint32_t>> values_;  // of each place
  std::unordered_map<uint32_t, Bit> bits_;     // by pattern
};

class Cache {
 public:
  Cache(std::vector<DataField> fields, size_t register_bytes);

  // The state of this key, and with these outputs if they are given; made if it is new.
  State *find(const uint8_t *registers, uint64_t counters, uint64_t inputs,
              const uint64_t *outputs);
  State *make(const uint8_t *registers, uint64_t counters, uint64_t inputs, uint64_t outputs);
  Transition *add(const Draft &draft, uint64_t key);
  // The copies and counts of a transition, from what became of the patterns; false: there is none.
  // fixed: fields without a pattern, by bit.
  bool derive(const std::vector<Observation> &seen, uint32_t fixed, bool clock, Draft *draft) const;
  // The values of the fields that may decide.
  uint64_t values(const uint32_t *fields) const {
    uint64_t all = 0;
    for (size_t f : deciding_) all = all << 16 | fields[f];
    return all;
  }
  const std::vector<size_t> &deciding() const { return deciding_; }
  uint32_t pattern(int set, size_t field) const {
    return patterns_.value(field, static_cast<size_t>(set));
  }

  // The counters' share of the key.
  uint64_t counters(const uint32_t *fields) const {
    uint64_t all = 0;
    int place = 0;
    for (size_t f : margins_) {
      const uint32_t top = static_cast<uint32_t>(fields_[f].margin) + 1;
      all |= static_cast<uint64_t>(fields[f] < top ? fields[f] : top) << place;
      place += 8;
    }
    return all;
  }
  // Fields that have one value only while counters and inputs are so, by bit.
  uint32_t fixed(uint64_t counters, uint64_t inputs) const;

  bool full() const { return bytes_ > kFull; }
  void clear();

  const std::vector<DataField> &fields() const { return fields_; }
  size_t bytes() const { return bytes_; }
  size_t states() const { return states_.size(); }

 private:
  static constexpr size_t kFull = size_t{4} << 20;
  Patterns make_patterns() const;

  const std::vector<DataField> fields_;
  const size_t register_bytes_;
  std::vector<size_t> margins_, deciding_;  // fields with a margin; that decide
  const Patterns patterns_;
  // Memory that is given back as a whole.
  void *take(size_t bytes);
  static constexpr size_t kLine = 64, kChunk = size_t{1} << 16;
  std::vector<std::unique_ptr<char[]>> chunks_;
  char *free_ = nullptr;
  size_t room_ = 0;
  std::string key(const uint8_t *registers, uint64_t counters, uint64_t inputs) const;
  std::unordered_multimap<std::string, State *> states_;
  size_t bytes_ = 0;
};

}  // namespace mmcs
