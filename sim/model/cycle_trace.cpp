// SPDX-License-Identifier: Apache-2.0
// How a trace is worked out: rack.cpp's way through a cycle, on many values at once (cycle.h).
// Length: parts, nets and time are one pass of one clock.

#include <algorithm>

#include "cycle.h"
#include "cycle_data.h"

namespace mmcs {

class Rack::Cycles::Tracer {
 public:
  explicit Tracer(Cycles &cycles)
      : c_(cycles), r_(cycles.rack_), data_(cycles.data_, cycles.patterns_) {
    for (const auto &part : r_.parts_) {
      part->catch_up(r_.clock_);
      uint32_t &pending = c_.pending_[part->number] |= part->pending_data();
      const uint64_t inputs = part->inputs();
      now_.push_back({part->state(), inputs, part->state()->outputs, pending});
      now_.back().states = {part->state()};
    }
    if (!r_.own_card_) return;
    for (const int net : r_.card_.nets) card_.push_back(data_.start(at(net)));
  }

  // The address; a clock later the strobes, until DTACK* is low; then all is released.
  void work_out(const BusRequest &q) {
    const auto put = [&](Port port, unsigned level) {
      pin(port, port == kVmeD && q.write ? data_.start(c_.request_) : Values::of(level));
    };
    clock([&] { put_address(q.address, q.am, q.write, q.data, false, put); });
    if (dtack() == 0) throw NoTrace{};
    clock([&] { put_strobes(q.ds, put); });
    while (dtack() != 0) clock([] {});
    trace->answered = static_cast<uint16_t>(clocks_);
    sample();
    clock([&] { put_idle(put); });
    while (dtack() == 0) clock([] {});
    clock([] {});
    if (selected_ || command_) throw NoTrace{};
    trace->end = static_cast<uint16_t>(clocks_);
    finish();
  }

  std::unique_ptr<Trace> trace = std::make_unique<Trace>();

 private:
  static constexpr int kMostClocks = 64;
  struct Now {  // a part
    State *state;
    uint64_t inputs, sent;  // of control: inputs, outputs
    uint32_t pending;       // data outputs, by bit
    uint32_t changed = 0;   // data inputs, by bit
    bool active = false;    // it gets every clock
    bool sends = false;
    std::vector<State *> states{};  // all that it was in
    uint64_t put = 0;               // control inputs that the cycle drives, changed or not
  };
  static size_t place(size_t part, int field) {
    return part * kMostFields + static_cast<size_t>(field);
  }
  const uint32_t *fields(size_t part) {
    for (size_t f = 0; f < kMostFields; ++f) fields_[f] = data_.actual(part * kMostFields + f);
    return fields_;
  }

  // --- parts: part.h on many values ----------------------------------------------------------

  // From now on it gets every clock, and those that it has not had.
  void activate(size_t n) {
    Now &p = now_[n];
    if (p.active) return;
    p.active = true;
    for (int t = in_clock_ ? 1 : 0; t < clocks_; ++t) step(n, &p.state->on_clock, true);
  }
  void copy(size_t n, const Copy &c, const Values &from) {
    const DataField &field = r_.parts_[n]->model.fields()[c.to];
    const size_t to = place(n, c.to);
    const auto [before, counted] = data_.at(to);
    Values next;
    for (size_t set = 0; set < next.size(); ++set)
      next[set] = c.apply(before[set], from[set]) & field.mask;
    if (next == before) return;
    if ((field.margin >= 0 && next.varying()) || (counted && c.keep & field.mask)) throw NoTrace{};
    data_.at(to) = {next, false};
    if (field.output) now_[n].pending |= 1u << c.to;
  }
  void step(size_t n, Transition **at, bool clock) {
    Now &p = now_[n];
    Part &part = *r_.parts_[n];
    const Cache &cache = *part.cache;
    if (!*at) *at = part.learn_from(p.state, p.inputs, fields(n), clock, p.inputs, false);
    if ((*at)->decided) {
      for (size_t f : cache.deciding())
        data_.decided(data_.at(place(n, static_cast<int>(f))).values);
      const uint64_t values = cache.values(fields(n));
      at = &(*at)->cases;
      while (*at && (*at)->key != values) at = &(*at)->next;
      if (!*at) *at = part.learn_from(p.state, p.inputs, fields(n), clock, values, true);
    }
    const Transition &t = **at;
    if (!t.to) throw NoTrace{};
    std::vector<Values> from;
    for (const Copy &c : t.copies())
      from.push_back(c.mask ? data_.copied(place(n, c.from)) : Values::of(0));
    const Values *next = from.data();
    for (const Copy &c : t.copies()) copy(n, c, *next++);
    const uint64_t counters = t.near_margin ? cache.counters(fields(n)) : 0;
    for (const Count &c : t.counts()) data_.count(place(n, c.field), c.by, c.mask);
    for (const Copy &c : t.feedthroughs()) {
      if (p.changed >> c.from & 1) copy(n, c, data_.copied(place(n, c.from)));
    }
    p.state = t.to;
    p.states.push_back(p.state);
    // A counter comes to its margin from the actual value alone, even if the next state is known.
    const uint64_t counted = t.near_margin ? cache.counters(fields(n)) : 0;
    if (counted != counters || (t.near_margin && counted != p.state->counters)) throw NoTrace{};
  }
  void inputs_changed(size_t n) {
    Now &p = now_[n];
    note_event(n);
    if (p.inputs == p.state->inputs) {
      const Transition *known = p.state->on_data;
      if (!known || !known->to || known->sources & p.changed) step(n, &p.state->on_data, false);
    } else {
      Transition **at = &p.state->on_inputs;
      while (*at && (*at)->key != p.inputs) at = &(*at)->next;
      step(n, at, false);
    }
    p.changed = 0;
  }
  // As it is made again, if the part only listens.
  void note_event(size_t n) {
    Now &p = now_[n];
    unnoted_ &= ~(uint64_t{1} << n);
    const auto clock = static_cast<uint32_t>(clocks_);
    heard_.push_back({{r_.parts_[n].get(), p.inputs, p.put, clock, 0}, {}});
    for (uint32_t rest = p.changed; rest; rest &= rest - 1) {
      const size_t at = place(n, __builtin_ctz(rest));
      heard_.back().data.emplace_back(at, data_.at(at).values);
    }
  }
  // An input of it, or some bits of one: of a data field, else of the control inputs.
  void put(size_t n, int field, const Values &value, uint32_t mask) {
    const size_t at = place(n, field);
    Values next = data_.at(at).values;
    next.put(value, mask);
    if (next == data_.at(at).values) return;
    activate(n);
    data_.at(at).values = next;
    now_[n].changed |= 1u << field;
    changed_ |= uint64_t{1} << n;
  }
  void put(size_t n, uint64_t bits, uint64_t mask) {
    Now &p = now_[n];
    const uint64_t inputs = (p.inputs & ~mask) | (bits & mask);
    // Of a part that only listens, bits that are put for the first time may have been others.
    if (mask & ~p.put) unnoted_ |= uint64_t{1} << n;
    p.put |= mask;
    if (inputs == p.inputs) return;
    activate(n);
    p.inputs = inputs;
    changed_ |= uint64_t{1} << n;
  }
  template <class Input>
  void put(const Part &part, const Input &to, const Values &value) {
    const auto mask = static_cast<uint32_t>(to.mask);
    if (to.field != kNoField) return put(part.number, to.field, value.rotated(to.shift), mask);
    const uint64_t bits = data_.decided(value);
    put(part.number, bits << to.shift | bits >> (-to.shift & 63), to.mask);
  }

  // --- nets: rack.cpp on many values ---------------------------------------------------------

  size_t at(int net) const { return kFirstNet + 2 * r_.nets_.at(net, 0); }
  bool put_net(int net, int lsb, int width, const Values &value) {
    if (width > 32) throw NoTrace{};
    if (value == data_.bits(at(net), lsb, width)) return false;
    data_.put_bits(at(net), lsb, width, value);
    const bool command = net == r_.pc_bus_.nets[PcBus::kIor] || net == r_.pc_bus_.nets[PcBus::kIow];
    if (r_.pc_bus_.has_net[static_cast<size_t>(net)] && (command || selected_ || command_))
      bus_changed_ = true;
    for (const Reader &r : r_.readers_[static_cast<size_t>(net)]) {
      if (r.lsb < lsb + width && lsb < r.lsb + r.width) update_input(*r.wire, net, r.wire->lsb);
    }
    return true;
  }
  void update_input(const Wire &w, int net, int lsb) {
    put(*w.part, *w.port, data_.bits(at(net), lsb, w.width));
  }
  Values output(const Part &part, const PartPort &port) {
    if (port.data) return data_.copied(place(part.number, port.field));
    const uint64_t outputs = now_[part.number].state->outputs;
    return Values::of(static_cast<uint32_t>((outputs & port.mask) >> port.shift));
  }
  void drive_net(const Wire &w) {
    if (!put_net(w.net, w.lsb, w.width, output(*w.part, *w.port))) return;
    if (w.glue) glue_changed_ = trace->glue = true;
  }
  void send(const Part &part, const PartPort &port) {
    now_[part.number].sends = true;
    if (port.width > 32) throw NoTrace{};
    if (port.wire) drive_net(*port.wire);
    const Values value = output(part, port);
    for (const Link &l : port.links) put(*l.part, l, value);
  }
  void send_outputs(size_t n) {
    Now &p = now_[n];
    const Part &part = *r_.parts_[n];
    uint64_t changed = (p.state->outputs ^ p.sent) & part.observed();
    p.sent = p.state->outputs;
    if (changed & part.line_mask) throw NoTrace{};
    while (changed) {
      const PartPort &port = part.model.port_at(__builtin_ctzll(changed));
      changed &= ~port.mask;
      send(part, port);
    }
    uint32_t data = part.observed_data(p.pending, p.state->outputs);
    p.pending &= ~data;
    for (; data; data &= data - 1) {
      if (const PartPort *port = part.model.port_of(__builtin_ctz(data))) send(part, *port);
    }
  }
  void update_pc_bus() {
    auto &bus = r_.pc_bus_;
    bus_changed_ = false;
    Values values[PcBus::kSignals];
    for (size_t n = 0; n < PcBus::kSignals; ++n)
      values[n] = data_.bits(at(bus.nets[n]), 0, PcBus::kWidth[n]);
    const auto control = [&](int signal) { return data_.decided(values[signal]); };
    command_ = !(control(PcBus::kIor) && control(PcBus::kIow));
    uint32_t selected = 0;
    if (command_) {
      selected = bus.decoder.select(control(PcBus::kAddress), control(PcBus::kAen),
                                    control(PcBus::kIor), control(PcBus::kIow), bus.dips);
    }
    for (uint32_t rest = selected | selected_; rest; rest &= rest - 1) {
      for (const auto &[wire, signal] : bus.cards[static_cast<size_t>(__builtin_ctz(rest))])
        update_input(*wire, bus.nets[signal], 0);
    }
    selected_ = selected;
  }
  // Returns the data that the bus master reads.
  Values eval_glue() {
    glue_changed_ = false;
    std::vector<Values> inputs, outputs(r_.glue_nets_.size());
    for (const Wire *w : r_.glue_wires_) {
      inputs.push_back(data_.bits(at(w->net), w->lsb, w->width));
      if (!w->port->data) inputs.back() = Values::of(data_.decided(inputs.back()));
    }
    Values read;
    for (size_t set = 0; set < read.size(); ++set) {
      for (size_t n = 0; n < inputs.size(); ++n) r_.glue_wires_[n]->glue.put(inputs[n][set]);
      r_.glue_.eval();
      for (size_t n = 0; n < outputs.size(); ++n)
        outputs[n][set] = static_cast<uint32_t>(r_.glue_nets_[n].first.get());
      read[set] = static_cast<uint32_t>(r_.vme_data_.get());
    }
    for (size_t n = 0; n < outputs.size(); ++n)
      put_net(r_.glue_nets_[n].second, 0, r_.glue_nets_[n].first.width, outputs[n]);
    return read;
  }
  void settle() {
    for (;;) {
      if (bus_changed_) {
        update_pc_bus();
      } else if (glue_changed_) {
        eval_glue();
      } else if (changed_ != 0) {
        const size_t n = static_cast<size_t>(__builtin_ctzll(changed_));
        changed_ &= changed_ - 1;
        inputs_changed(n);
        send_outputs(n);
      } else if (unnoted_ != 0) {
        note_event(static_cast<size_t>(__builtin_ctzll(unnoted_)));
      } else {
        return;
      }
    }
  }

  // --- time ----------------------------------------------------------------------------------

  template <class F>
  void clock(F pins) {
    if (++clocks_ > kMostClocks) throw NoTrace{};
    in_clock_ = true;
    for (size_t n = 0; n < now_.size(); ++n) {
      if (r_.parts_[n]->due() <= r_.clock_ + clocks_) activate(n);
      if (now_[n].active) step(n, &now_[n].state->on_clock, true);
    }
    in_clock_ = false;
    for (size_t n = 0; n < now_.size(); ++n) {
      if (now_[n].active) send_outputs(n);
    }
    pins();
    settle();
    if (r_.own_card_) note_card();
  }
  // Inputs of the own card that are others after this clock.
  void note_card() {
    for (size_t n = 0; n < card_.size(); ++n) {
      const Values &now = data_.at(at(r_.card_.nets[n])).values;
      if (!r_.own_card_->has(n) || now == card_[n]) continue;
      card_[n] = now;
      trace->card.push_back({static_cast<uint32_t>(clocks_), static_cast<uint32_t>(n)});
      data_.add_move(at(r_.card_.nets[n]), now, true, trace.get());
    }
  }
  void pin(Port port, const Values &value) {
    const Input &input = r_.inputs_[port];
    for (unsigned n = input.fields[0]; n < input.fields[1]; ++n)
      put(*input.arrivals[n].part, input.arrivals[n], value);
  }
  unsigned dtack() { return output(*r_.dtack_->part, *r_.dtack_->port).actual(); }
  void sample() {
    for (const Wire *w : r_.vme_data_wires_) drive_net(*w);
    data_.at(c_.reply_).values.put(eval_glue(), 0xFFFF);
  }

  // --- what becomes of it --------------------------------------------------------------------

  void finish() {
    for (size_t n = 0; n < now_.size(); ++n) {
      const Now &p = now_[n];
      if (!p.sends) continue;
      Part &part = *r_.parts_[n];
      if (p.inputs != p.state->inputs) throw NoTrace{};
      trace->parts |= uint64_t{1} << n;
      trace->steps.push_back(
          {&part, part.state(), p.state, c_.pending_[n], p.pending, p.states, 0, 0});
    }
    for (const Heard &heard : heard_) {
      if (now_[heard.event.part->number].sends) continue;
      trace->events.push_back(heard.event);
      trace->events.back().moves = static_cast<uint32_t>(heard.data.size());
      for (const auto &[at, values] : heard.data) data_.add_move(at, values, true, trace.get());
    }
    for (const auto &[at, entry] : data_.all()) {
      if ((at < kFirstNet && !now_[at / kMostFields].sends) || entry.values == data_.start(at))
        continue;
      if (entry.counted)
        add_sum(at, entry.values);
      else
        data_.add_move(at, entry.values, false, trace.get());
    }
    for (const Term &t : trace->terms) {
      if (t.place < kFirstNet && !now_[t.place / kMostFields].sends) throw NoTrace{};
    }
    if (trace->moves.size() > Trace::kMostMoves) throw NoTrace{};
    trace->conditions = data_.conditions;
  }
  void add_sum(size_t at, const Values &now) {
    const DataField &field = r_.parts_[at / kMostFields]->model.fields()[at % kMostFields];
    const Values before = data_.start(at);
    const uint32_t by = (now.actual() - before.actual()) & field.mask;
    for (size_t set = 0; set < now.size(); ++set) {
      if (((now[set] - before[set]) & field.mask) != by) throw NoTrace{};
    }
    trace->sums.push_back({static_cast<Place>(at), by, field.mask});
    if (field.margin < 0) return;
    const uint32_t slack = static_cast<uint32_t>(2 * clocks_ + 4);
    trace->rooms.push_back({static_cast<Place>(at), static_cast<uint32_t>(field.margin) + slack,
                            field.mask - std::min(field.mask, slack)});
  }

  Cycles &c_;
  Rack &r_;
  CycleData data_;
  std::vector<Now> now_;  // of each part
  struct Heard {
    Trace::Event event;
    std::vector<std::pair<size_t, Values>> data;
  };
  std::vector<Heard> heard_;
  std::vector<Values> card_;  // inputs of the own card, as it had them last
  uint32_t fields_[kMostFields];
  int clocks_ = 0;
  bool in_clock_ = false;  // not all parts have had this one
  uint64_t changed_ = 0;   // parts with inputs that changed, by bit
  uint64_t unnoted_ = 0;   // parts with inputs that were put but have no event, by bit
  bool bus_changed_ = false, glue_changed_ = false, command_ = false;
  uint32_t selected_ = 0;  // cards, by bit
};

// Null: it finds none.
std::unique_ptr<Trace> Rack::Cycles::work_out(const BusRequest &q) {
  try {
    Tracer tracer(*this);
    tracer.work_out(q);
    return std::move(tracer.trace);
  } catch (const NoTrace &) {
    return nullptr;
  }
}

}  // namespace mmcs
