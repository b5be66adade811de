// SPDX-License-Identifier: Apache-2.0
// See rack.h.

#include "rack.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "state.h"

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
  }
  wire();
  power_on();
}

// --- nets ------------------------------------------------------------------------------------

void Rack::changed(int net, int lsb, int width) {
  const size_t n = static_cast<size_t>(net);
  if (net == bus_[0] || net == bus_[1] || net == bus_[2] || net == bus_[3]) bus_moved_ = true;
  for (int l : followers_[n]) {
    if (!due_[static_cast<size_t>(l)]) {
      due_[static_cast<size_t>(l)] = 1;
      logic_.push_back(l);
    }
  }
  if (width <= 2 && !by_bit_[n].empty()) {
    for (int bit = lsb; bit < lsb + width; ++bit) {
      for (Slot *slot : by_bit_[n][static_cast<size_t>(bit)]) show(*slot);
    }
    return;
  }
  for (const Reader &r : readers_[n]) {
    if (r.lsb < lsb + width && lsb < r.lsb + r.width) show(*r.slot);
  }
}

// The net's value at an input.
void Rack::show(Slot &slot) {
  const uint64_t value = slot.through(wires_.get(slot.net, slot.lsb, slot.width));
  if (slot.port.get() == value) return;
  slot.port.put(value);
  Block &block = *slot.block;
  block.stale = true;
  if (slot.row->slow) block.reset = true;
  if (slot.row->quiet || (slot.look.quiet && slot.look.quiet->holds())) return;
  if (slot.look.unit) slot.look.unit->moved_port();
  touch(block);
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

void Rack::drive_nets(Block &block) {
  for (Slot *slot : block.outs) drive(*slot);
  if (&block == adaptor_) look_at_lines();
}

void Rack::look_at_lines() {
  unsigned lines = 0;
  for (const auto &[n, bit] : line_nets_) lines |= static_cast<unsigned>(n.get()) << bit;
  shown_lines_ = lines ^ kLineIrq;
}

// Which cards hear the bus now; those that heard it until now see it end.
void Rack::listen() {
  bus_moved_ = false;
  const unsigned ior_n = static_cast<unsigned>(wires_.get(bus_[2], 0, 1));
  const unsigned iow_n = static_cast<unsigned>(wires_.get(bus_[3], 0, 1));
  uint32_t now = 0;
  if (!(ior_n && iow_n)) {
    if (dips_moved_) ears_.forget();
    dips_moved_ = false;
    now = ears_.hear(static_cast<unsigned>(wires_.get(bus_[0], 0, 16)),
                     static_cast<unsigned>(wires_.get(bus_[1], 0, 1)), ior_n, iow_n, dips_);
  }
  for (uint32_t rest = now | listening_; rest; rest &= rest - 1) {
    for (Slot *slot : heard_[static_cast<size_t>(__builtin_ctz(rest))]) show(*slot);
  }
  listening_ = now;
}

// Until nothing follows any more, after edge clock_.
void Rack::settle() {
  for (;;) {
    if (bus_moved_) listen();
    if (!logic_.empty()) {
      const int l = logic_.back();
      logic_.pop_back();
      due_[static_cast<size_t>(l)] = 0;
      kWires.logic[static_cast<size_t>(l)].run(wires_);
    } else if (!touched_.empty()) {
      Block &block = *touched_.back();
      touched_.pop_back();
      block.touched = false;
      block.look(clock_);
      if (block.out_words.moved(block.base)) drive_nets(block);
    } else if (!bus_moved_) {
      break;
    }
  }
}

// --- time ------------------------------------------------------------------------------------

void Rack::plan() {
  int64_t first = kNever, second = kNever;
  for (const auto &block : blocks_) {
    if (block->next < first) {
      second = first;
      first = block->next;
      first_ = block.get();
    } else if (block->next < second) {
      second = block->next;
    }
  }
  next_ = first;
  second_ = second;
}

void Rack::step(int64_t t) {
  clock_ = t;
  ++evals_;
  stop_lines_ = lines_ != shown_lines_;
  lines_ = shown_lines_;
  for (const auto &block : blocks_) {
    if (skip_ && block->next > t) continue;
    if (slow_) {
      block->whole_edge(t);
    } else {
      if (!skip_) block->wake(t - 1);
      block->edge(t);
    }
    touch(*block);
  }
  if (pins_.waiting()) pins_.apply();
  settle();
  plan();
}

// Clocks of one board while nothing else is due before `end`, and as long as none of its outputs
// moves.
void Rack::alone(Block &block, int64_t end) {
  for (;;) {
    const int64_t t = clock_ = block.next;
    ++evals_;
    block.edge(t);
    block.look(t);
    if (block.out_words.moved(block.base)) {
      drive_nets(block);
      settle();
      break;
    }
    if (block.next >= end) break;
  }
  plan();
}

Stop Rack::run(int64_t n, int dtack, int64_t *ran) {
  const int64_t begin = clock_;
  int64_t end = begin + n;
  Stop stop = Stop::kDone;
  const unsigned wanted = dtack < 0 ? 2u : static_cast<unsigned>(dtack);
  // Clock by clock the level would be seen after the first.
  if (dtack_.get() == wanted) end = begin + 1;
  while (clock_ < end) {
    int64_t t = next_;
    const bool moved = !skip_ || pins_.waiting() || lines_ != shown_lines_;
    if (moved) t = clock_ + 1;
    if (t > end) {
      clock_ = end;
    } else if (!moved && t < second_) {
      alone(*first_, std::min(end + 1, second_));
    } else {
      step(t);
      if (stop_lines_) {
        stop_lines_ = false;
        stop = Stop::kLines;
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
    block->board->eval();
    block->board->settle();
    block->wake(clock_);
    drive_nets(*block);
  }
  settle();
  const bool skip = skip_;
  skip_ = false;
  plan();
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

// --- looks and hands -------------------------------------------------------------------------

unsigned Rack::vme_sample() {
  return static_cast<unsigned>(iackout_.get() << 17 | d_oe_.get() << 16 | wires_.get(d_, 0, 16));
}

void Rack::put(Port port, int lsb, int width, uint64_t value) {
  const int n = ports_[port];
  const int rest = kWires.nets[static_cast<size_t>(n)].width - lsb;
  if (rest <= 0) return;
  wires_.put(n, lsb, std::min(width, rest), value);
  if (port == kDip) {
    dips_moved_ = bus_moved_ = true;
  }
}

void Rack::cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) {
  for (const auto &slot : slots_) {
    const size_t n =
        static_cast<size_t>(std::find_if(blocks_.begin(), blocks_.end(),
                                         [&](const auto &b) { return b.get() == slot->block; }) -
                            blocks_.begin());
    if (board != kWires.boards[n].path || std::strcmp(slot->row->name, port) != 0) continue;
    const uint64_t own = (uint64_t{1} << slot->width) - 1;
    slot->held = mask & own;
    slot->at = value & slot->held;
    if (slot->row->out) {
      drive(*slot);
    } else if (slot->row->heard) {
      // Its wires back, it hears what is on them as any card does: all of it, or nothing.
      if (mask || (listening_ >> (n - 1) & 1)) show(*slot);
      bus_moved_ = true;
    } else {
      show(*slot);
    }
  }
}

Net Rack::find(int reg, Block **block) {
  if (nets_.empty()) {
    for (const Register &r : registers()) {
      Block *of = blocks_[static_cast<size_t>(r.board)].get();
      const RegisterRow &row = of->table.registers[r.row];
      nets_.emplace_back(of->find(row.path, row.name), of);
      nets_.back().first.width = r.width;
    }
  }
  const auto &found = nets_[static_cast<size_t>(reg)];
  *block = found.second;
  return found.first;
}

void Rack::stick(const std::string &reg, uint64_t clear, uint64_t set) {
  Block *block;
  const Net net = find(find_register(reg), &block);
  auto &pokes = block->pokes;
  pokes.erase(std::remove_if(pokes.begin(), pokes.end(),
                             [&](const Block::Poke &p) { return p.net.at == net.at; }),
              pokes.end());
  if (clear || set) pokes.push_back({net, clear, set});
  block->catch_up(clock_);
  net.put((net.get() & ~clear) | set);
  block->board->settle();
  block->wake(clock_);
  touch(*block);
}

uint64_t Rack::read(int reg) {
  Block *block;
  const Net net = find(reg, &block);
  block->catch_up(clock_);
  return net.get();
}

void Rack::upset(int reg, uint64_t bits) {
  Block *block;
  const Net net = find(reg, &block);
  upset_ = true;
  block->catch_up(clock_);
  net.put(net.get() ^ bits);
  block->board->settle();
  block->wake(clock_);
  touch(*block);
  settle();
  plan();
}

std::vector<uint8_t> Rack::save() {
  State state;
  for (size_t reg = 0; reg < registers().size(); ++reg) {
    state.registers.push_back(read(static_cast<int>(reg)));
  }
  state.pins = pins_.save();
  state.clock = clock_;
  state.lines = lines_;
  return state.pack();
}

void Rack::restore(const std::vector<uint8_t> &bytes) {
  Verilated::threadContextp(&context_);
  const State state = State::unpack(bytes);
  clock_ = state.clock;
  pins_.restore(state.pins);
  for (size_t reg = 0; reg < registers().size(); ++reg) {
    Block *block;
    find(static_cast<int>(reg), &block).put(state.registers[reg]);
  }
  for (const auto &block : blocks_) {
    block->board->settle();
    block->stale = block->reset = false;
    block->wake(clock_);
    drive_nets(*block);
    touch(*block);
  }
  dips_moved_ = bus_moved_ = true;
  settle();
  look_at_lines();
  lines_ = static_cast<unsigned>(state.lines);
  plan();
}

}  // namespace mmcs
