// SPDX-License-Identifier: Apache-2.0
// See rack.h.

#include "rack.h"

#include "cycle.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace mmcs {
namespace {

constexpr int kResetClks = 64;

// The caches of machines that have ended, for the next one of this process.
struct Reserve {
  std::mutex mutex;
  std::vector<std::map<std::string, std::shared_ptr<Cache>>> sets;
};
Reserve &reserve() {
  static Reserve *found = new Reserve;  // never deleted: a machine may end after all else
  return *found;
}

}  // namespace

Rack::Rack(bool skip, uint64_t seed, const std::string &card)
    : context_(create_context(seed)), skip_(skip), nets_(&data_[kFirstNet]) {
  open_card(card);
  if (!own_card_) {  // which observes outputs that nothing else does; a cache knows which are
    const std::lock_guard<std::mutex> lock(reserve().mutex);
    if (!reserve().sets.empty()) {
      caches_ = std::move(reserve().sets.back());
      reserve().sets.pop_back();
    }
  }
  for (const BoardInfo &board : kWires.boards) add_parts(board);
  if (const char *hits = std::getenv("MMCS_CHECK"))
    check(static_cast<int>(std::strtol(hits, nullptr, 10)));
  wire();
  pull_cards();
  power_on();
}

// The machine of the speed build; those of the others, checked.cpp and plain.cpp, take its place.
__attribute__((weak)) std::unique_ptr<Model> Model::create(bool skip, uint64_t seed,
                                                           const std::string &card) {
  return std::make_unique<Rack>(skip, seed, card);
}

Rack::~Rack() {
  use(context_);
  if (own_card_) return;
  const std::lock_guard<std::mutex> lock(reserve().mutex);
  reserve().sets.push_back(std::move(caches_));
}

// --- nets ------------------------------------------------------------------------------------

void Rack::put_net(int net, int lsb, int width, uint64_t value) {
  if (!nets_.put(net, lsb, width, value)) return;
  const size_t n = static_cast<size_t>(net);
  // Without a command no card is selected, and data and addresses do not matter.
  const bool command = net == pc_bus_.nets[PcBus::kIor] || net == pc_bus_.nets[PcBus::kIow];
  if (pc_bus_.has_net[n] && (command || pc_bus_.selected || pc_bus_.command))
    pc_bus_.changed = true;
  if (own_card_) card_.changed = true;
  for (const Reader &r : readers_[n]) {
    if (r.lsb < lsb + width && lsb < r.lsb + r.width) update_input(*r.wire);
  }
}

void Rack::update_input(Wire &wire) {
  put_input(*wire.part, *wire.port, wire.through(nets_.get(wire.net, wire.lsb, wire.width)));
}

void Rack::drive_net(Wire &wire) {
  const uint64_t value = wire.value();
  if (value == nets_.get(wire.net, wire.lsb, wire.width)) return;
  if (wire.glue) {
    wire.glue.put(value);
    glue_changed_ = true;
  }
  put_net(wire.net, wire.lsb, wire.width, value);
}

void Rack::eval_glue() {
  glue_changed_ = false;
  if (glue_stale_) {
    for (const Wire *w : glue_wires_) w->glue.put(nets_.get(w->net, w->lsb, w->width));
    glue_stale_ = false;
  }
  glue_.eval();
  for (const auto &[from, to] : glue_nets_) put_net(to, 0, from.width, from.get());
}

// Inputs of the own card, which stands last: all else is settled.
void Rack::eval_card() {
  card_.changed = false;
  constexpr int kWidest = 16;  // of these nets
  for (size_t n = 0; n < std::size(card_.nets); ++n) {
    own_card_->put(n, nets_.get(card_.nets[n], 0, kWidest));
  }
  if (!own_card_->follow()) return;
  if (++card_.rounds < OwnCard::kMostRounds) return send_card();
  failure_ = OwnCard::kUnstable;
}

void Rack::send_card() {
  const OwnCard &card = *own_card_;
  glue_.put_card(card.output(OwnCard::kData), card.output(OwnCard::kDataOe) != 0,
                 card.output(OwnCard::kIrq));
  glue_changed_ = true;
  put_net(card_.wait, 0, 1, card.output(OwnCard::kWait));
  look_at_card();
}

// Observed outputs of a part that have changed go to other parts and to nets.
void Rack::send_outputs(Part &part) {
  const auto send = [this, &part](const PartPort &port) {
    if (port.wire) drive_net(*port.wire);
    const uint64_t value = part.get(port);
    for (const Link &link : port.links) put_input(*link.part, link, value);
  };
  uint64_t changed = part.take_outputs();
  if (changed & part.line_mask) update_lines();
  while (changed) {
    const PartPort &port = part.model.port_at(__builtin_ctzll(changed));
    changed &= ~port.mask;
    send(port);
  }
  for (uint32_t fields = part.take_data_outputs(); fields; fields &= fields - 1) {
    if (const PartPort *port = part.model.port_of(__builtin_ctz(fields))) send(*port);
  }
}

void Rack::update_lines() {
  unsigned lines = 0;
  for (const auto &[wire, bit] : line_wires_) lines |= static_cast<unsigned>(wire->get()) << bit;
  shown_lines_ = lines ^ kLineIrq;
}

// Recomputes which cards the address selects. They get the bus, and those that were selected until
// now. A card that is not selected keeps its old bus inputs, which may be a command that ended when
// its switches changed: then all cards get the bus.
void Rack::update_pc_bus() {
  auto &bus = pc_bus_;
  bus.changed = false;
  unsigned changed = 0;
  for (size_t n = 0; n < PcBus::kSignals; ++n) {
    const unsigned before = bus.values[n];
    bus.values[n] = static_cast<unsigned>(nets_.get(bus.nets[n], 0, PcBus::kWidth[n]));
    changed |= unsigned{bus.values[n] != before} << n;
  }
  bus.command = !(bus.values[PcBus::kIor] && bus.values[PcBus::kIow]);
  const uint32_t had_bus = bus.switches_changed ? 0 : bus.selected;
  uint32_t get_bus = bus.selected, selected = 0;
  if (bus.switches_changed) {
    bus.switches_changed = false;
    bus.decoder.forget();
    const std::vector<unsigned> before = bus.dips;
    for (size_t card = 0; card < bus.switches.size(); ++card) {
      const auto &[part, port] = bus.switches[card];
      bus.dips[card] = static_cast<unsigned>(part->get(*port));
    }
    if (bus.dips != before) cycles_.reset();
    get_bus = (1u << bus.cards.size()) - 1;
  }
  if (bus.command)
    selected = bus.decoder.select(bus.values[PcBus::kAddress], bus.values[PcBus::kAen],
                                  bus.values[PcBus::kIor], bus.values[PcBus::kIow], bus.dips);
  for (uint32_t rest = selected | get_bus; rest; rest &= rest - 1) {
    const int card = __builtin_ctz(rest);
    for (const auto &[wire, signal] : bus.cards[static_cast<size_t>(card)]) {
      if (had_bus >> card & 1 && !(changed >> signal & 1)) continue;
      put_input(*wire->part, *wire->port, wire->through(bus.values[signal]));
    }
  }
  bus.selected = selected;
}

// Evaluates what has changed inputs after edge clock_, until nothing changes.
void Rack::settle() {
  card_.rounds = 0;
  for (;;) {
    if (pc_bus_.changed) {
      update_pc_bus();
    } else if (glue_changed_) {
      eval_glue();
    } else if (changed_inputs_ != 0) {
      Part &part = *parts_[static_cast<size_t>(__builtin_ctzll(changed_inputs_))];
      changed_inputs_ &= changed_inputs_ - 1;
      if (stopped_) part.pass(clock_);
      if (part.inputs_changed(clock_)) plan(part);
      if (part.has_pending_outputs()) send_outputs(part);
    } else if (card_.changed) {
      eval_card();
    } else {
      return;
    }
  }
}

// --- time ------------------------------------------------------------------------------------

// The first edge at which a part is due.
int64_t Rack::first_due() {
  if (stopped_) return kNever;
  if (schedule_.any_next() || !skip_ || (own_card_ && own_card_->active())) return clock_ + 1;
  return schedule_.first_later();
}

void Rack::step(int64_t t) {
  uint64_t due = skip_ ? schedule_.due(t) : all_parts_;
  if (stopped_) due = 0;
  clock_ = t;
  ++evals_;
  stop_lines_ = lines_ != shown_lines_;
  lines_ = shown_lines_;
  // All parts see their inputs as they were; then outputs change.
  uint64_t sending = 0;
  for (uint64_t rest = due; rest; rest &= rest - 1) {
    Part &part = *parts_[static_cast<size_t>(__builtin_ctzll(rest))];
    part.clock(t);
    plan(part);
    if (part.has_pending_outputs()) sending |= rest & -rest;
  }
  if (own_card_ && own_card_->active() && !stopped_ && own_card_->clock()) send_card();
  for (uint64_t rest = sending; rest; rest &= rest - 1) {
    send_outputs(*parts_[static_cast<size_t>(__builtin_ctzll(rest))]);
  }
  apply_inputs_until(t);
  settle();
  if (!watched_.empty()) compare_watched();
}

// No part gets a clock, and no counter counts; what pins do without a clock is done.
void Rack::stop_clock(bool stopped) {
  if (stopped == stopped_) return;
  for (const auto &part : parts_) {
    if (stopped) {
      part->catch_up(clock_);
    } else {
      part->pass(clock_);
    }
    part->plan();
  }
  stopped_ = stopped;
  schedule_.clear();
  for (const auto &part : parts_) plan(*part);
}

bool Rack::expect(std::vector<EncoderEdge> &edges) {
  if (!skip_) return false;
  edges_.all.swap(edges);
  edges_.next = 0;
  edges_.plan();
  return true;
}

void Rack::apply_edges(int64_t t) {
  for (; edges_.at <= t; ++edges_.next, edges_.plan()) {
    const EncoderEdge &edge = edges_.all[edges_.next];
    pins_.move_encoder(edge.axis, edge.pins);
  }
}

Stop Rack::run(int64_t n, int dtack, int64_t *ran) {
  const int64_t begin = clock_;
  Stop stop = Stop::kDone;
  const unsigned wanted = static_cast<unsigned>(dtack);
  // A level that DTACK* has already ends the run after the first clock, if it still has it then.
  const bool has_level = dtack >= 0 && dtack_level() == wanted;
  if ((++runs_ & 1023) == 0) {
    for (const auto &part : parts_) {
      if (part->cache->full()) forget(*part->cache);
    }
  }
  while (clock_ < begin + n) {
    const int64_t end = begin + (has_level && clock_ == begin ? 1 : n);
    const bool next = pins_.waiting() || lines_ != shown_lines_;
    const int64_t t = next ? clock_ + 1 : first_due();
    if (edges_.at < t && edges_.at <= end) {
      clock_ = edges_.at;
      apply_inputs_until(clock_);
      settle();
    } else if (t > end) {
      clock_ = end;
    } else {
      step(t);
      if (stop_lines_) {
        stop_lines_ = false;
        stop = Stop::kLines;
        break;
      }
    }
    if (dtack >= 0 && dtack_level() == wanted) {
      stop = Stop::kDtack;
      break;
    }
  }
  *ran = clock_ - begin;
  return stop;
}

// Empties a cache. The state of each of its parts is in the model meanwhile.
void Rack::forget(Cache &cache) {
  cycles_.reset();
  for (const auto &part : parts_) {
    if (part->cache.get() != &cache) continue;
    if (!stopped_) part->catch_up(clock_);
    part->load();
  }
  cache.clear();
  for (const auto &part : parts_) {
    if (part->cache.get() != &cache) continue;
    part->store();
    part->plan();
    plan(*part);
  }
}

void Rack::power_on() {
  clock_ = -kResetClks;
  const int reset = Nets::find("rst_ni"), clk = Nets::find("clk_i");
  put_net(clk, 0, 1, 1);
  pins_.power_on();
  pins_.set(Pin::kSysreset, 0, 1);
  pins_.apply();
  for (const auto &part : parts_) {
    part->model.board->eval();
    part->load();
    part->written(clock_);
    inputs_changed(*part);
    send_outputs(*part);
  }
  if (own_card_) send_card();
  Rack::follow_card();
  for (int i = 0; i < kResetClks; ++i) {
    if (i == 8) {
      put_net(reset, 0, 1, 1);
      settle();
    }
    if (i == kResetClks / 2) pins_.set(Pin::kSysreset, 0, 0);
    step(clock_ + 1);
  }
  evals_ = 0;
}

}  // namespace mmcs
