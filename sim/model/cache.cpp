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

uint64_t hash_of(const uint8_t *bytes, size_t size, uint64_t near, uint64_t in) {
  uint64_t hash = 0x9E3779B97F4A7C15ull ^ near;
  const auto mix = [&hash](uint64_t word) {
    hash = (hash ^ word) * 0xFF51AFD7ED558CCDull;
    hash ^= hash >> 32;
  };
  mix(in);
  for (size_t n = 0; n < size; n += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + n, size - n < 8 ? size - n : 8);
    mix(word);
  }
  return hash;
}

}  // namespace

Cache::Cache(std::vector<Cell> cells, size_t register_bytes)
    : cells_(std::move(cells)), register_bytes_(register_bytes) {
  if (cells_.size() > kMostCells) throw std::logic_error("a part with too many data registers");
  for (size_t c = 0; c < cells_.size(); ++c) {
    if (cells_[c].margin >= 0) margins_.push_back(c);
    if (!cells_[c].decides) continue;
    deciding_.push_back(c);
    if (cells_[c].mask > 0xFFFF || deciding_.size() > 4) {
      throw std::logic_error("too many data decide");
    }
  }
  if (margins_.size() > 8) throw std::logic_error("a part with too many counters");
  make_marks();
}

// Each bit has a pattern of its own over the sets, and so has its inverse.
void Cache::make_marks() {
  uint64_t random = 1;
  const auto next = [&random] {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    return static_cast<uint32_t>(random >> 20);
  };
  constexpr uint32_t kAll = (1u << kMarks) - 1;
  marks_.assign(kMarks, std::vector<uint32_t>(cells_.size()));
  sources_ = {{0, {0, 0, false, true}}, {kAll, {0, 0, true, true}}};
  for (size_t c = 0; c < cells_.size(); ++c) {
    if (cells_[c].out) continue;
    const auto begun = sources_;
    for (;;) {
      bool far = true,
           ends = !cells_[c].counter;  // a digit at its end: what counts otherwise shows
      for (auto &set : marks_) set[c] = 0;
      for (uint8_t bit = 0; cells_[c].mask >> bit & 1; ++bit) {
        uint32_t pattern = 0;
        do {
          pattern = next() & kAll;
          // a carry from the low byte shows, up in one set and down in another
          if (cells_[c].counter && cells_[c].mask > 0xFF && bit < 8) pattern = (pattern | 1) & ~2u;
        } while (sources_.count(pattern));
        sources_[pattern] = {static_cast<uint8_t>(c), bit, false, false};
        sources_[~pattern & kAll] = {static_cast<uint8_t>(c), bit, true, false};
        for (int s = 0; s < kMarks; ++s) {
          marks_[static_cast<size_t>(s)][c] |= (pattern >> s & 1) << bit;
        }
        if (bit == 31) break;
      }
      for (auto &set : marks_) {
        ends = ends || (set[c] & 0xF) == 0;
        far = far && (cells_[c].margin < 0 || set[c] > static_cast<uint32_t>(cells_[c].margin) + 4);
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

State *Cache::find(const uint8_t *registers, uint64_t near, uint64_t in, const uint64_t *out) {
  const auto range = states_.equal_range(hash_of(registers, register_bytes_, near, in));
  for (auto at = range.first; at != range.second; ++at) {
    State &s = *at->second;
    if (s.in == in && s.near == near && (!out || s.out == *out) &&
        !std::memcmp(s.registers(), registers, register_bytes_)) {
      return &s;
    }
  }
  return nullptr;
}

State *Cache::make(const uint8_t *registers, uint64_t near, uint64_t in, uint64_t out) {
  if (State *known = find(registers, near, in, &out)) return known;
  State *state = new (take(sizeof(State) + register_bytes_)) State{in, out, near};
  std::memcpy(state->registers(), registers, register_bytes_);
  states_.emplace(hash_of(registers, register_bytes_, near, in), state);
  return state;
}

Transition *Cache::add(const Draft &draft, uint64_t in, State *to) {
  const size_t copies = draft.copies.size() * sizeof(Copy),
               counts = draft.counts.size() * sizeof(Count),
               shown = draft.shown.size() * sizeof(Copy);
  char *at = static_cast<char *>(take(sizeof(Transition) + copies + counts + shown));
  Transition *t = new (at) Transition{};
  t->in = in;
  t->to = to;
  t->sources = draft.sources;
  t->rests = draft.rests;
  t->near = draft.near;
  t->tells = draft.tells;
  t->copy_count = static_cast<uint8_t>(draft.copies.size());
  for (const Copy &c : draft.copies) t->out_count += cells_[c.to].out;
  t->shown_count = static_cast<uint8_t>(draft.shown.size());
  t->count_count = static_cast<uint8_t>(draft.counts.size());
  t->moves = copies != 0 || counts != 0;
  uint32_t written = 0;
  for (const Copy &c : draft.copies) {
    t->swaps = t->swaps || (c.mask && written >> c.from & 1);
    written |= 1u << c.to;
  }
  at += sizeof(Transition);
  if (copies) std::memcpy(at, draft.copies.data(), copies);
  if (counts) std::memcpy(at + copies, draft.counts.data(), counts);
  if (shown) std::memcpy(at + copies + counts, draft.shown.data(), shown);
  return t;
}

void Cache::clear() {
  states_.clear();
  chunks_.clear();
  room_ = bytes_ = 0;
}

uint32_t Cache::fixed(uint64_t near, uint64_t in) const {
  uint32_t found = 0;
  for (size_t n = 0; n < margins_.size(); ++n) {
    if ((near >> 8 * n & 0xFF) <= static_cast<uint64_t>(cells_[margins_[n]].margin)) {
      found |= 1u << margins_[n];
    }
  }
  for (size_t c = 0; c < cells_.size(); ++c) {
    if (cells_[c].driven && !(in & cells_[c].driven)) found |= 1u << c;
  }
  return found;
}

bool Cache::explain(const std::vector<Seen> &seen, uint32_t fixed, bool clock, Draft *t) const {
  uint32_t counted = 0, looked = 0;
  const auto all = [&](auto f) {
    for (const Seen &s : seen) {
      if (!f(s)) return false;
    }
    return true;
  };
  // Outputs before the registers that they show.
  std::vector<size_t> order;
  for (size_t c = cells_.size(); c-- > 0;) order.push_back(c);
  std::stable_partition(order.begin(), order.end(), [this](size_t c) { return cells_[c].out; });
  for (size_t c : order) {
    const Cell &cell = cells_[c];
    if (cell.in) continue;
    const bool stands = all([c](const Seen &s) { return s.before[c] == s.after[c]; });
    if (stands && (clock || !cell.out)) continue;
    const uint32_t by = (seen[0].after[c] - seen[0].before[c]) & cell.mask;
    if (cell.counter && !(fixed >> c & 1) &&
        all([&](const Seen &s) { return ((s.after[c] - s.before[c]) & cell.mask) == by; })) {
      t->counts.push_back(
          {static_cast<uint8_t>(c), static_cast<int8_t>(cell.margin), by, cell.mask});
      counted |= 1u << c;
      t->near = t->near || cell.margin >= 0;
      continue;
    }
    std::map<std::pair<int, int>, uint32_t> terms;  // by cell and rotation: which bits
    uint32_t keep = 0, value = 0, constant = 0;
    bool carried = true;
    for (int bit = 0; bit < 32 && cell.mask >> bit & 1; ++bit) {
      uint32_t pattern = 0;
      for (size_t s = 0; s < seen.size(); ++s) pattern |= (seen[s].after[c] >> bit & 1) << s;
      const auto found = sources_.find(pattern);
      carried = carried && found != sources_.end();
      if (!carried) break;
      const Source &source = found->second;
      const uint32_t here = 1u << bit;
      if (source.constant) {
        constant |= here;
        value |= source.flip ? here : 0;
      } else if (source.cell == c && source.bit == bit && !source.flip) {
        keep |= here;
      } else {
        const int left = (bit - source.bit) & 31;
        terms[{source.cell, left}] |= here;
        value |= source.flip ? here : 0;
      }
    }
    if (!carried) {
      t->computed = cell.margin < 0;
      return false;
    }
    uint32_t inputs = 0;  // which bits follow data inputs
    for (const auto &[place, mask] : terms) {
      if (cells_[static_cast<size_t>(place.first)].in) inputs |= mask;
    }
    const bool by_data = !clock && cell.out && all([c, inputs](const Seen &s) {
      return s.data[c] == s.after[c] && ((s.before[c] ^ s.after[c]) & ~inputs) == 0;
    });
    if (stands && !by_data) continue;
    const uint8_t to = static_cast<uint8_t>(c);
    if (constant && !by_data) t->copies.push_back({to, 0, 0, ~constant, value & constant, 0});
    for (const auto &[place, mask] : terms) {
      if (by_data && !cells_[static_cast<size_t>(place.first)].in) continue;
      looked |= 1u << place.first;
      auto &list = by_data ? t->shown : t->copies;
      list.push_back({to, static_cast<uint8_t>(place.first), static_cast<uint8_t>(place.second),
                      ~mask, value & mask, mask});
    }
    if (cell.margin >= 0 && (keep || !terms.empty())) t->near = true;
  }
  for (size_t c = 0; c < cells_.size(); ++c) {
    if (cells_[c].in && looked >> c & 1) t->sources |= 1u << c;
  }
  t->rests = clock && (looked & counted) == 0;
  return true;
}

}  // namespace mmcs
