// SPDX-License-Identifier: Apache-2.0
// See cycle.h.

#include "cycle.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace mmcs {
namespace {

// Sights of a request in the same states at which a trace is worked out: most come once only, and
// other data may have one where these have none.
bool worth_learning(unsigned sights) {
  return sights >= 4 && (sights & (sights - 1)) == 0;
}

bool alike(const Part::Moment &a, const Part::Moment &b) {
  return a.state == b.state && a.control == b.control &&
         std::equal(a.fields, a.fields + kMostFields, b.fields);
}

}  // namespace

bool Flow::operator==(const Flow &other) const {
  const auto same = [](const auto &a, const auto &b) {
    return a.size() == b.size() &&
           (a.empty() || !std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]));
  };
  return answered == other.answered && end == other.end && glue == other.glue &&
         parts == other.parts && same(conditions, other.conditions) && same(rooms, other.rooms) &&
         same(moves, other.moves) && same(terms, other.terms) && same(sums, other.sums) &&
         same(events, other.events);
}

Rack::Cycles::Cycles(Rack &rack)
    : rack_(rack),
      data_(rack.data_.data()),
      request_(rack.data_.size() - 2),
      reply_(request_ + 1),
      masks_(rack.data_.size(), ~0u),
      pending_(rack.parts_.size()) {
  masks_[request_] = 0xFFFF;
  for (const auto &part : rack.parts_) {
    size_t at = part->number * kMostFields;
    for (const DataField &field : part->cache->fields()) masks_[at++] = field.mask;
  }
}

// The parts' states and the request, as one number.
uint64_t Rack::Cycles::states(const Request &request) const {
  uint64_t all = request.key;
  for (Part *part : request.parts) {
    part->catch_up(rack_.clock_);
    all = (all ^ reinterpret_cast<uintptr_t>(part->state())) * 0x9E3779B97F4A7C15u;
    all ^= all >> 29;
  }
  return all | 1;
}

bool Rack::Cycles::fits(const Trace &trace) const {
  for (const Trace::Step &s : trace) {
    s.part->catch_up(rack_.clock_);
    if (s.part->state() != s.from || (s.part->pending_data() & ~s.before) != 0) return false;
  }
  for (const Flow::Condition &c : trace.flow->conditions) {
    if ((data_[c.place] & c.mask) != c.value) return false;
  }
  return true;
}

// Whether its counters stay clear of their margin.
bool Rack::Cycles::has_room(const Flow &flow) const {
  for (const Flow::Room &r : flow.rooms) {
    if (data_[r.place] < r.low || data_[r.place] > r.high) return false;
  }
  return true;
}

// A trace of this request from the states as they are; null: none is found.
Trace *Rack::Cycles::learn(const BusRequest &q, uint64_t key) {
  rack_.glue_stale_ = true;
  auto trace = std::make_unique<Trace>();
  auto flow = std::make_unique<Flow>();
  if (!work_out(q, trace.get(), flow.get())) return nullptr;
  const auto same = [&flow](const auto &known) { return *known == *flow; };
  auto known_flow = std::find_if(flows_.begin(), flows_.end(), same);
  if (known_flow == flows_.end()) known_flow = flows_.insert(known_flow, std::move(flow));
  trace->flow = known_flow->get();
  Request &request = requests_[key];
  for (const Trace::Step &s : *trace) {
    if (std::count(request.parts.begin(), request.parts.end(), s.part) == 0)
      request.parts.push_back(s.part);
  }
  Known &known = known_[states(request)];
  trace->next = known.trace;
  known.trace = trace.get();
  traces_.push_back(std::move(trace));
  return known.trace;
}

Trace *Rack::Cycles::find(const BusRequest &q) {
  const uint64_t key = uint64_t{q.address} << 16 | q.am << 8 | q.ds << 1 | unsigned{q.write};
  data_[request_] = q.data & 0xFFFF;
  Known &known = known_[states(requests_[key])];
  for (Trace *trace = known.trace; trace; trace = trace->next) {
    if (fits(*trace)) return has_room(*trace->flow) ? trace : nullptr;
  }
  if (!worth_learning(++known.sights)) return nullptr;
  Trace *learned = learn(q, key);
  return learned && has_room(*learned->flow) ? learned : nullptr;
}

void Rack::Cycles::values(const Flow &flow) {
  uint32_t *value = values_;
  const Term *term = flow.terms.data();
  for (const Flow::Move &m : flow.moves) {
    uint32_t word = (data_[m.to] & m.keep) ^ m.constant;
    for (const Term *last = term + m.terms; term != last; ++term) word ^= term->bits(data_);
    *value++ = word;
  }
}

bool Rack::Cycles::make(const BusRequest &q, BusReply *reply) {
  Trace *trace = find(q);
  if (!trace) return false;
  const Flow &flow = *trace->flow;
  const int64_t end = rack_.clock_ + flow.end;
  if (flow.answered > q.latest + 1 || q.due <= end) return false;
  values(flow);
  if (!follow(*trace)) {
    go_back();
    return false;
  }
  if (rack_.check_ && ++hits_ % static_cast<unsigned>(rack_.check_) == 0) {
    after_.clear();
    for (const auto &[part, moment] : before_) {
      part->catch_up(end);
      after_.push_back(part->moment());
    }
    go_back();
    check(*trace, q, reply);
    return true;
  }
  for (size_t n = heard_; n < flow.moves.size(); ++n) data_[flow.moves[n].to] = values_[n];
  for (const Flow::Sum &s : flow.sums) data_[s.place] = (data_[s.place] + s.by) & s.mask;
  *reply = {data_[reply_], rack_.clock_ + flow.answered, end};
  rack_.clock_ = end;
  ++rack_.evals_;
  if (flow.glue) rack_.glue_stale_ = true;
  for (const Trace::Step &s : *trace) {
    s.part->go_to(s.to, s.pending, end, s.transitions);
    rack_.plan(*s.part);
  }
  for (uint64_t rest = followed_ & ~flow.parts; rest; rest &= rest - 1)
    rack_.plan(*rack_.parts_[static_cast<size_t>(__builtin_ctzll(rest))]);
  rack_.pins_.had_cycle(q.address, q.am, q.data);
  if (rack_.edges_.at <= end) {
    rack_.apply_edges(end);
    rack_.settle();
  }
  return true;
}

// Makes the cycle clock by clock, and compares what becomes of it with the trace.
void Rack::Cycles::check(const Trace &trace, const BusRequest &q, BusReply *reply) {
  const Flow &flow = *trace.flow;
  const int64_t answered = rack_.clock_ + flow.answered, end = rack_.clock_ + flow.end;
  std::vector<uint32_t> sums;
  sums.reserve(flow.sums.size());
  for (const Flow::Sum &s : flow.sums) sums.push_back((data_[s.place] + s.by) & s.mask);
  rack_.keep_caches_ = true;
  *reply = rack_.clock_by_clock(q);
  rack_.keep_caches_ = false;
  bool same = reply->answered == answered && reply->end == end;
  for (const Trace::Step &s : trace) {
    s.part->catch_up(end);
    same = same && s.part->state() == s.to;
  }
  for (size_t n = 0; n < before_.size(); ++n) {
    Part &part = *before_[n].first;
    part.catch_up(end);
    same = same && (flow.parts >> part.number & 1 || alike(part.moment(), after_[n]));
  }
  data_[reply_] = reply->data;
  for (size_t n = heard_; n < flow.moves.size(); ++n)
    same = same && values_[n] == data_[flow.moves[n].to];
  const uint32_t *sum = sums.data();
  for (const Flow::Sum &s : flow.sums) same = same && *sum++ == data_[s.place];
  if (!same) throw std::logic_error("a bus cycle as one step differs from its clocks");
}

bool Rack::bus_cycle(const BusRequest &request, BusReply *reply) {
  if (!skip_ || stopped_ || own_card_ || held_ || pins_.held() || pins_.waiting() ||
      changed_inputs_ != 0 || glue_changed_ || pc_bus_.changed || pc_bus_.switches_changed ||
      pc_bus_.selected != 0 || pc_bus_.command || lines_ != shown_lines_ || dtack_level() == 0) {
    return false;
  }
  if (!cycles_ || cycles_->full()) cycles_ = std::make_unique<Cycles>(*this);
  return cycles_->make(request, reply);
}

}  // namespace mmcs
