// SPDX-License-Identifier: Apache-2.0
// What is done to a rack from outside: ports, faults, registers read and flipped, snapshots.

#include <algorithm>
#include <stdexcept>

#include "rack.h"
#include "state.h"

namespace mmcs {

unsigned Rack::vme_sample() {
  if (host_) return 0x2FFFF;  // no bus
  for (Slot *slot : d_slots_) drive(*slot);
  for (int l : d_logic_) kWires.logic[static_cast<size_t>(l)].run(wires_);
  return static_cast<unsigned>(iackout_.get() << 17 | d_oe_.get() << 16 | wires_.get(d_, 0, 16));
}

void Rack::put(Port port, int lsb, int width, uint64_t value) {
  const int n = ports_[port];
  if (n < 0) return;
  const int rest = kWires.nets[static_cast<size_t>(n)].width - lsb;
  if (rest <= 0) return;
  width = std::min(width, rest);
  if (direct_[port]) {
    for_readers(n, lsb, width, [&](const Reader &r) { arrive_directly(r, lsb, width, value); });
  } else {
    wires_.put(n, lsb, width, value);
  }
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
      nets_.emplace_back(of->find(row), of);
    }
  }
  const auto &found = nets_[static_cast<size_t>(reg)];
  *block = found.second;
  return found.first;
}

void Rack::stick(const std::string &reg, uint64_t clear, uint64_t set) {
  const int found = find_register(reg);
  Block *block;
  const Net net = find(found, &block);
  const Register &r = registers()[static_cast<size_t>(found)];
  auto &pokes = block->units[static_cast<size_t>(block->table.registers[r.row].unit)].pokes;
  pokes.erase(
      std::remove_if(pokes.begin(), pokes.end(), [&](const Poke &p) { return p.net.at == net.at; }),
      pokes.end());
  if (clear || set) pokes.push_back({net, clear, set});
  catch_up(*block);
  net.put((net.get() & ~clear) | set);
  block->written(clock_);
  touch(*block);
}

// All up to the present clock: its registers may be read.
void Rack::catch_up(Block &block) {
  const bool behind = block.behind();
  block.catch_up(clock_);
  if (!behind) return;
  plan(block);
}

uint64_t Rack::read(int reg) {
  Block *block;
  const Net net = find(reg, &block);
  catch_up(*block);
  return net.get();
}

void Rack::upset(int reg, uint64_t bits) {
  Block *block;
  const Net net = find(reg, &block);
  upset_ = true;
  catch_up(*block);
  net.put(net.get() ^ bits);
  block->written(clock_);
  touch(*block);
  settle();
}

// A register, or a port of a board or of one of its chips. A card that does not listen has no bus
// to look at: its ports of it do not count.
Net Rack::find_watched(const std::string &name) {
  if (const int reg = find_register(name); reg >= 0) {
    Block *block;
    return find(reg, &block);
  }
  for (size_t n = 0; n < blocks_.size(); ++n) {
    const std::string board = std::string(kWires.boards[n].path) + ".";
    if (name.compare(0, board.size(), board) != 0) continue;
    const std::string inner = name.substr(board.size());
    const size_t dot = inner.rfind('.');
    const std::string path = dot == std::string::npos ? "" : inner.substr(0, dot);
    const BoardTable &table = blocks_[n]->table;
    for (size_t u = 0; u < table.unit_count; ++u) {
      if (path != (u ? table.units[u].path : "")) continue;
      const std::string port = dot == std::string::npos ? inner : inner.substr(dot + 1);
      for (const auto &slot : slots_) {
        const bool heard = slot->block == blocks_[n].get() && slot->row->heard;
        if (u == 0 && heard && port == slot->row->name) return {};
      }
      return blocks_[n]->units[u].model->port(port);
    }
  }
  return {};
}

int Rack::watch(const std::string &name) {
  const Net net = find_watched(name);
  if (skip_ || !net || net.bytes > 4) return -1;
  const int number = static_cast<int>(watched_.size());
  const uint32_t value = static_cast<uint32_t>(net.get());
  watched_.push_back({net, value});
  changes_.push_back({clock_, number, value});
  return number;
}

void Rack::look_at_watched() {
  for (size_t n = 0; n < watched_.size(); ++n) {
    const uint32_t value = static_cast<uint32_t>(watched_[n].net.get());
    if (value == watched_[n].seen) continue;
    watched_[n].seen = value;
    changes_.push_back({clock_, static_cast<int>(n), value});
  }
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
  if (state.registers.size() != registers().size()) {
    throw std::invalid_argument("a snapshot of another machine");
  }
  for (const auto &block : blocks_) {
    block->catch_up(clock_);
    block->renew(state.clock);
  }
  clock_ = host_clock_ = state.clock;
  pins_.restore(state.pins);
  coming_.clear();
  // A reset without a clock that falls with these pins is over before the registers come.
  for (const auto &block : blocks_) {
    block->catch_up(clock_);
    block->look(clock_);
  }
  // Twice: what the registers seem to clear as they come, on other boards too, is no edge.
  dips_moved_ = true;
  for (int twice = 0; twice < 2; ++twice) {
    for (size_t reg = 0; reg < registers().size(); ++reg) {
      Block *block;
      find(static_cast<int>(reg), &block).put(state.registers[reg]);
    }
    for (const auto &block : blocks_) block->written(clock_);
    for (const auto &block : blocks_) {
      outputs(*block);
      touch(*block);
    }
    bus_moved_ = true;
    settle();
  }
  look_at_lines();
  lines_ = static_cast<unsigned>(state.lines);
}

}  // namespace mmcs
