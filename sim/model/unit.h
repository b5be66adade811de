// SPDX-License-Identifier: Apache-2.0
// A Verilated part, board or chip, and when it needs its next clock.
//
// At rest: one clock with inputs that stood left all registers as they were, and each counter stood
// or moved by a stride that counters.toml declares. Then the next clock does the same, until a
// counter comes to its margin or an input changes: so many clocks are k times the stride.
#pragma once

#include <climits>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
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
  // Is any of them not 0?
  bool any(const char *base) const {
    Bits found = {0, 0};
    for (const Word &word : words_) {
      Bits now;
      std::memcpy(&now, base + word.offset, sizeof now);
      found |= now & word.mask;
    }
    return (found[0] | found[1]) != 0;
  }

 private:
  typedef uint64_t Bits __attribute__((vector_size(16)));
  struct Word {
    Bits mask, kept;
    size_t offset;
  };
  Word &at(size_t offset);

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

// Bits of a register that a fault holds.
struct Poke {
  Net net;
  uint64_t clear, set;
};

class Unit {
 public:
  explicit Unit(std::unique_ptr<Board> m) : model(std::move(m)), base(model->base()) {
    model->port("clk_i").put(1);
  }

  std::unique_ptr<Board> model;
  char *base;
  Words registers;
  std::vector<Counter> counters;
  Words awake;  // while one of these is not 0, it does not rest
  std::vector<Poke> pokes;
  int64_t due = 0;    // the next edge that it must be given
  bool stale = true;  // inputs or counters were written, and nothing has followed
  bool fresh = true;  // evaluated since its outputs were last looked at

  // Counters up to edge t, of a unit at rest.
  void catch_up(int64_t t) {
    const int64_t clocks = t - last_;
    last_ = t;
    if (clocks > 0 && moving_) count(clocks);
  }
  // After edge t an input has moved that concerns its registers.
  void wake(int64_t t) {
    catch_up(t);
    due = t + 1;
  }
  // What follows from its inputs as they are after edge t.
  void follow(int64_t t) {
    catch_up(t);
    stale = false;
    fresh = true;
    if (!model->inputs()) return;
    poke();  // a reset does not move what sticks
    renew(t);
  }
  // Edge t, with inputs and counters as they were after the one before; what it changed.
  void clock(int64_t t) {
    model->clock();
    judge(t);
  }
  // After edge t: when it needs the next one.
  void judge(int64_t t) {
    if (!pokes.empty()) poke();
    fresh = true;
    last_ = t;
    if (awake.any(base)) {
      known_ = moving_ = false;
      due = t + 1;
      return;
    }
    bool still = !registers.moved(base) && known_;
    known_ = true;
    room_ = kNever;
    if (!counters.empty()) still = look_at_counters() && still;
    due = !still || room_ < kWorth ? t + 1 : room_ == kNever ? kNever : t + room_ + 1;
  }
  // Somebody wrote its registers: what follows from them, clears without a clock included; of rest
  // nothing is known.
  void written(int64_t t) {
    model->settle();
    model->inputs();
    fresh = true;
    renew(t);
  }
  // At each clock, whatever it does.
  void renew(int64_t t);
  void poke();

 private:
  // Fewer clocks than this are not worth a rest: waking costs as much.
  static constexpr int64_t kWorth = 4;

  void count(int64_t clocks);
  bool look_at_counters();

  int64_t last_ = 0;     // the edge up to which the registers are
  bool known_ = false;   // `registers` has the last clock's
  bool moving_ = false;  // a counter moved with the last clock
  int64_t room_ = 0;     // so many more clocks are like it
};

}  // namespace mmcs
