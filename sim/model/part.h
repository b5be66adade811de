// SPDX-License-Identifier: Apache-2.0
// A part of the machine, board or chip: its state in the cache of its module (cache.h), the values
// of its data fields, its inputs and outputs, and time. Terms: docs/simulator/simulator.md.
//
// The Verilated model (part_model.h) is out of date as long as the cache knows the transitions. It
// is brought up to the state by a miss, by a step that the cache cannot know, and where a register
// is read or written from outside.
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>

#include "cache.h"
#include "part_model.h"

namespace mmcs {

constexpr int64_t kNever = INT64_MAX;

class Part {
 public:
  // fields: kMostFields values of data, which traces read and write, too.
  Part(const BoardTable &table, size_t n, std::unique_ptr<Board> board,
       std::shared_ptr<Cache> *cache, VerilatedContext &context, uint32_t *fields);
  Part(const Part &) = delete;

  // After a change of the model's faults: with a fault its transitions are others than those of its
  // module, and it has a cache of its own. written() must follow.
  void choose_cache(const std::shared_ptr<Cache> &of_module);

  // An input has this value after edge t. True: inputs_changed() must be called.
  template <class Input>
  bool put(const Input &to, uint64_t value, int64_t t) {
    return put(to.field, value << to.shift | value >> (-to.shift & 63), to.mask, t);
  }
  // Some bits of a data field, or of the control inputs.
  bool put(int field, uint64_t bits, uint64_t mask, int64_t t) {
    if (field != kNoField) {
      const uint32_t some = static_cast<uint32_t>(mask), value = static_cast<uint32_t>(bits);
      return put_data(field, (fields_[field] & ~some) | (value & some), t);
    }
    const uint64_t inputs = (now_.inputs & ~mask) | (bits & mask);
    if (inputs == now_.inputs) return false;
    now_.inputs = inputs;
    return true;
  }
  uint64_t get(const PartPort &port) const {
    if (port.data) return fields_[port.field];
    return ((port.output ? now_.outputs : now_.inputs) & port.mask) >> port.shift;
  }

  // Makes the transition of inputs that changed after edge t. False: due() is as it was.
  bool inputs_changed(int64_t t);
  // Makes the transition of clock edge t, with the inputs as they are.
  void clock(int64_t t);
  // Makes the clocks up to edge t that were postponed; they change no observed output.
  void catch_up(int64_t t) {
    if (now_.last >= t) return;
    if (!now_.idle) return catch_up_slowly(t);
    count(*now_.state->on_clock, t - now_.last);
    now_.last = t;
  }
  // No clock came up to edge t.
  void pass(int64_t t) { now_.last = t; }
  // The edge whose clock cannot be postponed.
  int64_t due() const { return now_.due; }
  void plan();

  // Brings the model up to the state: its registers can be read, or written before written().
  void load();
  void written(int64_t t);
  // Takes state and data fields from the model, which load() brought up to them.
  void store();

  // All that changes, but for the data fields.
  struct Now {
    State *state = nullptr;  // null: before power-on
    uint64_t inputs = 0;     // of control
    uint64_t outputs = 0;
    uint64_t taken = 0;             // outputs, as take_outputs() saw them last
    uint32_t changed = 0;           // data inputs that changed, by bit
    uint32_t pending = 0;           // data that changed since it was taken as output, by bit
    int64_t last = 0;               // the edge of the last clock that was made
    int64_t due = 0;                // see due()
    uint64_t hits = 0, misses = 0;  // steps from the cache; steps that the model was evaluated for
    bool idle = false;  // clocks do nothing but count, until an input changes or it is due
  };

  // For cycles as one step (cycle.h).
  State *state() const { return now_.state; }
  uint64_t inputs() const { return now_.inputs; }
  const uint32_t *fields() const { return fields_; }
  uint32_t pending_data() const { return now_.pending & observed_fields_; }
  uint64_t observed() const { return observed_; }
  uint32_t observed_data(uint32_t fields, uint64_t outputs) const {
    fields &= observed_fields_;
    return fields ? model.not_ignored(fields, outputs) : 0;
  }
  bool only_data_outputs() const { return ((now_.outputs ^ now_.taken) & observed_) == 0; }
  // Learns a transition from a state that it is not in.
  Transition *learn_from(State *state, uint64_t inputs, const uint32_t *fields, bool clock,
                         uint64_t key, bool is_case);
  const Now &now() const { return now_; }
  void go_back(const Now &now, const uint32_t *fields);
  // To this state after edge t, by so many transitions; these outputs are pending.
  void go_to(State *state, uint32_t pending, int64_t t, size_t transitions);

  // Whether observed outputs have changed since they were taken.
  bool has_pending_outputs() const {
    return !only_data_outputs() || observed_data(now_.pending, now_.outputs) != 0;
  }
  // Those outputs: bits of control; data fields, by bit.
  uint64_t take_outputs() {
    const uint64_t changed = (now_.outputs ^ now_.taken) & observed_;
    now_.taken = now_.outputs;
    return changed;
  }
  uint32_t take_data_outputs() {
    const uint32_t changed = observed_data(now_.pending, now_.outputs);
    now_.pending &= ~changed;
    return changed;
  }
  // From now on this output is observed.
  void observe(const PartPort &port) {
    if (port.data) {
      observed_fields_ |= 1u << port.field;
    } else {
      observed_ |= port.mask;
    }
  }

  PartModel model;
  size_t number = 0;       // among the parts
  uint64_t line_mask = 0;  // control outputs that Rack::run() ends at
  std::shared_ptr<Cache> cache;
  int check = 0;  // every so many hits are compared with the model; 0: none

 private:
  // With the cache.
  void perform(const Transition &t);
  void apply(const Transition &t);
  void apply_feedthroughs(const Transition &t);
  void step(Transition **at, bool clock);
  void step_slowly(Transition **at, bool clock);
  void compare_with_model(const Transition &t, bool clock);
  void enter_margin(const Transition &t);
  void catch_up_slowly(int64_t t);
  void plan_slowly();
  void look_ahead(State *s);
  bool changes_nothing(const Transition &t) const;
  int64_t margin_edge(const Transition &t) const;
  void count(const Transition &t, int64_t clocks);
  // With the model (part_learn.cpp).
  void evaluate(bool clock);
  Transition *learn(bool clock, uint64_t key, bool is_case);
  bool observe_step(int set, bool clock, uint32_t fixed, uint32_t valued, Observation *seen);
  State *state_of(const uint8_t *registers, bool is_case);

  // Postponed clocks are made with the input as it was.
  bool put_data(int field, uint32_t value, int64_t t) {
    if (fields_[field] == value) return false;
    const uint32_t bit = 1u << field;
    if (!now_.idle || now_.state->on_clock->sources & bit) {
      catch_up(t);
      now_.idle = false;
    }
    fields_[field] = value;
    now_.changed |= bit;
    return true;
  }

  Now now_;
  uint32_t *const fields_;
  uint64_t observed_ = 0;         // control outputs that other parts, nets or lines read, or Model
  uint32_t observed_fields_ = 0;  // the same of data
  bool model_current_ = true;     // the model has the state
};

// What a transition does to the data fields.
inline void Part::apply(const Transition &t) {
  uint32_t own[kMostFields];
  const uint32_t *before = fields_;
  if (t.overlaps) before = static_cast<uint32_t *>(std::memcpy(own, fields_, sizeof own));
  for (const Copy &c : t.copies()) {
    const uint32_t was = fields_[c.to], now = c.apply(was, before[c.from]);
    now_.pending |= uint32_t{was != now} << c.to;
    fields_[c.to] = now;
  }
  for (const Count &n : t.counts()) fields_[n.field] = (fields_[n.field] + n.by) & n.mask;
}

// Data inputs that changed are copied to the outputs that follow them.
inline void Part::apply_feedthroughs(const Transition &t) {
  for (const Copy &c : t.feedthroughs()) {
    if (!(now_.changed >> c.from & 1)) continue;
    const uint32_t was = fields_[c.to], now = c.apply(was, fields_[c.from]);
    now_.pending |= uint32_t{was != now} << c.to;
    fields_[c.to] = now;
  }
}

inline void Part::perform(const Transition &t) {
  if (t.moves) apply(t);
  if (now_.changed != 0) apply_feedthroughs(t);
  now_.state = t.to;
  model_current_ = false;
  if (t.near_margin) enter_margin(t);
  now_.outputs = now_.state->outputs;
}

inline void Part::step(Transition **at, bool clock) {
  const Transition *t = *at;
  if (!t || !t->to || check != 0) return step_slowly(at, clock);
  ++now_.hits;
  perform(*t);
}

inline void Part::plan() {
  now_.due = now_.last + 1;
  now_.idle = false;
  const int silent = now_.state->silent_clocks;
  if (silent < 0) return plan_slowly();
  now_.due = now_.state->then_idle ? kNever : now_.due + silent;
  now_.idle = now_.state->idle;
}

inline bool Part::inputs_changed(int64_t t) {
  State *from = now_.state;
  if (now_.inputs == from->inputs) {
    const Transition *on_data = from->on_data;
    // Counts while idle do not depend on data inputs that only feed through.
    if (!now_.idle || !on_data || on_data->to != from || on_data->moves) catch_up(t);
    if (!on_data || !on_data->to || on_data->sources & now_.changed)
      step(&from->on_data, false);
    else
      model_current_ = false;
    now_.changed = 0;
    if (now_.idle && now_.state == from) return false;
  } else {
    catch_up(t);
    Transition **at = &now_.state->on_inputs;
    while (*at && (*at)->key != now_.inputs) at = &(*at)->next;
    step(at, false);
  }
  now_.changed = 0;
  plan();
  return true;
}

inline void Part::count(const Transition &t, int64_t clocks) {
  for (const Count &c : t.counts()) {
    fields_[c.field] = (fields_[c.field] + c.by * static_cast<uint32_t>(clocks)) & c.mask;
  }
  model_current_ = false;
}

inline void Part::clock(int64_t t) {
  catch_up(t - 1);
  now_.last = t;
  step(&now_.state->on_clock, true);
  plan();
}

}  // namespace mmcs
