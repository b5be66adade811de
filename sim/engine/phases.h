// SPDX-License-Identifier: Apache-2.0
// What the firmware of a real processor is doing, found from outside: by its bus cycles and
// reports.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace mmcs {

// In the order of a servo pass; kWaiting and kProgram are not part of one.
enum class Phase : unsigned {
  kWaiting = 0,  // stopped
  kProgram,      // start-up, requests
  kEnter,        // acknowledge cycle, latches, timer 2
  kRead,         // encoders, port C, A/Ds, timer 2
  kCompute,      // the law, all axes
  kWrite,        // D/As, timer 2
  kPublish,      // states to the mailbox, until the report
  kCount
};

class Phases {
 public:
  // Times of the passes that wrote the D/As; kWaiting stands for SCLOCK to acknowledge, kProgram
  // for the whole from SCLOCK to the report.
  struct Time {
    int64_t passes = 0;
    double sum_us = 0, max_us = 0;
    void add(double us) {
      ++passes;
      sum_us += us;
      max_us = std::max(max_us, us);
    }
  };

  void acknowledge(double sclock_us, double now_us) {
    sclock_ = sclock_us;
    begins_ = last_ = now_us;
    wrote_ = false;
    now_ = Phase::kEnter;
  }
  // One access to the adaptor's window, from..to.
  void access(unsigned offset, bool write, double from_us, double to_us) {
    if (now_ < Phase::kEnter) return;
    const bool card = (offset & 0x400) == 0;
    const unsigned reg = offset >> 1 & 0x1F;
    if (card && now_ == Phase::kEnter) turn(Phase::kRead, from_us);
    // after a look at timer 2 the law runs until the first D/A is written
    if (card && write && reg >= 0x8 && reg <= 0xB) {
      if (now_ == Phase::kCompute) turn(Phase::kWrite, from_us);
      wrote_ = wrote_ || now_ == Phase::kWrite;
    }
    if (now_ == Phase::kCompute) turn(Phase::kRead, last_);
    // and what follows the look after that writes no more, unless it does
    if (now_ == Phase::kPublish) turn(Phase::kWrite, last_);
    if (card) {
      looks_ = 0;
    } else if (!write && ++looks_ == 2) {
      if (now_ == Phase::kRead) turn(Phase::kCompute, to_us);
      if (now_ == Phase::kWrite) turn(Phase::kPublish, to_us);
    }
    last_ = to_us;
  }
  void report(bool sampled, double now_us) {
    if (now_ < Phase::kEnter) return;
    if (now_ == Phase::kWrite) turn(Phase::kPublish, last_);
    turn(Phase::kProgram, now_us);
    if (!sampled || !wrote_) return;
    for (size_t n = static_cast<size_t>(Phase::kEnter); n < spent_.size(); ++n) {
      times_[n].add(spent_[n]);
    }
    times_[0].add(latency_);
    times_[1].add(now_us - sclock_);
  }

  Phase now() const { return now_; }
  const std::array<Time, static_cast<size_t>(Phase::kCount)> &times() const { return times_; }

 private:
  void turn(Phase to, double us) {
    if (now_ == Phase::kEnter) {
      spent_.fill(0);
      latency_ = begins_ - sclock_;
      looks_ = 0;
    }
    spent_[static_cast<size_t>(now_)] += us - begins_;
    begins_ = us;
    now_ = to;
  }

  Phase now_ = Phase::kProgram;
  double sclock_ = 0, begins_ = 0, last_ = 0, latency_ = 0;
  int looks_ = 0;
  bool wrote_ = false;
  std::array<double, static_cast<size_t>(Phase::kCount)> spent_{};
  std::array<Time, static_cast<size_t>(Phase::kCount)> times_;
};

}  // namespace mmcs
