// SPDX-License-Identifier: Apache-2.0
// See rack.h.

#include "rack.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace mmcs {
namespace {

constexpr int kResetClks = 64;

}  // namespace

Rack::Rack(bool slow, bool skip, uint64_t seed)
    : wires_(*this), pins_(*this, kWires.cards), slow_(slow), skip_(skip && !slow) {
  context_.randReset(2);
  context_.randSeed(static_cast<int>(seed % 0x7FFFFFFF) + 1);
  Verilated::threadContextp(&context_);
  for (size_t n = 0; n < kWires.boards.size(); ++n) {
    blocks_.push_back(
        std::make_unique<Block>(kWires.boards[n].module, context_, "B" + std::to_string(n)));
    blocks_.back()->number = n;
  }
  due_at_.resize(blocks_.size());
  wire();
}

// --- nets ------------------------------------------------------------------------------------

void Rack::changed(int net, int lsb, int width) {
  const size_t n = static_cast<size_t>(net);
  if (net == bus_[0] || net == bus_[1] || net == bus_[2] || net == bus_[3]) bus_moved_ = true;
  if (net == bus_[4] && listening_) bus_moved_ = true;  // data that an upset moves in a command
  for (int l : followers_[n]) {
    if (!due_[static_cast<size_t>(l)]) {
      due_[static_cast<size_t>(l)] = 1;
      logic_.push_back(l);
    }
  }
  for_readers(net, lsb, width, [this](const Reader &r) { show(*r.slot); });
}

// The net's value at an input.
void Rack::show(Slot &slot) {
  arrive(slot, slot.through(wires_.get(slot.net, slot.lsb, slot.width)));
}

void Rack::arrive(Slot &slot, uint64_t value) {
  if (slot.port.get() == value) return;
  Block &block = *slot.block;
  if (block.behind() && !slot.row->quiet) {
    block.catch_up(clock_);
    touch(block);
  }
  slot.port.put(value);
  block.board().stale = true;
  if (slot.row->quiet || (slot.quiet && slot.quiet->holds())) return;
  if (slot.wakes) block.board().wake(clock_);
  touch(block);
}

// An input of the machine that nothing but ports of boards is on.
void Rack::arrive_directly(const Reader &reader, int lsb, int width, uint64_t value) {
  Slot &slot = *reader.slot;
  const int low = std::max(lsb, reader.lsb);
  const int bits = std::min(lsb + width, reader.lsb + reader.width) - low;
  const uint64_t mask = ((uint64_t{1} << bits) - 1) << (low - reader.lsb);
  const uint64_t after = (slot.shown & ~mask) | (value >> (low - lsb) << (low - reader.lsb) & mask);
  if (after == slot.shown) return;
  slot.shown = after;
  Block &block = *slot.block;
  if (slot.late && skip_ && !stopped_ && !(listening_ >> (block.number - 1) & 1)) {
    return block.defer(clock_, slot, after);
  }
  if (slot.late && block.behind()) {  // its port shows less than the wire has done
    block.catch_up(clock_);
    touch(block);
  }
  arrive(slot, after);
}

void Rack::touch(Block &block) {
  if (block.touched) return;
  block.touched = true;
  touched_.push_back(&block);
}

// An output that has moved takes its net along.
void Rack::drive(Slot &slot) {
  const uint64_t value = slot.value();
  if (value == slot.shown) return;
  slot.shown = value;
  wires_.put(slot.net, slot.lsb, slot.width, value);
}

// What of a board's outputs has moved goes where it is seen; false if none has.
bool Rack::outputs(Block &block) {
  const char *base = block.board().base;
  if (!std::exchange(block.outs_moved, false) && !block.out_words.moved(base)) return false;
  if (&block == adaptor_) {
    if (line_words_.moved(base)) look_at_lines();
    if (!net_words_.moved(base)) return true;
  }
  for (Slot *slot : block.outs) drive(*slot);
  return true;
}

void Rack::look_at_lines() {
  unsigned lines = 0;
  for (const auto &[n, bit] : line_nets_) lines |= static_cast<unsigned>(n.get()) << bit;
  shown_lines_ = host_ ? lines : lines ^ kLineIrq;
}

// Which cards hear the bus now; those that heard it until now see it end. A deaf card keeps what it
// saw last, which may be a command that its switches made it deaf to: when one moves, all look.
void Rack::listen() {
  bus_moved_ = false;
  const unsigned ior_n = static_cast<unsigned>(wires_.get(bus_[2], 0, 1));
  const unsigned iow_n = static_cast<unsigned>(wires_.get(bus_[3], 0, 1));
  uint32_t now = 0, looking = listening_;
  if (dips_moved_) {
    dips_moved_ = false;
    ears_.forget();
    looking = (1u << heard_.size()) - 1;
  }
  if (!(ior_n && iow_n)) {
    now = ears_.hear(static_cast<unsigned>(wires_.get(bus_[0], 0, 16)),
                     static_cast<unsigned>(wires_.get(bus_[1], 0, 1)), ior_n, iow_n, dips_);
  }
  for (uint32_t rest = now | looking; rest; rest &= rest - 1) {
    for (Slot *slot : heard_[static_cast<size_t>(__builtin_ctz(rest))]) show(*slot);
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
    } else if (!touched_.empty()) {
      Block &block = *touched_.back();
      touched_.pop_back();
      block.touched = false;
      block.look(clock_);
      plan(block);
      outputs(block);
    } else {
      return;
    }
  }
}

// --- time ------------------------------------------------------------------------------------

// A board may be due at another edge than before.
void Rack::plan(const Block &block) {
  if (&block == host_) return plan_host(true);
  const int64_t edge = block.due();
  int64_t &before = due_at_[block.number];
  if (&block != adaptor_ && edge != before) cards_moved_ = true;
  before = edge;
}

// The first edge at which a card is due.
int64_t Rack::cards_due() {
  if (cards_moved_) {
    cards_moved_ = false;
    cards_due_ = *std::min_element(due_at_.begin() + 1, due_at_.end());
  }
  return cards_due_;
}

void Rack::step(int64_t t) {
  const bool host = host_ && (!skip_ || due_at_[host_->number] <= t);
  if (host) {
    clock_ = t - 1;
    host_clocks();
  }
  clock_ = t;
  ++evals_;
  stop_lines_ = lines_ != shown_lines_;
  lines_ = shown_lines_;
  const size_t boards = stopped_ ? 0 : !skip_ || cards_due() <= t ? blocks_.size() : 1;
  for (size_t n = 0; n < boards; ++n) {
    if (skip_ && due_at_[n] > t) continue;
    Block &block = *blocks_[n];
    if (&block == host_) continue;
    if (slow_) {
      block.whole_edge(t);
    } else {
      if (!skip_) block.renew(t - 1);
      if (block.behind()) block.catch_up(t - 1);
      block.edge(t);
    }
    touch(block);
  }
  if (host) {
    host_edge();
    host_clock_ = t;
    plan_host(false);
    outputs(*host_);
  }
  arrive_until(t);
  settle();
  if (host) {
    after_clock();
    if (!host_rests()) plan_host(true);
  }
  if (!watched_.empty()) look_at_watched();
}

// No board gets a clock, and no counter goes on; what pins do without one is done.
void Rack::stop_clock(bool stopped) {
  if (stopped == stopped_) return;
  stopped_ = stopped;
  for (const auto &block : blocks_) {
    block->catch_up(clock_);
    block->renew(clock_);
    touch(*block);
  }
}

bool Rack::expect(std::vector<EncoderEdge> &edges) {
  if (host_ || !skip_) return false;
  coming_.swap(edges);
  next_coming_ = 0;
  return true;
}

// What stands at the ports after edge t arrives.
void Rack::arrive_until(int64_t t) {
  for (; coming_at() <= t; ++next_coming_) {
    pins_.set_encoder(coming_[next_coming_].axis, coming_[next_coming_].pins);
  }
  if (pins_.waiting()) pins_.apply();
}

// Clocks of the adaptor while nothing else is due before `end`, and as long as none of its outputs
// moves.
void Rack::alone(int64_t end) {
  Block &block = *adaptor_;
  do {
    const int64_t t = due_at_[0];
    clock_ = block.edges(t, end);
    evals_ += static_cast<uint64_t>(clock_ - t + 1);
    block.look(clock_);
    due_at_[0] = block.due();
  } while (!outputs(block) && due_at_[0] < end);
  settle();
}

Stop Rack::run(int64_t n, int dtack, int64_t *ran) {
  const int64_t begin = clock_;
  Stop stop = Stop::kDone;
  const unsigned wanted = dtack < 0 ? 2u : static_cast<unsigned>(dtack);
  // A level that stands already is seen after the first clock, if it stands then, too.
  const bool stands = dtack_.get() == wanted;
  while (clock_ < begin + n) {
    const int64_t end = begin + (stands && clock_ == begin ? 1 : n);
    const int64_t cards = cards_due(), coming = coming_at();
    int64_t t = stopped_ ? kNever : std::min(due_at_[0], cards);
    const bool moved = (!skip_ && !stopped_) || pins_.waiting() || lines_ != shown_lines_;
    if (moved) t = clock_ + 1;
    if (!moved && coming < t && coming <= end) {
      clock_ = coming;
      arrive_until(coming);
      settle();
    } else if (t > end) {
      clock_ = end;
    } else if (!moved && t < cards && t < coming) {
      alone(std::min(end + 1, std::min(cards, coming)));
    } else {
      step(t);
      if (stop_lines_) {
        stop_lines_ = false;
        stop = Stop::kLines;
        break;
      }
      if (host_ && halted()) {
        stop = Stop::kReport;
        break;
      }
    }
    if (dtack_.get() == wanted) {
      stop = Stop::kDtack;
      break;
    }
  }
  *ran = clock_ - begin;
  return stop;
}

void Rack::power_on() {
  clock_ = -kResetClks;
  const int reset = Wires::find("rst_ni"), clk = Wires::find("clk_i");
  wires_.put(clk, 0, 1, 1);
  pins_.power_on();
  pins_.set(Pin::kSysreset, 0, 1);
  pins_.apply();
  for (const auto &block : blocks_) {
    for (Unit &unit : block->units) unit.model->eval();
    block->written(clock_);
    touch(*block);
    outputs(*block);
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
}

}  // namespace mmcs
