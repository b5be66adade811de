// SPDX-License-Identifier: Apache-2.0
// See cache.h.

#include "cache.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

namespace mmcs {

Cache::Cache(std::vector<DataField> fields, size_t register_bytes)
    : fields_(std::move(fields)), register_bytes_(register_bytes), patterns_(make_patterns()) {
  if (fields_.size() > kMostFields) throw std::logic_error("a part with too many data fields");
  for (size_t c = 0; c < fields_.size(); ++c) {
    if (fields_[c].margin >= 0) margins_.push_back(c);
    if (!fields_[c].decides) continue;
    deciding_.push_back(c);
    if (fields_[c].mask > 0xFFFF || deciding_.size() > 4) {
      throw std::logic_error("too many data decide");
    }
  }
  if (margins_.size() > 8) throw std::logic_error("a part with too many counters");
}

// Of a counter, some set has a low digit of 0, and all are clear of its margin: one that counts in
// another way shows. So does a carry from the low byte, up in one set and down in another.
Patterns Cache::make_patterns() const {
  std::vector<uint32_t> masks;
  masks.reserve(fields_.size());
  for (const DataField &field : fields_) masks.push_back(field.output ? 0 : field.mask);
  return {kPatterns, masks, [this](size_t f, std::vector<uint32_t> &values) {
            const DataField &field = fields_[f];
            if (!field.counter) return true;
            if (field.mask > 0xFF) {
              values[0] |= 0xFF;
              values[1] &= ~0xFFu;
            }
            const auto is_clear = [&field](uint32_t value) {
              return field.margin < 0 || value > static_cast<uint32_t>(field.margin) + 4;
            };
            const auto has_digit_0 = [](uint32_t value) { return (value & 0xF) == 0; };
            return std::all_of(values.begin(), values.end(), is_clear) &&
                   std::any_of(values.begin(), values.end(), has_digit_0);
          }};
}

void *Cache::take(size_t bytes) {
  bytes = (bytes + kLine - 1) / kLine * kLine;
  if (bytes > room_) {
    chunks_.push_back(std::make_unique<char[]>(kChunk + kLine));
    const uintptr_t at = reinterpret_cast<uintptr_t>(chunks_.back().get());
    free_ = chunks_.back().get() + (kLine - at % kLine) % kLine;
    room_ = kChunk;
    bytes_ += kChunk;
  }
  char *found = free_;
  free_ += bytes;
  room_ -= bytes;
  return found;
}

std::string Cache::key(const uint8_t *registers, uint64_t counters, uint64_t inputs) const {
  std::string key(reinterpret_cast<const char *>(registers), register_bytes_);
  for (const uint64_t word : {counters, inputs})
    key.append(reinterpret_cast<const char *>(&word), sizeof word);
  return key;
}

State *Cache::find(const uint8_t *registers, uint64_t counters, uint64_t inputs,
                   const uint64_t *outputs) {
  auto [at, end] = states_.equal_range(key(registers, counters, inputs));
  for (; at != end; ++at) {
    if (!outputs || at->second->outputs == *outputs) return at->second;
  }
  return nullptr;
}

State *Cache::make(const uint8_t *registers, uint64_t counters, uint64_t inputs, uint64_t outputs) {
  if (State *known = find(registers, counters, inputs, &outputs)) return known;
  State *state = new (take(sizeof(State) + register_bytes_)) State{inputs, outputs, counters};
  std::memcpy(state->registers(), registers, register_bytes_);
  states_.emplace(key(registers, counters, inputs), state);
  return state;
}

Transition *Cache::add(const Draft &draft, uint64_t key) {
  const size_t copies = draft.copies.size() * sizeof(Copy),
               counts = draft.counts.size() * sizeof(Count),
               feedthroughs = draft.feedthroughs.size() * sizeof(Copy);
  char *at = static_cast<char *>(take(sizeof(Transition) + copies + counts + feedthroughs));
  Transition *t = new (at) Transition(draft.transition);
  t->key = key;
  t->copy_count = static_cast<uint8_t>(draft.copies.size());
  t->feedthrough_count = static_cast<uint8_t>(draft.feedthroughs.size());
  t->count_count = static_cast<uint8_t>(draft.counts.size());
  t->moves = copies != 0 || counts != 0;
  uint32_t written = 0;
  for (const Copy &c : draft.copies) {
    t->overlaps = t->overlaps || (c.mask && written >> c.from & 1);
    written |= 1u << c.to;
  }
  at += sizeof(Transition);
  if (copies) std::memcpy(at, draft.copies.data(), copies);
  if (counts) std::memcpy(at + copies, draft.counts.data(), counts);
  if (feedthroughs) std::memcpy(at + copies + counts, draft.feedthroughs.data(), feedthroughs);
  return t;
}

void Cache::clear() {
  states_.clear();
  chunks_.clear();
  room_ = bytes_ = 0;
}

uint32_t Cache::fixed(uint64_t counters, uint64_t inputs) const {
  uint32_t found = 0;
  for (size_t n = 0; n < margins_.size(); ++n) {
    if ((counters >> 8 * n & 0xFF) <= static_cast<uint64_t>(fields_[margins_[n]].margin)) {
      found |= 1u << margins_[n];
    }
  }
  for (size_t c = 0; c < fields_.size(); ++c) {
    if (fields_[c].driven && !(inputs & fields_[c].driven)) found |= 1u << c;
  }
  return found;
}

bool Cache::derive(const std::vector<Observation> &seen, uint32_t fixed, bool clock,
                   Draft *draft) const {
  Transition &t = draft->transition;
  uint32_t counted = 0, copied_from = 0;
  const auto in_all = [&](auto f) { return std::all_of(seen.begin(), seen.end(), f); };
  // Ports before the registers that they follow.
  for (size_t f = fields_.size(); f-- > 0;) {
    const DataField &field = fields_[f];
    const uint8_t to = static_cast<uint8_t>(f);
    if (field.input) continue;
    const bool same = in_all([f](const Observation &s) { return s.before[f] == s.after[f]; });
    if (same && (clock || !field.output)) continue;
    const uint32_t by = (seen[0].after[f] - seen[0].before[f]) & field.mask;
    if (field.counter && !(fixed >> f & 1) && in_all([&](const Observation &s) {
          return ((s.after[f] - s.before[f]) & field.mask) == by;
        })) {
      draft->counts.push_back({to, static_cast<int8_t>(field.margin), by, field.mask});
      counted |= 1u << f;
      t.near_margin = t.near_margin || field.margin >= 0;
      continue;
    }
    std::array<uint32_t, kPatterns> after;
    std::transform(seen.begin(), seen.end(), after.begin(),
                   [f](const Observation &s) { return s.after[f]; });
    Patterns::Origin origin;
    if (!patterns_.find_origin(f, field.mask, after, &origin)) {
      draft->computed = field.margin < 0;
      return false;
    }
    uint32_t from_inputs = 0;  // bits that come from data inputs
    for (const auto &[place, mask] : origin.terms) {
      if (fields_[place.first].input) from_inputs |= mask;
    }
    const bool feedthrough = !clock && field.output && in_all([&](const Observation &s) {
      return s.data[f] == s.after[f] && ((s.before[f] ^ s.after[f]) & ~from_inputs) == 0;
    });
    if (same && !feedthrough) continue;
    if (origin.constant && !feedthrough)
      draft->copies.push_back({to, 0, 0, ~origin.constant, origin.inverted & origin.constant, 0});
    for (const auto &[place, mask] : origin.terms) {
      const auto from = static_cast<uint8_t>(place.first);
      if (feedthrough && !fields_[from].input) continue;
      copied_from |= 1u << from;
      (feedthrough ? draft->feedthroughs : draft->copies)
          .push_back({to, from, place.second, ~mask, origin.inverted & mask, mask});
    }
    if (field.margin >= 0 && (origin.keep || !origin.terms.empty())) t.near_margin = true;
  }
  for (size_t f = 0; f < fields_.size(); ++f) {
    if (fields_[f].input && copied_from >> f & 1) t.sources |= 1u << f;
  }
  t.idle = clock && (copied_from & counted) == 0;
  return true;
}

}  // namespace mmcs
