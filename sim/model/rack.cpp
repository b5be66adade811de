// SPDX-License-Identifier: Apache-2.0
// See rack.h.

#include "rack.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace mmcs {
namespace {

constexpr int kResetClks = 64;
constexpr int64_t kSoon = 4096;  // clocks

// What machines that are no more have learned, for the next one of this process.
struct Shelf {
  std::mutex mutex;
  std::vector<std::map<std::string, std::shared_ptr<Cache>>> sets;
};
Shelf &shelf() {
  static Shelf *found = new Shelf;  // for good: a machine may end after all else
  return *found;
}

}  // namespace

Rack::Rack(bool slow, bool skip, uint64_t seed)
    : context_(create_context(seed)), wires_(*this), slow_(slow), skip_(skip && !slow) {
  {
    const std::lock_guard<std::mutex> lock(shelf().mutex);
    if (!shelf().sets.empty()) {
      caches_ = std::move(shelf().sets.back());
      shelf().sets.pop_back();
    }
  }
  for (const BoardInfo &board : kWires.boards) add_parts(board);
  if (const char *hits = std::getenv("MMCS_CHECK"))
    check(static_cast<int>(std::strtol(hits, nullptr, 10)));
  if (parts_.size() > 64) throw std::logic_error("a machine of more than 64 parts");
  wire();
}

Rack::~Rack() {
  use(context_);
  const std::lock_guard<std::mutex> lock(shelf().mutex);
  shelf().sets.push_back(std::move(caches_));
}

// --- nets ------------------------------------------------------------------------------------

void Rack::changed(int net, int lsb, int width) {
  const size_t n = static_cast<size_t>(net);
  if (on_bus_[n] && (net == bus_[2] || net == bus_[3] || listening_ || commanded_))
    bus_moved_ = true;
  for (int l : followers_[n]) {
    if (!due_[static_cast<size_t>(l)]) {
      due_[static_cast<size_t>(l)] = 1;
      logic_.push_back(l);
    }
  }
  for (const Reader &r : readers_[n]) {
    if (r.lsb < lsb + width && lsb < r.lsb + r.width) show(*r.wire);
  }
}

// The net's value at an input.
void Rack::show(Wire &wire) {
  arrive(*wire.part, *wire.port, wire.through(wires_.get(wire.net, wire.lsb, wire.width)));
}

// An output that has moved takes its net along.
void Rack::drive(Wire &wire) {
  const uint64_t value = wire.value();
  if (value == wire.shown) return;
  wire.shown = value;
  wires_.put(wire.net, wire.lsb, wire.width, value);
}

// What of a part's outputs has moved goes where it is seen.
void Rack::tell(Part &part) {
  const auto send = [this, &part](const PartPort &port) {
    if (port.wire) drive(*port.wire);
    const uint64_t value = part.get(port);
    for (const Link &link : port.links) arrive(*link.part, link, value);
  };
  uint64_t moved = part.take_out();
  if (moved & part.line_mask) look_at_lines();
  while (moved) {
    const PartPort &port = part.port_at(__builtin_ctzll(moved));
    moved &= ~port.mask;
    send(port);
  }
  for (uint32_t cells = part.take_cells(); cells; cells &= cells - 1) {
    if (const PartPort *port = part.port_of(__builtin_ctz(cells))) send(*port);
  }
}

void Rack::look_at_lines() {
  unsigned lines = 0;
  for (const auto &[wire, bit] : lines_of_) lines |= static_cast<unsigned>(wire->get()) << bit;
  shown_lines_ = lines ^ kLineIrq;
}

// Which cards hear the bus now; those that heard it until now see it end. A deaf card keeps what it
// saw last, which may be a command that its switches made it deaf to: when one moves, all look.
void Rack::listen() {
  bus_moved_ = false;
  constexpr int kWidth[kBusPorts] = {16, 1, 1, 1, 8};  // as in kBus
  unsigned bus[kBusPorts];
  uint32_t now = 0, looking = listening_;
  unsigned moved = 0;
  for (size_t n = 0; n < kBusPorts; ++n) {
    bus[n] = static_cast<unsigned>(wires_.get(bus_[n], 0, kWidth[n]));
    moved |= unsigned{bus[n] != heard_bus_[n]} << n;
    heard_bus_[n] = bus[n];
  }
  commanded_ = !(bus[2] && bus[3]);
  const uint32_t known = dips_moved_ ? 0 : listening_;  // they saw what was on it
  if (dips_moved_) {
    dips_moved_ = false;
    ears_.forget();
    for (size_t card = 0; card < dips_.size(); ++card) {
      dip_values_[card] = static_cast<unsigned>(dips_[card].first->get(*dips_[card].second));
    }
    looking = (1u << heard_.size()) - 1;
  }
  if (commanded_) now = ears_.hear(bus[0], bus[1], bus[2], bus[3], dip_values_);
  for (uint32_t rest = now | looking; rest; rest &= rest - 1) {
    const int card = __builtin_ctz(rest);
    for (const auto &[wire, net] : heard_[static_cast<size_t>(card)]) {
      if (known >> card & 1 && !(moved >> net & 1)) continue;
      arrive(*wire->part, *wire->port, wire->through(bus[net]));
    }
  }
  listening_ = now;
}

// Until nothing follows any more, after edge clock_.
void Rack::settle() {
  for (;;) {
    if (bus_moved_) {
      listen();
    } else if (!logic_.empty()) {
      const int l = logic_.back();
      logic_.pop_back();
      due_[static_cast<size_t>(l)] = 0;
      kWires.logic[static_cast<size_t>(l)].run(wires_);
    } else if (touched_ != 0) {
      Part &part = *parts_[static_cast<size_t>(__builtin_ctzll(touched_))];
      touched_ &= touched_ - 1;
      if (stopped_) part.pass(clock_);
      if (part.follow(clock_)) plan(part);
      if (part.tells()) tell(part);
    } else {
      return;
    }
  }
}

// --- time ------------------------------------------------------------------------------------

// A part may be due at another edge than before.
void Rack::plan(const Part &part) {
  const uint64_t bit = uint64_t{1} << part.number;
  const int64_t edge = part.due();
  int64_t &before = due_at_[part.number];
  if ((due_soon_ | due_late_) & bit) {
    if (edge == before) return;
    if (before == first_later_) first_later_ = 0;
    due_soon_ &= ~bit;
    due_late_ &= ~bit;
  }
  if (edge <= clock_ + 1) {
    due_next_ |= bit;
    return;
  }
  due_next_ &= ~bit;
  if (edge == kNever) return;
  before = edge;
  if (edge >= late_) {
    due_late_ |= bit;
    if (!due_soon_) first_later_ = 0;
    return;
  }
  due_soon_ |= bit;
  if (edge < first_later_) first_later_ = edge;
}

void Rack::plan_all() {
  due_soon_ = due_late_ = 0;
  late_ = first_later_ = 0;
  for (const auto &part : parts_) plan(*part);
}

// The first edge of those that are not the next. Few are due soon, so few are looked at.
int64_t Rack::first_later() {
  const auto first = [this](uint64_t parts) {
    int64_t edge = kNever;
    for (; parts; parts &= parts - 1) edge = std::min(edge, due_at_[__builtin_ctzll(parts)]);
    return edge;
  };
  if (first_later_ != 0) return first_later_;
  if (!due_soon_ && due_late_) {
    late_ = first(due_late_) + kSoon;
    for (uint64_t rest = due_late_; rest; rest &= rest - 1) {
      if (due_at_[__builtin_ctzll(rest)] < late_) due_soon_ |= rest & -rest;
    }
    due_late_ &= ~due_soon_;
  }
  return first_later_ = first(due_soon_);
}

// The first edge at which a part is due.
int64_t Rack::first_due() {
  if (stopped_) return kNever;
  if (due_next_ || !skip_) return clock_ + 1;
  return first_later();
}

void Rack::step(int64_t t) {
  uint64_t due = due_next_;
  if (!skip_) due = every_;
  if (first_later() <= t) {
    for (uint64_t rest = due_soon_; rest; rest &= rest - 1) {
      const int n = __builtin_ctzll(rest);
      if (due_at_[n] <= t) due |= uint64_t{1} << n;
    }
  }
  if (stopped_) due = 0;
  clock_ = t;
  ++evals_;
  stop_lines_ = lines_ != shown_lines_;
  lines_ = shown_lines_;
  // All see their inputs as they stood; then outputs move.
  uint64_t telling = 0;
  for (uint64_t rest = due; rest; rest &= rest - 1) {
    Part &part = *parts_[static_cast<size_t>(__builtin_ctzll(rest))];
    if (slow_) {
      part.slow_clock(t);
    } else {
      part.clock(t);
    }
    plan(part);
    if (part.tells()) telling |= rest & -rest;
  }
  for (uint64_t rest = telling; rest; rest &= rest - 1) {
    tell(*parts_[static_cast<size_t>(__builtin_ctzll(rest))]);
  }
  arrive_until(t);
  settle();
  if (!watched_.empty()) look_at_watched();
}

// No part gets a clock, and no counter goes on; what pins do without one is done.
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
  plan_all();
}

bool Rack::expect(std::vector<EncoderEdge> &edges) {
  if (!skip_) return false;
  coming_.swap(edges);
  next_coming_ = 0;
  plan_coming();
  return true;
}

void Rack::take_coming(int64_t t) {
  for (; coming_at_ <= t; ++next_coming_, plan_coming()) {
    pins_.move_encoder(coming_[next_coming_].axis, coming_[next_coming_].pins);
  }
}

Stop Rack::run(int64_t n, int dtack, int64_t *ran) {
  const int64_t begin = clock_;
  Stop stop = Stop::kDone;
  const unsigned wanted = static_cast<unsigned>(dtack);
  // A level that stands already is seen after the first clock, if it stands then, too.
  const bool stands = dtack >= 0 && level() == wanted;
  if ((++runs_ & 1023) == 0) {
    for (const auto &part : parts_) {
      if (part->cache->full()) forget(*part->cache);
    }
  }
  while (clock_ < begin + n) {
    const int64_t end = begin + (stands && clock_ == begin ? 1 : n);
    const bool moved = pins_.waiting() || lines_ != shown_lines_;
    const int64_t t = moved ? clock_ + 1 : first_due();
    if (coming_at_ < t && coming_at_ <= end) {
      clock_ = coming_at_;
      arrive_until(clock_);
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
    if (dtack >= 0 && level() == wanted) {
      stop = Stop::kDtack;
      break;
    }
  }
  *ran = clock_ - begin;
  return stop;
}

// The cache begins anew.
void Rack::forget(Cache &cache) {
  for (const auto &part : parts_) {
    if (part->cache.get() != &cache) continue;
    if (!stopped_) part->catch_up(clock_);
    part->forget();
    part->plan();
    plan(*part);
  }
  cache.clear();
}

void Rack::power_on() {
  clock_ = -kResetClks;
  const int reset = Wires::find("rst_ni"), clk = Wires::find("clk_i");
  wires_.put(clk, 0, 1, 1);
  for (const auto &part : parts_) part->run_always(true);
  pins_.power_on();
  pins_.set(Pin::kSysreset, 0, 1);
  pins_.apply();
  for (const auto &part : parts_) {
    part->model->eval();
    part->load();
    part->written(clock_);
    touch(*part);
    tell(*part);
  }
  settle();
  const bool skip = skip_;
  skip_ = false;
  for (int i = 0; i < kResetClks; ++i) {
    if (i == 8) {
      wires_.put(reset, 0, 1, 1);
      settle();
    }
    if (i == kResetClks / 2) pins_.set(Pin::kSysreset, 0, 0);
    step(clock_ + 1);
  }
  skip_ = skip;
  evals_ = 0;
  if (skip_) {
    for (const auto &part : parts_) part->run_always(false);
  }
}

}  // namespace mmcs
