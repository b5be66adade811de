// SPDX-License-Identifier: Apache-2.0
// Time of a sweep in steps of 5 ns, events on it, and the count of cases and failures.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <utility>

constexpr long kStepPs = 5000;
constexpr long kClock = 25;           // steps of one clock of 125 ns
constexpr long kAround = 3 * kClock;  // a sweep goes so far to both sides
constexpr long kShown = 3;            // failures of a scene that are told one by one

// What tools/edges.py asks for.
struct Options {
  long sample = 1;        // a scene runs every sample-th case only
  const char *only = "";  // and only scenes whose names hold this
  Options(int argc, char **argv) {
    for (int n = 1; n + 1 < argc; n += 2) {
      if (!std::strcmp(argv[n], "--sample")) sample = std::atol(argv[n + 1]);
      if (!std::strcmp(argv[n], "--only")) only = argv[n + 1];
    }
  }
  bool wants(const char *scene) const { return std::strstr(scene, only); }
};

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
  template <class... N>
  void end_case(const char *scene, const char *form, N... numbers) {
    ++cases_;
    if (!failed()) return;
    if (++failures_ <= kShown) {
      std::printf("  %s: ", scene);
      std::printf(form, static_cast<long>(numbers)...);
      std::printf(": %s\n", why_.c_str());
    }
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
    cases_ = failures_ = 0;
  }

  // A case for each step of one event against another, at each phase of the clock.
  template <class F>
  void sweep(long from, long to, F one) {
    for (long at = from; at <= to; ++at) {
      for (long phase = 0; phase < kClock; ++phase) {
        if (++index_ % sample == 0) one(at, phase);
      }
    }
  }

  virtual void reset() = 0;

  bool either = false;  // synchronisers take what moves either way
  long sample = 1;
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
  long cases_ = 0, failures_ = 0, index_ = 0;
};
