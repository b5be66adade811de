// SPDX-License-Identifier: Apache-2.0
// Time: the Verilated machine and the plant, moved together clock by clock.
//
// advance() is the only thing in a simulation that lets time pass. Encoder edges fall on their
// exact clocks; the plant steps every kStepUs; events happen at the clock of their time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "archive.h"
#include "hash.h"
#include "inputs.h"
#include "mmcs_sim.h"
#include "model.h"
#include "plant.h"
#include "tap.h"

namespace mmcs {

template <>
inline constexpr bool kFull<mmcs_event> =
    sizeof(mmcs_event) == 2 * sizeof(double) + 2 * sizeof(int32_t);
template <>
inline constexpr bool kFull<mmcs_note> =
    sizeof(mmcs_note) ==
    sizeof(double) + sizeof(int32_t) + sizeof(mmcs_note::kind) + sizeof(mmcs_note::text);

// What advance() may end on before its clocks are up.
enum class Watch { kNothing, kIrq, kDtackLow, kDtackHigh };

class Machine {
 public:
  // Throws std::invalid_argument with one sentence.
  Machine(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links);

  // Lets up to n clocks pass; true when it ended on what was watched.
  bool advance(int64_t n, Watch watch);

  // A bus cycle as one step, if nothing else comes meanwhile (model.h); `due` is filled in.
  bool bus_cycle(Model::BusRequest request, Model::BusReply *reply);

  int64_t clock() const { return clock_; }
  double time() const { return static_cast<double>(clock_) / Model::clk_hz(); }
  static int64_t clocks(double seconds);  // rounded up
  bool irq() const { return (model_->lines() & kLineIrq) != 0; }
  bool panic() const { return (model_->lines() & kLinePanic) != 0; }
  bool failed() const { return !model_->failure().empty(); }
  Model &model() { return *model_; }
  const Model &model() const { return *model_; }
  const Plant &plant() const { return *plant_; }

  // Named inputs of the machine, then of the plant, then an upset of each register; or null.
  static const char *input_name(int input);
  void add_event(const mmcs_event &event);
  // "" or why the event is impossible.
  std::string check_event(const mmcs_event &event) const;
  double input_value(int input, int index, double t) const;  // of the table, as it stood

  void note(const char *kind, int axis, const std::string &text);
  const std::vector<mmcs_note> &notes() const { return notes_; }
  int64_t notes_lost() const { return notes_lost_; }

  // Events that concern the host: the clock until which it is stalled, bus errors to inject.
  int64_t stalled_until() const { return stalled_until_; }
  bool take_bus_error() {
    if (bus_errors_ == 0) return false;
    --bus_errors_;
    return true;
  }

  // The host is no more: no access, no interrupt, no write.
  bool host_dead() const { return host_dead_ != 0; }
  // What becomes of the program's write now: false: it is lost.
  bool pass_write(std::vector<int32_t> &values) {
    if (writes_lost_ > 0) {
      --writes_lost_;
      return false;
    }
    for (size_t axis = 0; axis < values.size() && axis < write_flips_.size(); ++axis) {
      values[axis] = static_cast<int32_t>(static_cast<uint32_t>(values[axis]) ^
                                          std::exchange(write_flips_[axis], 0));
    }
    return true;
  }

  // Clock and joint angles at the last rising edge of SCLOCK.
  int64_t sample_clock() const { return sample_clock_; }
  const std::vector<double> &sample_angles() const { return sample_angles_; }

  // Everything that left the machine: drive voltages, lines, LEDs, bus cycles.
  Hash &trail() { return trail_; }
  const Hash &trail() const { return trail_; }

  // What readers beside the program are given; no part of the state.
  Tap &tap() { return tap_; }
  const Tap &tap() const { return tap_; }

  // The model is traced between these times only. False: it cannot be, and `from_s` is past.
  bool trace(const std::string &path, double from_s, double to_s);

  // Everything that changes, RTL and plant included; of the notes only how many there are.
  template <class A>
  void state(A &a) {
    if constexpr (!A::kReads) pass_edges();
    for (auto *clock : {&clock_, &next_step_, &step_start_, &bus_errors_, &sample_clock_,
                        &host_dead_, &writes_lost_, &pump_, &alive_}) {
      a(*clock);
    }
    a(edges_);
    a(next_edge_);
    if constexpr (A::kFutureOnly) {
      a(std::max(stalled_until_, clock_));
      a(std::vector<mmcs_event>(events_.begin() + static_cast<std::ptrdiff_t>(next_event_),
                                events_.end()));
    } else {
      a(stalled_until_);
      a(events_);
      a(next_event_);
    }
    a(lines_);
    a.same(write_flips_);
    past(a, notes_lost_);
    a.same(step_angles_);
    a.same(sample_angles_);
    past(a, trail_);
    size_t kept = notes_.size();
    past(a, kept);
    Bytes model, plant;
    uint64_t evals = model_->evals();
    past(a, evals);
    bool upset = model_->was_upset();
    past(a, upset);
    if constexpr (!A::kReads) {
      model = model_->save();
      plant = plant_->save();
    }
    a(model);
    a(plant);
    if constexpr (A::kReads) {
      if (kept > notes_.size()) throw std::invalid_argument("the snapshot lacks its notes");
      notes_.resize(kept);
      plant_->restore(plant);
      model_->restore(model);
      model_->set_evals(evals);
      model_->set_upset(upset);
      expect_edges();
      due_ = clock_;
      tap_.lines(time(), lines_);
    }
  }
  // The notes: the part of the past that state() leaves out.
  template <class A>
  void history(A &a) {
    a(notes_);
  }

 private:
  int card_register_of(int input) const;
  void look_for_failure();
  void lines_changed();
  void plant_step();
  void expect_edges();
  void apply(const mmcs_event &event);
  void apply_due();
  bool trace_due();
  int64_t next_due() const;
  // Of the edges that the model knows, those that are over.
  void pass_edges() {
    while (expected_ && next_edge_ < edges_.size() &&
           step_start_ + edges_[next_edge_].clk < clock_) {
      ++next_edge_;
    }
  }

  mmcs_config config_;
  std::unique_ptr<Model> model_;
  std::unique_ptr<Plant> plant_;
  int axes_;
  int64_t clock_ = 0;
  int clks_per_step_;
  int64_t next_step_ = 0;
  int64_t due_ = 0;  // the clock at which something happens: apply_due()
  int64_t step_start_ = 0;
  std::vector<PinEdge> edges_;
  size_t next_edge_ = 0;
  std::vector<EncoderEdge> coming_;
  bool expected_ = false;  // the model knows them, and needs no stop at each
  std::vector<double> drive_;
  std::vector<mmcs_event> events_;  // sorted by time; events_[next_event_] is the next
  size_t next_event_ = 0;
  int64_t stalled_until_ = 0;
  int64_t bus_errors_ = 0;
  int64_t host_dead_ = 0;
  int64_t writes_lost_ = 0;
  int64_t pump_ = 0;                   // steps for which the charge pump still feeds the brakes
  int64_t alive_ = 0;                  // the sign of life, as it was a step ago
  std::vector<uint32_t> write_flips_;  // by axis
  unsigned lines_ = 0;
  int64_t sample_clock_ = 0;
  std::vector<double> step_angles_;  // at the begin of the step
  std::vector<double> sample_angles_;
  std::vector<mmcs_note> notes_;
  int64_t notes_lost_ = 0;  // came after the last that is kept
  std::string trace_path_;
  int64_t trace_at_ = INT64_MAX;  // clock at which tracing begins, then the one at which it ends
  int64_t trace_end_ = INT64_MAX;
  Hash trail_;
  Tap tap_;
};

}  // namespace mmcs
