// SPDX-License-Identifier: Apache-2.0
// Whole cycles of the VME bus as one step. Terms: docs/simulator/simulator.md.
//
//   Trace          a cycle as one step: the states it leads from and to, what becomes of data
//   Rack::Cycles   all traces of a machine, by request and states (cycle.cpp)
//   Tracer         works a trace out (cycle_trace.cpp, cycle_data.h)
//
// The steps of a trace are those of the parts that send something; the others go on by themselves
// (cycle_follow.cpp), as encoder counters do whose encoders move meanwhile.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "rack.h"

namespace mmcs {

// A place is a data field of a part, half a word of nets, the request's or the reply's data.
using Place = Patterns::Place;
constexpr size_t kSets = 18;  // of values: few patterns of so many bits are a bit's by chance

// Bits that a place had when the cycle began, rotated.
struct Term {
  Place place;
  uint16_t left;
  uint32_t mask;  // after the rotation

  uint32_t bits(const uint32_t *data) const {
    return (data[place] << left | data[place] >> (-left & 31)) & mask;
  }
};

struct Trace {
  static constexpr size_t kMostMoves = 128;
  struct Step {  // a part that sends something
    Part *part;
    State *from, *to;
    uint32_t before, pending;     // data outputs that may be pending; that are, by bit
    std::vector<State *> states;  // all that it comes to
    uint32_t passing, blocked;    // data inputs known to pass through it alike; not to; by bit
  };
  struct Condition {
    uint32_t place, mask, value;
  };
  struct Room {  // a counter stays clear of its margin
    uint32_t place, low, high;
  };
  struct Move {
    Place to;
    uint16_t terms;
    uint32_t keep, constant;
  };
  struct Constant {  // a move without terms
    uint32_t place, keep, value;
  };
  struct Sum {
    uint32_t place, by, mask;
  };
  // Inputs that change after a clock, of a part that only listens: of control, and so many of data.
  struct Event {
    Part *part;
    uint64_t bits, mask;
    uint32_t clock, moves;
  };
  // An input of the own card that changes after a clock; the first moves have its values.
  struct CardInput {
    uint32_t clock, input;
  };
  uint16_t answered = 0, end = 0;  // clocks from its begin
  bool glue = false;               // an input of the glue changes
  uint64_t parts = 0;              // of the steps, by bit
  std::vector<Step> steps;
  std::vector<Condition> conditions;
  std::vector<Room> rooms;
  std::vector<CardInput> card;
  std::vector<Move> moves;  // those of the own card, then of events first
  std::vector<Term> terms;  // of all moves
  std::vector<Constant> constants;
  std::vector<Sum> sums;
  std::vector<Event> events;
  Trace *next = nullptr;  // from the same states, for other data
};

class Rack::Cycles {
 public:
  explicit Cycles(Rack &rack);
  bool make(const BusRequest &request, BusReply *reply);
  bool full() const { return requests_.size() + known_.size() > kMost; }

 private:
  class Tracer;
  static constexpr size_t kMost = 1 << 13;
  struct Known {
    Trace *trace = nullptr;
    unsigned sights = 0;  // for which no trace fitted
  };
  template <class F>
  void for_parts(uint64_t parts, F f) {
    for (; parts; parts &= parts - 1) f(*rack_.parts_[static_cast<size_t>(__builtin_ctzll(parts))]);
  }
  std::vector<uint32_t> masks() const;
  Trace *find(const BusRequest &request);
  std::unique_ptr<Trace> work_out(const BusRequest &request);
  Trace *learn(const BusRequest &request, uint64_t key);
  uint64_t states(uint64_t key);
  bool fits(const Trace &trace) const;
  void values(const Trace &trace);
  void move(const Trace &trace);
  // Parts that have no steps (cycle_follow.cpp).
  bool follow(Trace &trace);
  bool tell_card(const Trace &trace);
  bool follow(Trace &trace, const EncoderEdge &edge);
  bool go_to(Part &part, int64_t t);
  bool passes(Trace &trace, Part &part, int field);
  void go_back();

  Rack &rack_;
  uint32_t *const data_;
  const size_t request_, reply_;  // places
  const Patterns patterns_;
  // By address, modifier, strobes and direction: the parts that have steps; by these and states.
  std::unordered_map<uint64_t, std::vector<Part *>> requests_;
  std::unordered_map<uint64_t, Known> known_;
  std::vector<std::unique_ptr<Trace>> traces_;
  std::vector<uint32_t> pending_;  // of each part: data outputs that were pending before a cycle
  uint32_t values_[Trace::kMostMoves];  // of the moves of a trace
  struct Moment {
    Part::Now now;
    uint32_t fields[kMostFields];
  };
  std::vector<Moment> before_;         // of each part that went on: as it was when the cycle began
  size_t heard_ = 0;                   // moves of the own card and of events
  uint64_t followed_ = 0, moved_ = 0;  // these; with an encoder edge at this clock, by bit
};

}  // namespace mmcs
