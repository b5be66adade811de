// SPDX-License-Identifier: Apache-2.0
// A part of a board with a clock of its own in the model, and when it needs the next one.
//
// At rest: one clock with inputs that stood left all registers as they were, and each counter stood
// or moved by a stride that counters.toml declares. Then the next clock does the same, until a
// counter comes to its margin or an input changes: so many clocks are k times the stride.
#pragma once

#include <climits>
#include <cstdint>
#include <cstring>
#include <vector>

#include "board.h"

namespace mmcs {

constexpr int64_t kNever = INT64_MAX;

// Bytes of a model, some bits of which count, and how they were when last looked at.
class Words {
 public:
  void add(const char *base, const Net &net);
  // Did any bit change since the last time?
  bool moved(const char *base) {
    Bits difference = {0, 0};
    for (Word &word : words_) {
      Bits now;
      std::memcpy(&now, base + word.offset, sizeof now);
      now &= word.mask;
      difference |= now ^ word.kept;
      word.kept = now;
    }
    return (difference[0] | difference[1]) != 0;
  }
  bool empty() const { return words_.empty(); }

 private:
  typedef uint64_t Bits __attribute__((vector_size(16)));
  struct Word {
    Bits mask, kept;
    size_t offset;
  };
  std::vector<Word> words_;
};

struct Counter {
  Net net, unless;
  unsigned strides[2];
  uint64_t margin;
  uint64_t kept = 0;
  uint64_t delta = 0;  // that the last clock took off
};

// Nets that must have these values.
struct Guard {
  std::vector<std::pair<Net, uint64_t>> nets;

  bool holds() const {
    for (const auto &[net, value] : nets) {
      if (net.get() != value) return false;
    }
    return true;
  }
};

class Unit {
 public:
  uint64_t trigger = 0;
  Words registers;
  std::vector<Counter> counters;
  // What it looks at within the board: always, and unless it is quiet. Ports: see moved_port().
  Words inputs, quiet_inputs;
  Guard quiet;
  std::vector<Net> awake;  // while one of these is not 0, it does not rest

  int64_t last = 0;  // the edge up to which the registers are
  int64_t due = 0;   // the next that it must be given

  // Counters up to edge t, of a unit at rest; true if any moved.
  bool catch_up(int64_t t) {
    const int64_t clocks = t - last;
    last = t;
    return clocks > 0 && moving_ && count(clocks);
  }
  // A port of the board that it looks at has moved since the last look().
  void moved_port() { port_moved_ = true; }
  // After a clock, edge t: what it changed.
  void clocked(const char *base, int64_t t) {
    last = t;
    still_ = !registers.moved(base);
    for (const Net &net : awake) still_ = still_ && net.get() == 0;
    room_ = kNever;
    if (!counters.empty()) look_at_counters();
  }
  // After everything else of edge t: do the inputs stand? Sets due; true if counters were brought
  // up to t, and what follows from them is stale.
  bool look(const char *base, int64_t t) {
    if (port_moved_ || inputs.moved(base) ||
        (!quiet_inputs.empty() && !quiet.holds() && quiet_inputs.moved(base))) {
      port_moved_ = false;
      const bool counted = catch_up(t);
      moved_ = t;
      due = t + 1;
      return counted;
    }
    if (last == t && moved_ != t) {
      due = !still_ || room_ < kWorth ? t + 1 : room_ == kNever ? kNever : t + room_ + 1;
    }
    return false;
  }
  // Somebody wrote its registers: nothing is known.
  void renew(int64_t t);

 private:
  // Fewer clocks than this are not worth a rest: waking costs as much.
  static constexpr int64_t kWorth = 4;

  bool count(int64_t clocks);
  void look_at_counters();

  int64_t moved_ = -kNever;  // the last edge after which inputs moved
  bool port_moved_ = false;
  bool moving_ = false;  // a counter moved with the last clock
  bool still_ = false;   // that clock changed nothing but counters
  int64_t room_ = 0;     // so many more clocks are like it
};

}  // namespace mmcs
