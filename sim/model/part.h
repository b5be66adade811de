// SPDX-License-Identifier: Apache-2.0
// A part of the machine, board or chip: its state in the cache of its module (cache.h), the values
// of its data fields, its ports. Terms: docs/simulator/simulator.md.
//
//   Link, PartPort     a port, and the inputs of other parts that it drives
//   RegisterPlace      where a register is: in the model, and in the state or the data fields
//   HeldBits           bits of a register that a fault holds
//   Part               state, inputs, outputs, time, and what is known of its module
//
// The Verilated model is behind as long as the cache knows the transitions. It is brought up to the
// state by a miss, by a step that the cache cannot know, and where a register is read or written
// from outside (part_model.cpp).
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "board.h"
#include "cache.h"
#include "tables.h"

namespace mmcs {

constexpr int64_t kNever = INT64_MAX;
constexpr int kNoField = -1;  // a control input, output or register

struct Wire;

// An input of a part, with all that a value needs to get there.
struct Link {
  Part *part;
  uint64_t mask;  // its bits among the control inputs
  int shift;      // the lowest of them
  int field;      // of data, else kNoField
};

struct PartPort {
  const PortRow *row;
  Net net;  // in the model
  int width;
  bool output, data;
  bool whole;                 // it is all of its variable
  int shift = 0;              // its lowest bit among the control inputs or outputs
  uint64_t mask = 0;          // its bits there
  int field = kNoField;       // of data
  std::vector<Link> links{};  // of an output: inputs on the same board
  Wire *wire = nullptr;       // of an output: to a net that is read outside the board
};

struct RegisterPlace {
  Net net;    // in the model
  int field;  // of data, else kNoField
  int at;     // of control: its first byte in State::registers()
};

struct HeldBits {
  RegisterPlace *place;
  uint64_t clear, set;
};

class Part {
 public:
  Part(const BoardTable &table, size_t n, std::unique_ptr<Board> model,
       std::shared_ptr<Cache> *cache, VerilatedContext &context, uint32_t (&fields)[kMostFields]);
  Part(const Part &) = delete;

  // Its model is evaluated at every clock, without the cache.
  void run_always(bool always) { mode_.cached = !always; }
  // Bits of a register are held from now on; if there are none, the register is free.
  void hold(const HeldBits &bits);
  bool held() const { return !held_.empty(); }

  // An input has this value after edge t. True: inputs_changed() must be called.
  template <class Input>
  bool put(const Input &port, uint64_t value, int64_t t) {
    if (port.field != kNoField) return put_data(port.field, static_cast<uint32_t>(value), t);
    return put(kNoField, value << port.shift, port.mask, t);
  }
  // Some bits of a data field, or of the control inputs.
  bool put(int field, uint64_t bits, uint64_t mask, int64_t t) {
    if (field != kNoField) {
      const uint32_t some = static_cast<uint32_t>(mask), value = static_cast<uint32_t>(bits);
      return put_data(field, (fields_[field] & ~some) | (value & some), t);
    }
    const uint64_t now = (in_.control & ~mask) | (bits & mask);
    if (now == in_.control) return false;
    in_.control = now;
    return true;
  }
  uint64_t get(const PartPort &port) const {
    if (port.data) return fields_[port.field];
    return ((port.output ? out_.control : in_.control) & port.mask) >> port.shift;
  }

  // Makes the transition of inputs that changed after edge t. False: due() is as it was.
  bool inputs_changed(int64_t t);
  // Makes the transition of clock edge t, with the inputs as they are.
  void clock(int64_t t);
  // Both edges of the clock by Verilator's own eval().
  void slow_clock(int64_t t);
  // Makes the clocks up to edge t that were postponed; they change no observed output.
  void catch_up(int64_t t) {
    if (time_.last >= t) return;
    if (!time_.idle) return catch_up_slowly(t);
    if (state_ && !state_->constant) count(*state_->on_clock, t - time_.last);
    time_.last = t;
  }
  // No clock came up to edge t.
  void pass(int64_t t) { time_.last = t; }
  // The edge whose clock cannot be postponed.
  int64_t due() const { return time_.due; }
  void plan();

  // Brings the model up to the state: its registers can be read, or written before written().
  void load();
  void written(int64_t t);
  uint64_t read(const RegisterPlace &place) const;
  void forget();  // the cache is about to be emptied

  // For cycles as one step (cycle.h). The state, or null; outputs that are observed, of data those
  // that are not ignored.
  State *state() const { return mode_.cached ? state_ : nullptr; }
  uint64_t inputs() const { return in_.control; }
  const uint32_t *fields() const { return fields_; }
  uint32_t pending_data() const { return out_.pending_fields & out_.observed_fields; }
  uint64_t observed() const { return out_.observed | line_mask; }
  uint32_t observed_data(uint32_t fields, uint64_t outputs) const {
    fields &= out_.observed_fields;
    return fields ? not_ignored(fields, outputs) : 0;
  }
  bool only_data_outputs() const { return ((out_.control ^ out_.taken) & out_.observed) == 0; }
  // Learns a transition from a state that it is not in.
  Transition *learn_from(State *state, uint64_t inputs, const uint32_t *fields, bool clock,
                         uint64_t key, bool is_case);
  struct Moment {  // all that changes, to go back to
    State *state;
    uint64_t control, out_control, taken;
    int64_t last, due;
    uint32_t pending, fields[kMostFields];
    bool idle;
  };
  Moment moment() const;
  void go_back(const Moment &moment);
  // To this state after edge t, by so many transitions; these outputs are pending.
  void go_to(State *state, uint32_t pending, int64_t t, uint32_t transitions);

  // Whether observed outputs have changed since they were taken.
  bool has_pending_outputs() const {
    return !only_data_outputs() || observed_data(out_.pending_fields, out_.control) != 0;
  }
  // Those outputs: bits of control; data fields, by bit.
  uint64_t take_outputs() {
    const uint64_t changed = (out_.control ^ out_.taken) & out_.observed;
    out_.taken = out_.control;
    return changed;
  }
  uint32_t take_data_outputs() {
    const uint32_t changed = observed_data(out_.pending_fields, out_.control);
    out_.pending_fields &= ~changed;
    return changed;
  }
  // All ports are connected: outputs that lead anywhere are observed.
  void connected();
  // An output that is read at any time, too, whether it has changed or not.
  void sample(const PartPort &port) {
    if (port.data) {
      out_.sampled_fields |= 1u << port.field;
    } else {
      out_.sampled |= port.mask;
    }
  }
  // While all of these control outputs are 1, this data output is not observed.
  void ignore_while(uint64_t outputs, const PartPort &port) {
    out_.ignored.push_back({outputs, 1u << port.field});
  }
  // A fault holds such a control output: its data outputs are observed always.
  void never_ignore(bool never);
  const std::vector<std::unique_ptr<PartPort>> &ports() const { return ports_.all; }
  const PartPort &port_at(int bit) const { return *ports_.by_output_bit[bit]; }
  const PartPort *port_of(int field) const { return ports_.by_field[field]; }
  RegisterPlace *place(size_t row) const { return layout_.by_row[row]; }

  std::unique_ptr<Board> model;
  size_t number = 0;       // among the parts
  uint64_t line_mask = 0;  // control outputs that Rack::run() ends at
  std::shared_ptr<Cache> cache;
  int check = 0;                  // every so many hits are compared with the model; 0: none
  uint64_t hits = 0, misses = 0;  // steps from the cache; steps that the model was evaluated for

 private:
  void add_register(size_t row_number, const RegisterRow &row, Net net,
                    std::vector<DataField> *fields);
  void add_port(const PartRow &own, const PortRow &row, Net net, std::vector<DataField> *fields);
  // With the cache (part.cpp).
  void perform(const Transition &t);
  void apply(const Transition &t);
  void apply_feedthroughs(const Transition &t);
  void step(Transition **at, bool clock);
  void step_slowly(Transition **at, bool clock);
  void compare_with_model(const Transition &t, bool clock);
  void enter_margin(const Transition &t);
  bool inputs_changed_slowly(int64_t t);
  void clock_slowly();
  void catch_up_slowly(int64_t t);
  void plan_slowly();
  void look_ahead(State *s);
  bool changes_nothing(const Transition &t) const;
  int64_t margin_edge(const Transition &t) const;
  void count(const Transition &t, int64_t clocks);
  // With the model (part_model.cpp).
  Transition *learn(bool clock, uint64_t key, bool is_case);
  bool observe(int set, bool clock, uint32_t fixed, uint32_t valued, Observation *seen);
  void evaluate(bool clock);
  void store();
  void apply_held_bits();
  bool data_decide() const;
  void own_cache(bool own);
  State *state_of(const uint8_t *registers, bool is_case);
  void write_model_inputs(const uint32_t *fields, uint64_t inputs);
  void write_model(const uint8_t *registers, const uint32_t *fields, uint64_t inputs);
  uint64_t read_model(uint8_t *registers, uint32_t *fields) const;
  uint64_t read_model_outputs(uint32_t *fields) const;

  // Postponed clocks are made with the input as it was.
  bool put_data(int field, uint32_t value, int64_t t) {
    if (fields_[field] == value) return false;
    const uint32_t bit = 1u << field;
    if (time_.idle && state_->on_clock->sources & bit) {
      catch_up(t);
      time_.idle = false;
    } else if (!time_.idle) {
      catch_up(t);
    }
    fields_[field] = value;
    if (state_ && in_.control == state_->inputs && mode_.cached) {
      const Transition *on_data = state_->on_data, *clock = state_->on_clock;
      if (on_data && on_data->to && clock && !((on_data->sources | clock->sources) & bit)) {
        mode_.model_current = false;
        return false;
      }
    }
    in_.changed_fields |= bit;
    return true;
  }
  // Of these data outputs those that are not ignored while the control outputs are so.
  uint32_t not_ignored(uint32_t fields, uint64_t outputs) const {
    if (out_.never_ignored) return fields;
    for (const auto &[ones, ignored] : out_.ignored) {
      if ((outputs & ones) == ones) fields &= ~ignored;
    }
    return fields;
  }

  State *state_ = nullptr;  // null: only the model knows
  uint32_t (&fields_)[kMostFields];
  struct {
    uint64_t control = 0;
    uint32_t changed_fields = 0;  // data inputs that changed, by bit
  } in_;
  struct {
    uint64_t control = 0;
    uint64_t taken = 0;            // as take_outputs() saw them last
    uint32_t pending_fields = 0;   // data outputs that changed since they were taken, by bit
    uint64_t observed = 0;         // those that other parts, nets or lines read
    uint32_t observed_fields = 0;  // the same of data
    uint64_t sampled = 0;          // these, and those that are read at any time
    uint32_t sampled_fields = 0;
    struct Ignored {
      uint64_t ones;    // control outputs
      uint32_t fields;  // data outputs, not observed while all of them are 1
    };
    std::vector<Ignored> ignored;
    bool never_ignored = false;
  } out_;
  struct {
    int64_t last = 0;   // the edge of the last clock that was made
    int64_t due = 0;    // see due()
    bool idle = false;  // clocks do nothing but count, until an input changes or it is due
  } time_;
  struct {
    bool cached = true;
    bool model_current = true;  // the model has the state
    uint64_t model_inputs = 0;  // its control inputs then
    unsigned steps = 0;         // for `check`
  } mode_;
  std::vector<HeldBits> held_;
  std::shared_ptr<Cache> module_cache_;  // for when no bits are held
  struct {
    std::vector<std::unique_ptr<PartPort>> all;
    std::vector<const PartPort *> by_output_bit, by_field;
  } ports_;
  struct Slice {  // a data field that is bits of a control register
    int field, lsb;
    const RegisterPlace *within;
  };
  struct {
    size_t register_bytes = 0;
    std::vector<std::unique_ptr<RegisterPlace>> places;
    std::vector<RegisterPlace *> by_row;  // of BoardTable::registers
    std::vector<Slice> slices;
    std::vector<std::pair<Net, bool>> deciding;  // nets at which data decide, and at which level
  } layout_;
};

// What a transition does to the data fields.
inline void Part::apply(const Transition &t) {
  uint32_t own[kMostFields];
  const uint32_t *before = fields_;
  if (t.overlaps) before = static_cast<uint32_t *>(std::memcpy(own, fields_, sizeof own));
  const Copy *c = t.copies().first;
  for (const Copy *end = c + t.output_copy_count; c != end; ++c) {
    const uint32_t was = fields_[c->to], now = c->apply(was, before[c->from]);
    out_.pending_fields |= uint32_t{was != now} << c->to;
    fields_[c->to] = now;
  }
  for (const Copy *end = t.copies().last; c != end; ++c) {
    fields_[c->to] = c->apply(fields_[c->to], before[c->from]);
  }
  for (const Count &n : t.counts()) fields_[n.field] = (fields_[n.field] + n.by) & n.mask;
}

// Data inputs that changed are copied to the outputs that follow them.
inline void Part::apply_feedthroughs(const Transition &t) {
  for (const Copy &c : t.feedthroughs()) {
    if (!(in_.changed_fields >> c.from & 1)) continue;
    const uint32_t was = fields_[c.to], now = c.apply(was, fields_[c.from]);
    out_.pending_fields |= uint32_t{was != now} << c.to;
    fields_[c.to] = now;
  }
}

inline void Part::perform(const Transition &t) {
  if (t.moves) apply(t);
  if (in_.changed_fields != 0) apply_feedthroughs(t);
  state_ = t.to;
  mode_.model_current = false;
  if (t.near_margin) enter_margin(t);
  out_.control = state_->outputs;
}

inline void Part::step(Transition **at, bool clock) {
  const Transition *t = *at;
  if (!t || !t->to || check != 0) return step_slowly(at, clock);
  ++hits;
  perform(*t);
}

inline void Part::plan() {
  time_.due = time_.last + 1;
  time_.idle = false;
  if (!state_ || !mode_.cached) return;
  const int silent = state_->silent_clocks;
  if (silent < 0) return plan_slowly();
  time_.due = state_->then_idle ? kNever : time_.due + silent;
  time_.idle = state_->idle;
}

inline bool Part::inputs_changed(int64_t t) {
  if (!state_ || !mode_.cached) return inputs_changed_slowly(t);
  State *from = state_;
  if (in_.control == from->inputs) {
    const Transition *on_data = from->on_data;
    // Counts while idle do not depend on data inputs that only feed through.
    if (!time_.idle || !on_data || on_data->to != from || on_data->moves) catch_up(t);
    if (!on_data || !on_data->to || on_data->sources & in_.changed_fields)
      step(&from->on_data, false);
    else
      mode_.model_current = false;
    in_.changed_fields = 0;
    if (time_.idle && state_ == from) return false;
  } else {
    catch_up(t);
    Transition **at = &state_->on_inputs;
    while (*at && (*at)->key != in_.control) at = &(*at)->next;
    step(at, false);
  }
  in_.changed_fields = 0;
  plan();
  return true;
}

inline void Part::count(const Transition &t, int64_t clocks) {
  for (const Count &c : t.counts()) {
    fields_[c.field] = (fields_[c.field] + c.by * static_cast<uint32_t>(clocks)) & c.mask;
  }
  mode_.model_current = false;
}

inline void Part::clock(int64_t t) {
  catch_up(t - 1);
  time_.last = t;
  if (!state_ || !mode_.cached) return clock_slowly();
  step(&state_->on_clock, true);
  plan();
}

}  // namespace mmcs
