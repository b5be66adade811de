// SPDX-License-Identifier: Apache-2.0
// Time of a sweep in steps of 5 ns, events on it, and the count of cases and failures.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <utility>

constexpr long kStepPs = 5000;
constexpr long kClock = 25;           // steps of one clock of 125 ns
constexpr long kAround = 3 * kClock;  // a sweep goes so far to both sides

template <class Dut>
class World {
 public:
  Dut dut;
  long now = 0;

  virtual ~World() = default;

  // Something on a pin, `steps` from now; what is due at one instant happens in one eval().
  template <class F>
  void after(long steps, F change) {
    events_.emplace(now + steps, change);
  }

  void wait(long steps) {
    for (long end = now + steps; now < end;) tick();
  }

  template <class F>
  bool wait_for(F met, long limit) {
    for (long end = now + limit; now < end; tick()) {
      if (met()) return true;
    }
    return met();
  }

  // To the instant `phase` steps after a rising edge of the clock.
  void align(long phase) { wait(((phase - now) % kClock + kClock) % kClock + kClock); }

  // One case: reset after a failure, so that the next one starts sound.
  void fail(const char *what) {
    if (!why_.empty()) return;
    why_ = what;
  }
  bool failed() const { return !why_.empty(); }
  void end_case(const char *scene, const char *detail) {
    ++cases_;
    if (!failed()) return;
    ++failures_;
    if (++told_ <= show) std::printf("  %s: %s: %s\n", scene, detail, why_.c_str());
    why_.clear();
    events_.clear();
    reset();
  }

  // Each scene ends with one line that tools/edges.py reads.
  void end_scene(const char *scene, const char *sentence) {
    if (either) return;  // told as one, in the end
    std::printf("EDGES %s|%ld|%ld|%s\n", scene, cases_, failures_, sentence);
    std::fflush(stdout);
    total += failures_;
    cases_ = failures_ = told_ = 0;
  }

  // With sample > 1 a scene runs every sample-th case only.
  bool wanted() { return ++index_ % sample == 0; }

  virtual void reset() = 0;

  bool either = false;  // synchronisers take what moves either way
  long sample = 1;
  long show = 3;
  long total = 0;

 protected:
  virtual void clocks(long phase) = 0;  // drive the clock pins for this step
  virtual void look() = 0;              // after every eval()
  virtual bool clock_moves(long phase) = 0;

  void tick() {
    const long phase = now % kClock;
    bool moves = clock_moves(phase);
    if (moves) clocks(phase);
    while (!events_.empty() && events_.begin()->first <= now) {
      auto change = std::move(events_.begin()->second);
      events_.erase(events_.begin());
      change();
      moves = true;
    }
    if (moves) settle();
    ++now;
  }

  void settle() {
    dut.contextp()->time(static_cast<uint64_t>(now * kStepPs));
    dut.eval();
    look();
  }

 private:
  std::multimap<long, std::function<void()>> events_;
  std::string why_;
  long cases_ = 0, failures_ = 0, told_ = 0, index_ = 0;
};
