// SPDX-License-Identifier: Apache-2.0
// See cycle.h.

#include "cycle.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace mmcs {

// Sights of a request in the same states at which a trace is worked out: most come once only, and
// other data may have one where these have none.
static bool worth_learning(unsigned sights) {
  return sights >= 4 && (sights & (sights - 1)) == 0;
}

Rack::Cycles::Cycles(Rack &rack)
    : rack_(rack),
      data_(rack.data_.data()),
      request_(rack.data_.size() - 2),
      reply_(request_ + 1),
      patterns_(kSets, masks(), [](size_t, const auto &) { return true; }),
      pending_(rack.parts_.size()),
      before_(rack.parts_.size()) {}

// All bits but those of counters with a margin.
std::vector<uint32_t> Rack::Cycles::masks() const {
  std::vector<uint32_t> found(rack_.data_.size());
  found[request_] = found[reply_] = 0xFFFF;
  for (const auto &part : rack_.parts_) {
    size_t at = part->number * kMostFields;
    for (const DataField &field : part->model.fields())
      found[at++] = field.margin < 0 ? field.mask : 0;
  }
  for (size_t net = 0; net < kWires.nets.size(); ++net) {
    for (int bit = 0; bit < kWires.nets[net].width; ++bit)
      found[kFirstNet + 2 * rack_.nets_.at(static_cast<int>(net), 0) +
            static_cast<size_t>(bit / 32)] |= 1u << bit % 32;
  }
  return found;
}

// The parts' states and the request, as one number.
uint64_t Rack::Cycles::states(uint64_t request) {
  uint64_t all = request;
  for (Part *part : requests_[request]) {
    part->catch_up(rack_.clock_);
    all = (all ^ reinterpret_cast<uintptr_t>(part->state())) * 0x9E3779B97F4A7C15u;
    all ^= all >> 29;
  }
  return all;
}

bool Rack::Cycles::fits(const Trace &trace) const {
  for (const Trace::Step &s : trace.steps) {
    if (s.part->state() != s.from || (s.part->pending_data() & ~s.before) != 0) return false;
  }
  for (const Trace::Condition &c : trace.conditions) {
    if ((data_[c.place] & c.mask) != c.value) return false;
  }
  for (const Trace::Room &r : trace.rooms) {
    if (data_[r.place] < r.low || data_[r.place] > r.high) return false;
  }
  return true;
}

// A trace of this request from the states as they are; null: none is found.
Trace *Rack::Cycles::learn(const BusRequest &q, uint64_t key) {
  rack_.glue_stale_ = true;
  std::unique_ptr<Trace> trace = work_out(q);
  if (!trace) return nullptr;
  std::vector<Part *> &parts = requests_[key];
  for (const Trace::Step &s : trace->steps) {
    if (std::count(parts.begin(), parts.end(), s.part) == 0) parts.push_back(s.part);
  }
  Known &known = known_[states(key)];
  trace->next = known.trace;
  known.trace = trace.get();
  traces_.push_back(std::move(trace));
  return known.trace;
}

Trace *Rack::Cycles::find(const BusRequest &q) {
  const uint64_t key = uint64_t{q.address} << 16 | q.am << 8 | q.ds << 1 | unsigned{q.write};
  data_[request_] = q.data & 0xFFFF;
  Known &known = known_[states(key)];
  for (Trace *trace = known.trace; trace; trace = trace->next) {
    if (fits(*trace)) return trace;
  }
  if (!worth_learning(++known.sights)) return nullptr;
  Trace *learned = learn(q, key);
  return learned && fits(*learned) ? learned : nullptr;
}

void Rack::Cycles::values(const Trace &trace) {
  uint32_t *value = values_;
  const Term *term = trace.terms.data();
  for (const Trace::Move &m : trace.moves) {
    uint32_t word = (data_[m.to] & m.keep) ^ m.constant;
    for (const Term *last = term + m.terms; term != last; ++term) word ^= term->bits(data_);
    *value++ = word;
  }
}

// Data as they are when the cycle is over; not those of parts that only listen.
void Rack::Cycles::move(const Trace &trace) {
  for (size_t n = heard_; n < trace.moves.size(); ++n) data_[trace.moves[n].to] = values_[n];
  for (const Trace::Constant &c : trace.constants)
    data_[c.place] = (data_[c.place] & c.keep) ^ c.value;
  for (const Trace::Sum &s : trace.sums) data_[s.place] = (data_[s.place] + s.by) & s.mask;
}

bool Rack::Cycles::make(const BusRequest &q, BusReply *reply) {
  Trace *trace = find(q);
  if (!trace) return false;
  const int64_t end = rack_.clock_ + trace->end;
  if (trace->answered > q.latest + 1 || q.due <= end) return false;
  values(*trace);
  if (!follow(*trace) || !tell_card(*trace)) {
    go_back();
    return false;
  }
  move(*trace);
  *reply = {data_[reply_], rack_.clock_ + trace->answered, end};
  rack_.clock_ = end;
  ++rack_.evals_;
  if (trace->glue) rack_.glue_stale_ = true;
  for (const Trace::Step &s : trace->steps) {
    s.part->go_to(s.to, s.pending, end, s.states.size() - 1);
    rack_.plan(*s.part);
  }
  for_parts(followed_ & ~trace->parts, [this](Part &part) { rack_.plan(part); });
  rack_.pins_.had_cycle(q.address, q.am, q.data);
  if (rack_.edges_.at <= end) {
    rack_.apply_edges(end);
    rack_.settle();
  }
  return true;
}

bool Rack::bus_cycle(const BusRequest &request, BusReply *reply) {
  if (own_card_ && (card_.changed || !own_card_->quiet())) return false;
  if (!skip_ || stopped_ || pins_.faulty() || pins_.waiting() || changed_inputs_ != 0 ||
      glue_changed_ || pc_bus_.changed || pc_bus_.switches_changed || pc_bus_.selected != 0 ||
      pc_bus_.command || lines_ != shown_lines_ || dtack_level() == 0) {
    return false;
  }
  if (!cycles_ || cycles_->full()) cycles_ = std::make_unique<Cycles>(*this);
  if (check_ == 0 || ++checked_ % static_cast<unsigned>(check_) != 0)
    return cycles_->make(request, reply);
  // Makes the cycle as one step and clock by clock, and compares what becomes of it.
  const std::vector<uint8_t> before = save();
  const auto edges = edges_;
  if (!cycles_->make(request, reply)) return false;
  const std::vector<uint8_t> after = save();
  restore(before);
  edges_ = edges;
  const BusReply made = clock_by_clock(request);
  if (save() != after || made.data != reply->data || made.answered != reply->answered ||
      made.end != reply->end)
    throw std::logic_error("a bus cycle as one step differs from its clocks");
  return true;
}

}  // namespace mmcs
