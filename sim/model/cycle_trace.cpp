// SPDX-License-Identifier: Apache-2.0
// How a trace is worked out: rack.cpp's way through a cycle, on the origin of data (cycle.h).
// Length: parts, nets and time are one pass of one clock.

#include <algorithm>

#include "cycle.h"
#include "cycle_words.h"

namespace mmcs {

class Rack::Cycles::Tracer {
 public:
  explicit Tracer(Cycles &cycles)
      : c_(cycles), r_(cycles.rack_), words_(cycles.data_, cycles.masks_) {
    for (const auto &part : r_.parts_) {
      part->catch_up(r_.clock_);
      if (!part->state()) throw NoTrace{};
      uint32_t &pending = c_.pending_[part->number] |= part->pending_data();
      const uint64_t inputs = part->inputs();
      now_.push_back({part->state(), inputs, part->state()->outputs, pending});
      now_.back().states = {part->state()};
    }
    if (!r_.own_card_) return;
    for (const int net : r_.card_.nets) card_.push_back(words_.own(at(net)));
  }

  // The address; a clock later the strobes, until DTACK* is low; then all is released.
  void work_out(const BusRequest &q) {
    const auto put = [&](Port port, unsigned level) {
      pin(port, port == kVmeD && q.write ? words_.own(c_.request_) : Word::of(level));
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
  static constexpr int kMostClocks = 64, kMostRounds = 1000;
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
    for (size_t f = 0; f < kMostFields; ++f) fields_[f] = words_.value_of(part * kMostFields + f);
    return fields_;
  }

  // --- parts: part.h on words ----------------------------------------------------------------

  // From now on it gets every clock, and those that it has not had.
  void activate(size_t n) {
    Now &p = now_[n];
    if (p.active) return;
    p.active = true;
    for (int t = in_clock_ ? 1 : 0; t < clocks_; ++t) step(n, &p.state->on_clock, true);
  }
  void copy(size_t n, const Copy &c, const Word &from) {
    const DataField &field = r_.parts_[n]->model.fields()[c.to];
    const size_t to = place(n, c.to);
    Word next = words_.word(to).moved(0, c.keep & field.mask);
    next.constant ^= c.value & field.mask;
    if (c.mask) next.add(from.moved(c.left, c.mask & field.mask));
    if (next == words_.word(to)) return;
    if (field.margin >= 0 && next.count != 0) throw NoTrace{};
    if (words_.at(to).by && c.keep & field.mask) throw NoTrace{};
    words_.at(to) = {next, 0, 0};
    if (field.output) now_[n].pending |= 1u << c.to;
  }
  void step(size_t n, Transition **at, bool clock) {
    Now &p = now_[n];
    Part &part = *r_.parts_[n];
    const Cache &cache = *part.cache;
    if (!*at) *at = part.learn_from(p.state, p.inputs, fields(n), clock, p.inputs, false);
    if ((*at)->decided) {
      for (size_t f : cache.deciding()) words_.decided(words_.word(place(n, static_cast<int>(f))));
      const uint64_t values = cache.values(fields(n));
      at = &(*at)->cases;
      while (*at && (*at)->key != values) at = &(*at)->next;
      if (!*at) *at = part.learn_from(p.state, p.inputs, fields(n), clock, values, true);
    }
    const Transition &t = **at;
    if (!t.to) throw NoTrace{};
    std::vector<Word> from;
    for (const Copy &c : t.copies())
      from.push_back(c.mask ? words_.copied(place(n, c.from)) : Word{});
    const Word *next = from.data();
    for (const Copy &c : t.copies()) copy(n, c, *next++);
    for (const Count &c : t.counts()) words_.count(place(n, c.field), c.by, c.mask);
    for (const Copy &c : t.feedthroughs()) {
      if (p.changed >> c.from & 1) copy(n, c, words_.copied(place(n, c.from)));
    }
    p.state = t.to;
    p.states.push_back(p.state);
    if (t.near_margin && cache.counters(fields(n)) != p.state->counters) throw NoTrace{};
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
    Heard heard{{r_.parts_[n].get(), p.inputs, p.put, clock, 0}, {}};
    for (uint32_t rest = p.changed; rest; rest &= rest - 1) {
      const size_t at = place(n, __builtin_ctz(rest));
      heard.data.emplace_back(at, words_.word(at));
    }
    heard_.push_back(heard);
  }
  // An input of it, or some bits of one: of a data field, else of the control inputs.
  void put(size_t n, int field, const Word &value, uint32_t mask) {
    const size_t at = place(n, field);
    Word next = words_.word(at).moved(0, ~mask);
    next.add(value.moved(0, mask));
    if (next == words_.word(at)) return;
    activate(n);
    words_.at(at).word = next;
    now_[n].changed |= 1u << field;
    changed_ |= uint64_t{1} << n;
  }
  void put(size_t n, uint64_t bits, uint64_t mask) {
    Now &p = now_[n];
    const uint64_t inputs = (p.inputs & ~mask) | (bits & mask), anew = mask & ~p.put;
    p.put |= mask;
    // Of a part that only listens, bits that are put for the first time may have been others
    // before.
    if (anew) unnoted_ |= uint64_t{1} << n;
    if (inputs == p.inputs) return;
    activate(n);
    p.inputs = inputs;
    changed_ |= uint64_t{1} << n;
  }
  void put(const Part &part, int field, int shift, uint64_t mask, const Word &value, int width) {
    if (field != kNoField) return put(part.number, field, value, low_bits(width));
    put(part.number, uint64_t{words_.decided(value)} << shift, mask);
  }

  // --- nets: rack.cpp on words ---------------------------------------------------------------

  size_t at(int net) const { return kFirstNet + 2 * r_.nets_.at(net, 0); }
  bool put_net(int net, int lsb, int width, const Word &value) {
    if (width > 32) throw NoTrace{};
    if (value == words_.bits(at(net), lsb, width)) return false;
    words_.put_bits(at(net), lsb, width, value);
    const bool command = net == r_.pc_bus_.nets[PcBus::kIor] || net == r_.pc_bus_.nets[PcBus::kIow];
    if (r_.pc_bus_.has_net[static_cast<size_t>(net)] && (command || selected_ || command_))
      bus_changed_ = true;
    for (const Reader &r : r_.readers_[static_cast<size_t>(net)]) {
      if (r.lsb < lsb + width && lsb < r.lsb + r.width) update_input(*r.wire, net, r.wire->lsb);
    }
    return true;
  }
  void update_input(const Wire &w, int net, int lsb) {
    const PartPort &port = *w.port;
    put(*w.part, port.field, port.shift, port.mask, words_.bits(at(net), lsb, w.width), w.width);
  }
  Word output(const Part &part, const PartPort &port) {
    if (port.data)
      return words_.copied(place(part.number, port.field)).moved(0, low_bits(port.width));
    const uint64_t outputs = now_[part.number].state->outputs;
    return Word::of(static_cast<uint32_t>((outputs & port.mask) >> port.shift));
  }
  void drive_net(const Wire &w) {
    if (!put_net(w.net, w.lsb, w.width, output(*w.part, *w.port))) return;
    if (w.glue) glue_changed_ = trace->glue = true;
  }
  void send(const Part &part, const PartPort &port) {
    now_[part.number].sends = true;
    if (port.width > 32) throw NoTrace{};
    if (port.wire) drive_net(*port.wire);
    const Word value = output(part, port);
    for (const Link &l : port.links) put(*l.part, l.field, l.shift, l.mask, value, port.width);
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
    constexpr int kWidth[PcBus::kSignals] = {16, 1, 1, 1, 8};
    Word values[PcBus::kSignals];
    for (size_t n = 0; n < PcBus::kSignals; ++n)
      values[n] = words_.bits(at(bus.nets[n]), 0, kWidth[n]);
    const auto control = [&](int signal) { return words_.decided(values[signal]); };
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
  void eval_glue() {
    glue_changed_ = false;
    const std::vector<Word> outputs = c_.glue_outputs(words_);
    for (size_t n = 0; n < r_.glue_nets_.size(); ++n)
      put_net(r_.glue_nets_[n].second, 0, r_.glue_nets_[n].first.width, outputs[n]);
  }
  void settle() {
    for (int rounds = 0; rounds < kMostRounds; ++rounds) {
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
    throw NoTrace{};
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
      const Word &now = words_.word(at(r_.card_.nets[n]));
      if (!r_.own_card_->has(n) || now == card_[n]) continue;
      card_[n] = now;
      trace->card.push_back({static_cast<uint32_t>(clocks_), static_cast<uint32_t>(n)});
      add_move(at(r_.card_.nets[n]), now, true);
    }
  }
  void pin(Port port, const Word &value) {
    const Input &input = r_.inputs_[port];
    for (unsigned n = input.fields[0]; n < input.fields[1]; ++n) {
      const Arrival &to = input.arrivals[n];
      if (to.field != kNoField) {
        put(to.part->number, to.field, value.moved(to.left, static_cast<uint32_t>(to.mask)),
            static_cast<uint32_t>(to.mask));
      } else {
        const uint64_t bits = words_.decided(value);
        put(to.part->number, bits << to.left | bits >> (-to.left & 63), to.mask);
      }
    }
  }
  unsigned dtack() const {
    const PartPort &port = *r_.dtack_->port;
    return (now_[r_.dtack_->part->number].state->outputs & port.mask) != 0;
  }
  void sample() {
    for (const Wire *w : r_.vme_data_wires_) drive_net(*w);
    words_.at(c_.reply_).word = c_.glue_outputs(words_).back().moved(0, 0xFFFF);
    if (glue_changed_) eval_glue();
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
      for (const auto &[at, word] : heard.data) add_move(at, word, true);
    }
    for (const auto &[at, entry] : words_.all()) {
      if (at < kFirstNet && !now_[at / kMostFields].sends) continue;
      if (!(entry.word == words_.own(at))) add_move(at, entry.word, false);
      if (entry.by) add_sum(at, entry);
    }
    if (trace->moves.size() > Trace::kMostMoves) throw NoTrace{};
    trace->conditions = words_.conditions;
  }
  void add_sum(size_t at, const Words::Entry &sum) {
    trace->sums.push_back({static_cast<Place>(at), sum.by, sum.mask});
    const int margin = r_.parts_[at / kMostFields]->model.fields()[at % kMostFields].margin;
    if (margin < 0) return;
    const uint32_t slack = static_cast<uint32_t>(2 * clocks_ + 4);
    trace->rooms.push_back({static_cast<Place>(at), static_cast<uint32_t>(margin) + slack,
                            sum.mask - std::min(sum.mask, slack)});
  }
  void add_move(size_t at, const Word &word, bool of_event) {
    Trace::Move move{static_cast<Place>(at), 0, 0, word.constant};
    for (const Term &t : word) {
      if (t.place == at && t.left == 0) {
        move.keep = t.mask;
        continue;
      }
      if (t.place < kFirstNet && !now_[t.place / kMostFields].sends) throw NoTrace{};
      trace->terms.push_back(t);
      ++move.terms;
    }
    if (move.terms == 0 && !of_event) {
      trace->constants.push_back({move.to, move.keep, move.constant});
    } else {
      trace->moves.push_back(move);
    }
  }

  Cycles &c_;
  Rack &r_;
  Words words_;
  std::vector<Now> now_;  // of each part
  struct Heard {
    Trace::Event event;
    std::vector<std::pair<size_t, Word>> data;
  };
  std::vector<Heard> heard_;
  std::vector<Word> card_;  // inputs of the own card, as it had them last
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
