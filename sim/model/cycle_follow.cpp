// SPDX-License-Identifier: Apache-2.0
// Parts that have no steps in a trace, while a cycle goes on (cycle.h).

#include <algorithm>
#include <cstring>

#include "cycle.h"

namespace mmcs {

// A part that is not among the steps is at edge t. False: others would notice.
bool Rack::Cycles::go_to(Part &part, int64_t t) {
  if (!(followed_ >> part.number & 1)) {
    followed_ |= uint64_t{1} << part.number;
    std::memcpy(before_[part.number].fields, part.fields(), sizeof before_[0].fields);
    before_[part.number].now = part.now();
  }
  while (part.due() <= t && !part.has_pending_outputs()) part.clock(part.due());
  return !part.has_pending_outputs();
}

// An encoder moves at the inputs of its card, and behind it at the encoder counter.
bool Rack::Cycles::follow(Trace &trace, const EncoderEdge &edge) {
  const int64_t t = edge.clock + 1;
  for (unsigned pin = 0; pin < 3; ++pin) {
    const Input &input = rack_.inputs_[kEncA + pin];
    const auto axis = static_cast<size_t>(edge.axis);
    for (unsigned n = input.fields[axis]; n < input.fields[axis + 1]; ++n) {
      const Link &to = input.arrivals[n];
      Part &part = *to.part;
      const bool is_step = trace.parts >> part.number & 1;
      const int64_t at = is_step ? rack_.clock_ : t;
      if (!go_to(part, at)) return false;
      if (!part.put(to, edge.pins >> pin & 1, at)) continue;
      if (is_step && (to.field == kNoField || !passes(trace, part, to.field))) return false;
      part.inputs_changed(at);
      if (!part.only_data_outputs()) return false;
      for (uint32_t fields = part.take_data_outputs(); fields; fields &= fields - 1) {
        const PartPort *port = part.model.port_of(__builtin_ctz(fields));
        if (!port) continue;
        if (port->wire) return false;
        for (const Link &l : port->links) {
          if (trace.parts >> l.part->number & 1 || !go_to(*l.part, t)) return false;
          moved_ |= uint64_t{1} << l.part->number;
          if (l.part->put(l, part.get(*port), t)) l.part->inputs_changed(t);
          if (l.part->has_pending_outputs()) return false;
        }
      }
    }
  }
  return true;
}

// Whether a data input of a part goes through it alike in all states of the trace, and does nothing
// else. What is found is kept.
bool Rack::Cycles::passes(Trace &trace, Part &part, int field) {
  Trace::Step *step = trace.steps.data();
  while (step->part != &part) ++step;
  if ((step->passing | step->blocked) >> field & 1) return step->passing >> field & 1;
  const auto through = [field](const Transition &t) {
    std::vector<Copy> all;
    for (const Copy &c : t.feedthroughs()) {
      if (c.from == field) all.push_back(c);
    }
    return all;
  };
  const auto same = [](const Copy &a, const Copy &b) {
    return a.to == b.to && a.left == b.left && a.keep == b.keep && a.value == b.value &&
           a.mask == b.mask;
  };
  std::vector<Copy> first;
  bool all = true;
  for (State *state : step->states) {
    if (!state->on_data)
      state->on_data =
          part.learn_from(state, state->inputs, part.fields(), false, state->inputs, false);
    const Transition *clock = state->on_clock, &data = *state->on_data;
    all = all && data.to == state && !data.moves && clock && clock->to &&
          !(clock->sources >> field & 1);
    if (!all) break;
    const std::vector<Copy> copies = through(data);
    if (state == step->from) first = copies;
    all = std::equal(copies.begin(), copies.end(), first.begin(), first.end(), same);
  }
  (all ? step->passing : step->blocked) |= 1u << field;
  return all;
}

// Parts that are not among the steps, but listen, are due, or have encoder edges. False: others
// would notice.
bool Rack::Cycles::follow(Trace &trace) {
  const auto &edges = rack_.edges_;
  const int64_t begin = rack_.clock_, end = begin + trace.end;
  followed_ = 0;
  auto event = trace.events.begin();
  heard_ = trace.card.size();
  auto edge = edges.all.begin() + static_cast<std::ptrdiff_t>(edges.next);
  for (int64_t last = 0;;) {
    const int64_t edge_at = edge != edges.all.end() ? edge->clock + 1 : kNever;
    const int64_t event_at = event != trace.events.end() ? begin + event->clock : kNever;
    if (std::min(edge_at, event_at) > end) break;
    if (edge_at <= event_at) {
      if (edge_at != last) moved_ = 0;
      last = edge_at;
      if (!follow(trace, *edge++)) return false;
      continue;
    }
    Part &part = *event->part;
    if (event_at != last) moved_ = 0;
    last = event_at;
    if (moved_ >> part.number & 1) return false;  // both at once
    if (!go_to(part, last)) return false;
    bool changed = part.put(kNoField, event->bits, event->mask, last);
    for (uint32_t n = 0; n < event->moves; ++n, ++heard_)
      changed |= part.put(trace.moves[heard_].to % kMostFields, values_[heard_], ~0u, last);
    ++event;
    if (changed) part.inputs_changed(last);
    if (part.has_pending_outputs()) return false;
  }
  const uint64_t others = (followed_ | rack_.schedule_.due(end)) & ~trace.parts;
  for (uint64_t rest = others; rest; rest &= rest - 1) {
    if (!go_to(*rack_.parts_[static_cast<size_t>(__builtin_ctzll(rest))], end)) return false;
  }
  return true;
}

// The own card hears the cycle, too. False: it answers, and has heard nothing.
bool Rack::Cycles::tell_card(const Trace &trace) {
  if (!rack_.own_card_) return true;
  OwnCard &card = *rack_.own_card_;
  card.mark();
  const uint32_t *value = values_;
  auto input = trace.card.begin();
  const auto &edges = rack_.edges_;
  auto edge = edges.all.begin() + static_cast<std::ptrdiff_t>(edges.next);
  for (uint32_t clock = 1; clock <= trace.end; ++clock) {
    bool answers = card.active() && card.clock();
    for (; input != trace.card.end() && input->clock == clock; ++input)
      card.put(input->input, *value++);
    for (; edge != edges.all.end() && edge->clock < rack_.clock_ + clock; ++edge) {
      for (int pin = 0; pin < 3; ++pin)
        card.take(static_cast<Port>(kEncA + pin), edge->axis, edge->pins >> pin & 1);
    }
    answers = card.follow() || answers;
    if (answers) {
      card.go_back();
      return false;
    }
  }
  return true;
}

void Rack::Cycles::go_back() {
  for_parts(followed_, [this](Part &part) {
    part.go_back(before_[part.number].now, before_[part.number].fields);
  });
}

}  // namespace mmcs
