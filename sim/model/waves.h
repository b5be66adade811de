// SPDX-License-Identifier: Apache-2.0
// A file of waveforms. Verilator's writer aborts the process when it cannot write: the files that
// are open then are half, and removed. SIGABRT does that while one is open, and before and after
// what the process wants.

#pragma once

#include <unistd.h>

#include <csignal>
#include <string>

#include "verilated_fst_c.h"

namespace mmcs {

class Waves : public VerilatedFstC {
 public:
  explicit Waves(const std::string &path) : path_(path), rest_(path + ".hier"), next_(open_) {
    if (!open_) before_ = std::signal(SIGABRT, end_unwritten);
    open_ = this;
  }
  ~Waves() override {
    close();
    Waves **at = &open_;
    while (*at != this) at = &(*at)->next_;
    *at = next_;
    if (!open_) std::signal(SIGABRT, before_);
  }

 private:
  static void end_unwritten(int) {
    static const char text[] =
        "mmcs: aborted where waveforms are written: if the disk is full, free it and run again\n";
    for (const Waves *half = open_; half; half = half->next_) {
      unlink(half->path_.c_str());
      unlink(half->rest_.c_str());
    }
    _exit(write(STDERR_FILENO, text, sizeof text - 1) < 0 ? 2 : 1);
  }

  static inline Waves *open_ = nullptr;          // the last of those that are open
  static inline void (*before_)(int) = SIG_DFL;  // what SIGABRT did before the first
  const std::string path_, rest_;                // the second is Verilator's
  Waves *next_;
};

}  // namespace mmcs
