// SPDX-License-Identifier: Apache-2.0
// What a run leaves behind: one log row per servo sample, and the hash of all samples.
#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "driver.h"
#include "hash.h"
#include "machine.h"

namespace mmcs {

class Recorder {
 public:
  explicit Recorder(int axes)
      : axes_(axes), angles_(static_cast<size_t>(axes)), errcodes_(static_cast<size_t>(axes)) {}

  // Rows are kept for samples from this clock on; t_s counts from it.
  void start(int64_t clock) { start_clock_ = clock; }
  bool started() const { return start_clock_ >= 0; }
  int64_t start_clock() const { return start_clock_; }

  // A pass begins: the SCLOCK edge before it is the instant of its sample.
  void mark(const Machine &machine) {
    sample_clock_ = machine.sample_clock();
    angles_ = machine.sample_angles();
  }
  int64_t sample_clock() const { return sample_clock_; }
  int64_t samples() const { return samples_; }
  // A servo pass has published its sample.
  void sample(const struct mc *mc, const Machine &machine);
  // Notes error flags that are new since the last call.
  void errors(Machine &machine, const struct mc *mc);
  // Notes what the driver counted in this interrupt but not in the one before it: one note for a
  // row of passes that overrun.
  void interrupt(Machine &machine, const struct mc_stats &stats);

  int cols() const { return 1 + 7 * axes_; }
  // All rows so far; those not yet taken; and what becomes of the latter once they are.
  int64_t rows() const { return taken_ + kept(); }
  int64_t kept() const { return static_cast<int64_t>(log_.size()) / cols(); }
  const double *data() const { return log_.data(); }
  void took() {
    taken_ += kept();
    log_.clear();
  }
  const Hash &hash() const { return hash_; }

  // Every so many samples the running hashes are kept, so that a replay can tell where it parts.
  static constexpr int64_t kCheckpointEvery = 32;
  const std::vector<mmcs_checkpoint> &checkpoints() const { return checkpoints_; }

  // Everything that changes; of the log and the checkpoints only how many there are. Rows that
  // have been taken are the taker's to bring back.
  template <class A>
  void state(A &a) {
    a(start_clock_);
    a(sample_clock_);
    past(a, samples_);
    a.same(angles_);
    a.same(errcodes_);
    past(a, counts_);
    past(a, counted_);
    past(a, hash_);
    int64_t all = rows();
    size_t points = checkpoints_.size();
    past(a, all);
    past(a, points);
    if constexpr (A::kReads) {
      if (all < 0 || all > rows() || points > checkpoints_.size()) {
        throw std::invalid_argument("the snapshot lacks its log");
      }
      if (all < taken_) taken_ = all;
      log_.resize(static_cast<size_t>((all - taken_) * cols()));
      checkpoints_.resize(points);
    }
  }
  // The past that state() leaves out.
  template <class A>
  void history(A &a) {
    a(taken_);
    a(log_);
    if constexpr (A::kReads) {
      if (taken_ < 0 || log_.size() % static_cast<size_t>(cols()) != 0) {
        throw std::invalid_argument("the log is damaged");
      }
    }
    a(checkpoints_);
  }

 private:
  int axes_;
  int64_t start_clock_ = -1;
  int64_t sample_clock_ = -1;
  std::vector<double> angles_;
  int64_t taken_ = 0;  // rows that are no longer here
  std::vector<double> log_;
  std::vector<int32_t> errcodes_;
  std::array<int32_t, 3> counts_{};  // missed, overrun, spurious after the last interrupt
  unsigned counted_ = 0;             // a bit for each that grew in it
  int64_t samples_ = 0;
  std::vector<mmcs_checkpoint> checkpoints_;
  Hash hash_;
};

}  // namespace mmcs
