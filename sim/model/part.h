// SPDX-License-Identifier: Apache-2.0
// A part of the machine, board or chip: its state in the cache of its module, its cells, its ports.
//
// Its Verilated model is behind as long as the cache knows what happens. A miss, data that decide,
// a register that is looked at or written from outside: then the model is brought up to the state.
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

struct Wire;

// An input of a part, of all that a value needs to get there.
struct Link {
  Part *part;
  uint64_t mask;  // of control: its bits there
  int at;         // its lowest bit among the control inputs; of data, its cell
  bool data;
};

struct PartPort {
  const PortRow *row;
  Net net;  // in the model
  int width;
  bool out, data;
  bool whole;               // it is all of its variable
  int at;                   // its lowest bit among the control inputs or outputs; of data, its cell
  uint64_t mask;            // of control: its bits there
  std::vector<Link> links;  // of an output: inputs of the board
  Wire *wire = nullptr;     // of an output: to a net that somebody looks at
};

// A register, in the model.
struct Place {
  Net net;
  int cell;  // or -1: control
  int at;    // among the bytes of control registers
};

// Bits of a register that a fault holds.
struct Poke {
  Place *place;
  uint64_t clear, set;
};

class Part {
 public:
  Part(const BoardTable &table, size_t n, std::unique_ptr<Board> model,
       std::shared_ptr<Cache> *cache, VerilatedContext &context);
  Part(const Part &) = delete;

  // Its model is run at every clock, by itself.
  void run_always(bool always) { cached_ = !always; }
  // Bits of a register are held from now on; none: it is free.
  void hold(const Poke &poke);

  // An input has this value from now on, after edge t. True: follow() must come.
  template <class Input>
  bool put(const Input &port, uint64_t value, int64_t t) {
    if (port.data) return put_data(port.at, static_cast<uint32_t>(value), t);
    return put(-1, value << port.at, port.mask, t);
  }
  // Some bits of a cell; -1: of the control inputs.
  bool put(int cell, uint64_t bits, uint64_t mask, int64_t t) {
    if (cell >= 0) {
      const uint32_t some = static_cast<uint32_t>(mask), value = static_cast<uint32_t>(bits);
      return put_data(cell, (cells_[cell] & ~some) | (value & some), t);
    }
    const uint64_t now = (in_ & ~mask) | (bits & mask);
    if (now == in_) return false;
    in_ = now;
    return true;
  }
  uint64_t get(const PartPort &port) const {
    if (port.data) return cells_[port.at];
    return ((port.out ? out_ : in_) & port.mask) >> port.at;
  }

  // After edge t inputs have moved: what follows from them. False: it is due when it was.
  bool follow(int64_t t);
  // Edge t, with inputs as they stand.
  void clock(int64_t t);
  // Both edges of the clock by Verilator's own eval().
  void slow_clock(int64_t t);
  // Its counters up to edge t; nothing else happens to it until then.
  void catch_up(int64_t t) {
    if (last_ >= t) return;
    if (!rests_) return catch_up_slowly(t);
    if (state_ && !state_->still) count(*state_->clock, t - last_);
    last_ = t;
  }
  // No clock came up to edge t.
  void pass(int64_t t) { last_ = t; }
  // The edge that it needs next.
  int64_t due() const { return due_; }
  void plan();

  // The model has its registers, to be looked at; or to be written, if written() follows.
  void load();
  void written(int64_t t);
  uint64_t read(const Place &place) const;
  void forget();  // the cache begins anew
  // Somebody else runs its model: what its outputs are now.

  // Outputs that moved since they were last taken, of those that somebody looks at: control bits,
  // cells.
  bool tells() const {
    if (((out_ ^ told_) & seen_out_) != 0) return true;
    const uint32_t moved = moved_ & seen_cells_;
    return moved != 0 && selected(moved, out_) != 0;
  }
  uint64_t take_out() {
    const uint64_t moved = (out_ ^ told_) & seen_out_;
    told_ = out_;
    return moved;
  }
  uint32_t take_cells() {
    const uint32_t moved = moved_ & seen_cells_;
    moved_ = 0;
    return moved;
  }
  // All is wired: who looks at which output is known.
  void wired();
  // This output is looked at at any time, without being told.
  void show(const PartPort &port) {
    if (port.data) {
      shown_cells_ |= 1u << port.at;
    } else {
      shown_out_ |= port.mask;
    }
  }
  // While all of these outputs are 1 nobody looks at this one.
  void select(uint64_t outputs, const PartPort &port) {
    selects_.push_back({outputs, 1u << port.at});
  }
  // A fault holds what selects: it is looked at always.
  void select_always(bool always);
  const std::vector<std::unique_ptr<PartPort>> &ports() const { return ports_; }
  const PartPort &port_at(int bit) const { return *out_ports_[bit]; }
  const PartPort *port_of(int cell) const { return cell_ports_[cell]; }
  Place *place(size_t row) const { return places_by_row_[row]; }

  std::unique_ptr<Board> model;
  size_t number = 0;       // among the parts
  uint64_t line_mask = 0;  // outputs that run() ends at
  std::shared_ptr<Cache> cache;
  int check = 0;                  // every so many hits the model is asked, too; 0: never
  uint64_t hits = 0, misses = 0;  // a miss runs the model

 private:
  void perform(const Transition &t);
  void near(const Transition &t);
  void catch_up_slowly(int64_t t);
  Transition *learn(bool clock, uint64_t in, bool is_case);
  bool decided() const;
  bool holds(const Transition &t) const;
  int64_t room(const Transition &t) const;
  void count(const Transition &t, int64_t clocks);
  void look_ahead(State *s);
  Transition *join(const State *from, const std::vector<const Transition *> &clocks);
  void plan_slowly();
  void run(bool clock);
  void op(bool clock);
  void own_cache(bool own);
  void put_inputs(const uint32_t *cells, uint64_t in);
  void store();
  void poke();
  void step(Transition **at, bool clock);
  void ask(Transition **at, bool clock);
  bool follow_slowly(int64_t t);
  void clock_slowly();
  void apply(const Transition &t);
  void show(const Transition &t);
  // Clocks that were put off see the input as it was; nobody may look at it.
  bool put_data(int cell, uint32_t value, int64_t t) {
    if (cells_[cell] == value) return false;
    const uint32_t bit = 1u << cell;
    if (rests_ && state_->clock->sources & bit) {
      catch_up(t);
      rests_ = false;
    } else if (!rests_) {
      catch_up(t);
    }
    cells_[cell] = value;
    if (state_ && in_ == state_->in && cached_) {
      const Transition *same = state_->same, *clock = state_->clock;
      if (same && same->to && clock && !((same->sources | clock->sources) & bit)) {
        live_ = false;
        return false;
      }
    }
    data_ |= bit;
    return true;
  }
  // Of these cells those that somebody looks at while the outputs are so.
  uint32_t selected(uint32_t cells, uint64_t out) const {
    if (always_selected_) return cells;
    for (const Select &s : selects_) {
      if ((out & s.outputs) == s.outputs) cells &= ~s.cells;
    }
    return cells;
  }
  State *state_of(const uint8_t *registers, bool is_case);
  void put_state(const uint8_t *registers, const uint32_t *cells, uint64_t in);
  uint64_t look(uint8_t *registers, uint32_t *cells) const;
  uint64_t look_at_outputs(uint32_t *cells) const;

  State *state_ = nullptr;  // null: only the model knows
  bool live_ = true;        // the model is at the state
  bool cached_ = true;
  bool rests_ = false;  // its clocks do nothing but count, until an input moves or it is due
  std::vector<Poke> pokes_;
  std::shared_ptr<Cache> free_;  // the cache of the module, for when no bits are held
  uint64_t in_ = 0, out_ = 0, told_ = 0;
  uint64_t model_in_ = 0;  // control inputs of the model, while it is at the state
  uint32_t cells_[kMostCells] = {};
  uint32_t data_ = 0;        // data inputs that moved
  uint32_t moved_ = 0;       // cells that moved
  uint64_t seen_out_ = 0;    // control outputs that somebody looks at
  uint32_t seen_cells_ = 0;  // the same of data
  uint64_t shown_out_ = 0;   // these, and those that are looked at at any time
  uint32_t shown_cells_ = 0;
  struct Select {
    uint64_t outputs;
    uint32_t cells;
  };
  std::vector<Select> selects_;
  bool always_selected_ = false;
  int64_t last_ = 0, due_ = 0;
  unsigned asked_ = 0;  // steps, for `check`
  size_t register_bytes_ = 0;
  std::vector<std::unique_ptr<PartPort>> ports_;
  std::vector<const PartPort *> out_ports_, cell_ports_;
  struct Slice {  // a cell that is bits of a control register
    int cell, lsb;
    const Place *within;
  };
  std::vector<Slice> slices_;
  std::vector<std::pair<Net, bool>> decides_;  // nets at which data decide, and at which level
  std::vector<std::unique_ptr<Place>> places_;
  std::vector<Place *> places_by_row_;
};

// What a transition does to the cells.
inline void Part::apply(const Transition &t) {
  uint32_t own[kMostCells];
  const uint32_t *before = cells_;
  if (t.swaps) before = static_cast<uint32_t *>(std::memcpy(own, cells_, sizeof own));
  const Copy *c = t.copies().first;
  for (const Copy *end = c + t.out_count; c != end; ++c) {
    const uint32_t was = cells_[c->to], now = c->apply(was, before[c->from]);
    moved_ |= uint32_t{was != now} << c->to;
    cells_[c->to] = now;
  }
  for (const Copy *end = t.copies().last; c != end; ++c) {
    cells_[c->to] = c->apply(cells_[c->to], before[c->from]);
  }
  for (const Count &n : t.counts()) cells_[n.cell] = (cells_[n.cell] + n.by) & n.mask;
}

// Data inputs that moved are copied to outputs.
inline void Part::show(const Transition &t) {
  for (const Copy &c : t.shown()) {
    if (!(data_ >> c.from & 1)) continue;
    const uint32_t was = cells_[c.to], now = c.apply(was, cells_[c.from]);
    moved_ |= uint32_t{was != now} << c.to;
    cells_[c.to] = now;
  }
}

inline void Part::perform(const Transition &t) {
  if (t.moves) apply(t);
  if (data_ != 0) show(t);
  state_ = t.to;
  live_ = false;
  if (t.near) near(t);
  out_ = state_->out;
}

inline void Part::step(Transition **at, bool clock) {
  const Transition *t = *at;
  if (!t || !t->to || check != 0) return ask(at, clock);
  ++hits;
  perform(*t);
}

inline void Part::plan() {
  due_ = last_ + 1;
  rests_ = false;
  if (!state_ || !cached_) return;
  const int quiet = state_->quiet;
  if (quiet < 0) return plan_slowly();
  due_ = state_->ends ? kNever : due_ + quiet;
  rests_ = state_->rests;
}

inline bool Part::follow(int64_t t) {
  if (!state_ || !cached_) return follow_slowly(t);
  State *from = state_;
  if (in_ == from->in) {
    const Transition *same = from->same;
    // What it counts at rest has nothing to do with inputs that are shown only.
    if (!rests_ || !same || same->to != from || same->moves) catch_up(t);
    if (!same || !same->to || same->sources & data_)
      step(&from->same, false);
    else
      live_ = false;
    data_ = 0;
    if (rests_ && state_ == from) return false;
  } else {
    catch_up(t);
    Transition **at = &state_->inputs;
    while (*at && (*at)->in != in_) at = &(*at)->next;
    step(at, false);
  }
  data_ = 0;
  plan();
  return true;
}

inline void Part::count(const Transition &t, int64_t clocks) {
  for (const Count &c : t.counts()) {
    cells_[c.cell] = (cells_[c.cell] + c.by * static_cast<uint32_t>(clocks)) & c.mask;
  }
  live_ = false;
}

inline void Part::clock(int64_t t) {
  if (state_ && state_->told && t - last_ == state_->quiet + 1 && cached_ && check == 0) {
    hits += static_cast<uint64_t>(t - last_);
    last_ = t;
    perform(*state_->told);
    return plan();
  }
  catch_up(t - 1);
  last_ = t;
  if (!state_ || !cached_) return clock_slowly();
  step(&state_->clock, true);
  plan();
}

}  // namespace mmcs
