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

// Each bit has a pattern of its own over the sets, and so has its inverse. Of a counter, some set
// has a low digit of 0, and all are clear of its margin: one that counts in another way shows.
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
  for (size_t f = 0; f < fields_.size(); ++f) {
    const DataField &field = fields_[f];
    if (field.output) continue;
    const auto before = sources_;
    for (;;) {
      for (auto &set : patterns_) set[f] = 0;
      for (uint8_t bit = 0; field.mask >> bit & 1; ++bit) {
        uint32_t pattern = 0;
        do {
          pattern = next() & kAll;
          // a carry from the low byte shows, up in one set and down in another
          if (field.counter && field.mask > 0xFF && bit < 8) pattern = (pattern | 1) & ~2u;
        } while (sources_.count(pattern));
        sources_[pattern] = {static_cast<uint8_t>(f), bit, false, false};
        sources_[~pattern & kAll] = {static_cast<uint8_t>(f), bit, true, false};
        for (int s = 0; s < kPatterns; ++s) {
          patterns_[static_cast<size_t>(s)][f] |= (pattern >> s & 1) << bit;
        }
        if (bit == 31) break;
      }
      bool clear = true, digit_0 = !field.counter;
      for (auto &set : patterns_) {
        digit_0 = digit_0 || (set[f] & 0xF) == 0;
        clear = clear && (field.margin < 0 || set[f] > static_cast<uint32_t>(field.margin) + 4);
      }
      if (clear && digit_0) break;
      sources_ = before;
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

// Where the bits of a field came from in a step.
struct Cache::Origin {
  std::map<std::pair<uint8_t, uint8_t>, uint32_t> terms;  // by field and rotation: which bits
  uint32_t keep = 0, value = 0;                           // as in Copy
  uint32_t constant = 0;                                  // bits that are constants
};

// By their patterns; false: some bit has none that a bit had before.
bool Cache::find_origin(size_t f, const std::vector<Observation> &seen, Origin *origin) const {
  for (int bit = 0; bit < 32 && fields_[f].mask >> bit & 1; ++bit) {
    uint32_t pattern = 0;
    for (size_t s = 0; s < seen.size(); ++s) pattern |= (seen[s].after[f] >> bit & 1) << s;
    const auto found = sources_.find(pattern);
    if (found == sources_.end()) return false;
    const Source &source = found->second;
    const uint32_t here = 1u << bit;
    if (source.constant) {
      origin->constant |= here;
    } else if (source.field == f && source.bit == bit && !source.inverted) {
      origin->keep |= here;
    } else {
      origin->terms[{source.field, static_cast<uint8_t>((bit - source.bit) & 31)}] |= here;
    }
    if (source.inverted) origin->value |= here;
  }
  return true;
}

bool Cache::derive(const std::vector<Observation> &seen, uint32_t fixed, bool clock,
                   Draft *t) const {
  uint32_t counted = 0, copied_from = 0;
  const auto in_all = [&](auto f) { return std::all_of(seen.begin(), seen.end(), f); };
  // Outputs before the registers that they follow.
  std::vector<size_t> order;
  for (size_t f = fields_.size(); f-- > 0;) order.push_back(f);
  std::stable_partition(order.begin(), order.end(), [this](size_t f) { return fields_[f].output; });
  for (size_t f : order) {
    const DataField &field = fields_[f];
    const uint8_t to = static_cast<uint8_t>(f);
    if (field.input) continue;
    const bool same = in_all([f](const Observation &s) { return s.before[f] == s.after[f]; });
    if (same && (clock || !field.output)) continue;
    const uint32_t by = (seen[0].after[f] - seen[0].before[f]) & field.mask;
    if (field.counter && !(fixed >> f & 1) && in_all([&](const Observation &s) {
          return ((s.after[f] - s.before[f]) & field.mask) == by;
        })) {
      t->counts.push_back({to, static_cast<int8_t>(field.margin), by, field.mask});
      counted |= 1u << f;
      t->near_margin = t->near_margin || field.margin >= 0;
      continue;
    }
    Origin origin;
    if (!find_origin(f, seen, &origin)) {
      t->computed = field.margin < 0;
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
      t->copies.push_back({to, 0, 0, ~origin.constant, origin.value & origin.constant, 0});
    for (const auto &[place, mask] : origin.terms) {
      const auto [from, left] = place;
      if (feedthrough && !fields_[from].input) continue;
      copied_from |= 1u << from;
      (feedthrough ? t->feedthroughs : t->copies)
          .push_back({to, from, left, ~mask, origin.value & mask, mask});
    }
    if (field.margin >= 0 && (origin.keep || !origin.terms.empty())) t->near_margin = true;
  }
  for (size_t f = 0; f < fields_.size(); ++f) {
    if (fields_[f].input && copied_from >> f & 1) t->sources |= 1u << f;
  }
  t->idle = clock && (copied_from & counted) == 0;
  return true;
}

}  // namespace mmcs
