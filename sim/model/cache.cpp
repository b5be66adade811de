// SPDX-License-Identifier: Apache-2.0
// See cache.h.

#include "cache.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <new>
#include <stdexcept>
#include <utility>

namespace mmcs {
namespace {

uint64_t hash_of(const uint8_t *bytes, size_t size, uint64_t counters, uint64_t inputs) {
  uint64_t hash = 0x9E3779B97F4A7C15ull ^ counters;
  const auto mix = [&hash](uint64_t word) {
    hash = (hash ^ word) * 0xFF51AFD7ED558CCDull;
    hash ^= hash >> 32;
  };
  mix(inputs);
  for (size_t n = 0; n < size; n += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + n, size - n < 8 ? size - n : 8);
    mix(word);
  }
  return hash;
}

}  // namespace

Cache::Cache(std::vector<DataField> fields, size_t register_bytes)
    : fields_(std::move(fields)), register_bytes_(register_bytes) {
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
  make_patterns();
}

// Each bit has a pattern of its own over the sets, and so has its inverse.
void Cache::make_patterns() {
  uint64_t random = 1;
  const auto next = [&random] {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    return static_cast<uint32_t>(random >> 20);
  };
  constexpr uint32_t kAll = (1u << kPatterns) - 1;
  patterns_.assign(kPatterns, std::vector<uint32_t>(fields_.size()));
  sources_ = {{0, {0, 0, false, true}}, {kAll, {0, 0, true, true}}};
  for (size_t c = 0; c < fields_.size(); ++c) {
    if (fields_[c].output) continue;
    const auto begun = sources_;
    for (;;) {
      bool far = true,
           ends = !fields_[c].counter;  // a digit at its end: what counts otherwise shows
      for (auto &set : patterns_) set[c] = 0;
      for (uint8_t bit = 0; fields_[c].mask >> bit & 1; ++bit) {
        uint32_t pattern = 0;
        do {
          pattern = next() & kAll;
          // a carry from the low byte shows, up in one set and down in another
          if (fields_[c].counter && fields_[c].mask > 0xFF && bit < 8)
            pattern = (pattern | 1) & ~2u;
        } while (sources_.count(pattern));
        sources_[pattern] = {static_cast<uint8_t>(c), bit, false, false};
        sources_[~pattern & kAll] = {static_cast<uint8_t>(c), bit, true, false};
        for (int s = 0; s < kPatterns; ++s) {
          patterns_[static_cast<size_t>(s)][c] |= (pattern >> s & 1) << bit;
        }
        if (bit == 31) break;
      }
      for (auto &set : patterns_) {
        ends = ends || (set[c] & 0xF) == 0;
        far =
            far && (fields_[c].margin < 0 || set[c] > static_cast<uint32_t>(fields_[c].margin) + 4);
      }
      if (far && ends) break;
      sources_ = begun;
    }
  }
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

State *Cache::find(const uint8_t *registers, uint64_t counters, uint64_t inputs,
                   const uint64_t *outputs) {
  const auto range = states_.equal_range(hash_of(registers, register_bytes_, counters, inputs));
  for (auto at = range.first; at != range.second; ++at) {
    State &s = *at->second;
    if (s.inputs == inputs && s.counters == counters && (!outputs || s.outputs == *outputs) &&
        !std::memcmp(s.registers(), registers, register_bytes_)) {
      return &s;
    }
  }
  return nullptr;
}

State *Cache::make(const uint8_t *registers, uint64_t counters, uint64_t inputs, uint64_t outputs) {
  if (State *known = find(registers, counters, inputs, &outputs)) return known;
  State *state = new (take(sizeof(State) + register_bytes_)) State{inputs, outputs, counters};
  std::memcpy(state->registers(), registers, register_bytes_);
  states_.emplace(hash_of(registers, register_bytes_, counters, inputs), state);
  return state;
}

Transition *Cache::add(const Draft &draft, uint64_t key, State *to) {
  const size_t copies = draft.copies.size() * sizeof(Copy),
               counts = draft.counts.size() * sizeof(Count),
               feedthroughs = draft.feedthroughs.size() * sizeof(Copy);
  char *at = static_cast<char *>(take(sizeof(Transition) + copies + counts + feedthroughs));
  Transition *t = new (at) Transition{};
  t->key = key;
  t->to = to;
  t->sources = draft.sources;
  t->idle = draft.idle;
  t->near_margin = draft.near_margin;
  t->observed = draft.observed;
  t->copy_count = static_cast<uint8_t>(draft.copies.size());
  for (const Copy &c : draft.copies) t->output_copy_count += fields_[c.to].output;
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
                   Draft *t) const {
  uint32_t counted = 0, copied_from = 0;
  const auto in_all = [&](auto f) {
    for (const Observation &s : seen) {
      if (!f(s)) return false;
    }
    return true;
  };
  // Outputs before the registers that they follow.
  std::vector<size_t> order;
  for (size_t c = fields_.size(); c-- > 0;) order.push_back(c);
  std::stable_partition(order.begin(), order.end(), [this](size_t c) { return fields_[c].output; });
  for (size_t c : order) {
    const DataField &field = fields_[c];
    if (field.input) continue;
    const bool stands = in_all([c](const Observation &s) { return s.before[c] == s.after[c]; });
    if (stands && (clock || !field.output)) continue;
    const uint32_t by = (seen[0].after[c] - seen[0].before[c]) & field.mask;
    if (field.counter && !(fixed >> c & 1) && in_all([&](const Observation &s) {
          return ((s.after[c] - s.before[c]) & field.mask) == by;
        })) {
      t->counts.push_back(
          {static_cast<uint8_t>(c), static_cast<int8_t>(field.margin), by, field.mask});
      counted |= 1u << c;
      t->near_margin = t->near_margin || field.margin >= 0;
      continue;
    }
    std::map<std::pair<int, int>, uint32_t> terms;  // by field and rotation: which bits
    uint32_t keep = 0, value = 0, constant = 0;
    bool moved = true;
    for (int bit = 0; bit < 32 && field.mask >> bit & 1; ++bit) {
      uint32_t pattern = 0;
      for (size_t s = 0; s < seen.size(); ++s) pattern |= (seen[s].after[c] >> bit & 1) << s;
      const auto found = sources_.find(pattern);
      moved = moved && found != sources_.end();
      if (!moved) break;
      const Source &source = found->second;
      const uint32_t here = 1u << bit;
      if (source.constant) {
        constant |= here;
        value |= source.inverted ? here : 0;
      } else if (source.field == c && source.bit == bit && !source.inverted) {
        keep |= here;
      } else {
        const int left = (bit - source.bit) & 31;
        terms[{source.field, left}] |= here;
        value |= source.inverted ? here : 0;
      }
    }
    if (!moved) {
      t->computed = field.margin < 0;
      return false;
    }
    uint32_t inputs = 0;  // bits that data inputs feed through to
    for (const auto &[place, mask] : terms) {
      if (fields_[static_cast<size_t>(place.first)].input) inputs |= mask;
    }
    const bool by_data = !clock && field.output && in_all([c, inputs](const Observation &s) {
      return s.data[c] == s.after[c] && ((s.before[c] ^ s.after[c]) & ~inputs) == 0;
    });
    if (stands && !by_data) continue;
    const uint8_t to = static_cast<uint8_t>(c);
    if (constant && !by_data) t->copies.push_back({to, 0, 0, ~constant, value & constant, 0});
    for (const auto &[place, mask] : terms) {
      if (by_data && !fields_[static_cast<size_t>(place.first)].input) continue;
      copied_from |= 1u << place.first;
      auto &list = by_data ? t->feedthroughs : t->copies;
      list.push_back({to, static_cast<uint8_t>(place.first), static_cast<uint8_t>(place.second),
                      ~mask, value & mask, mask});
    }
    if (field.margin >= 0 && (keep || !terms.empty())) t->near_margin = true;
  }
  for (size_t c = 0; c < fields_.size(); ++c) {
    if (fields_[c].input && copied_from >> c & 1) t->sources |= 1u << c;
  }
  t->idle = clock && (copied_from & counted) == 0;
  return true;
}

}  // namespace mmcs
