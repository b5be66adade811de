// SPDX-License-Identifier: Apache-2.0
// What is done to the machine from outside: ports, faults, registers read and flipped, snapshots.

#include <algorithm>

#include "rack.h"

namespace mmcs {

unsigned Rack::vme_sample() {
  if (!stopped_) parts_.front()->catch_up(clock_);
  for (Wire *wire : vme_data_wires_) drive_net(*wire);
  if (glue_changed_ || glue_stale_) eval_glue();
  return static_cast<unsigned>(iackout_->get() << 17 | d_oe_->get() << 16 | vme_data_.get());
}

void Rack::put(Port port, int lsb, int, uint64_t value) {
  const Input &input = inputs_[port];
  const size_t n = static_cast<size_t>(lsb >> input.shift);
  if (own_card_ && own_card_->take(port, lsb, value)) card_.changed = true;
  if (n + 1 >= input.fields.size()) return;  // of no axis or card that the machine has
  const unsigned *field = &input.fields[n];
  const Link *to = input.arrivals.data() + field[0];
  for (const Link *end = to + (field[1] - field[0]); to != end; ++to)
    put_input(*to->part, *to, value);
  if (port == kDip) pc_bus_.switches_changed = pc_bus_.changed = true;
}

void Rack::cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) {
  for (const auto &wire : board_wires_) {
    const size_t n = static_cast<size_t>(wire->board);
    if (board != kWires.boards[n].path || std::strcmp(wire->name, port) != 0) continue;
    const uint64_t own = (uint64_t{1} << wire->width) - 1;
    wire->held = mask >> wire->port->row->lsb & own;
    wire->held_at = value >> wire->port->row->lsb & wire->held;
    if (wire->port->output) {
      if (wire->net == pc_bus_.nets[PcBus::kIor] || wire->net == pc_bus_.nets[PcBus::kIow]) {
        Part &part = *wire->part;
        if (!stopped_) part.catch_up(clock_);
        part.load();
        part.model.never_ignore(mask != 0);
        part.choose_cache(cache_of(part));
        written(part);
      }
      drive_net(*wire);
    } else if (wire->port->row->selected) {
      // When its wires are back, the card gets the bus if it is selected, as any card.
      if (mask || (pc_bus_.selected >> (n - 1) & 1)) update_input(*wire);
      pc_bus_.changed = true;
    } else {
      update_input(*wire);
    }
  }
}

std::vector<CacheFigures> Rack::cache_figures() const {
  std::vector<CacheFigures> found;
  for (const auto &[module, cache] : caches_) {
    found.push_back({module, 0, 0, cache->states(), cache->bytes()});
    for (const auto &part : parts_) {
      if (part->cache != cache) continue;
      found.back().hits += part->now().hits;
      found.back().misses += part->now().misses;
    }
  }
  return found;
}

RegisterPlace &Rack::find(int reg, Part **part) {
  const Register &r = registers()[static_cast<size_t>(reg)];
  const size_t board = static_cast<size_t>(r.board);
  const BoardTable &table = board_table(kWires.boards[board].module);
  *part = parts_[board_begin_[board] + static_cast<size_t>(table.registers[r.row].part)].get();
  return *(*part)->model.place(static_cast<size_t>(r.row));
}

// Does what follows from registers of the part that were written.
void Rack::written(Part &part) {
  part.written(clock_);
  plan(part);
  send_outputs(part);
}

void Rack::stick(const std::string &reg, uint64_t clear, uint64_t set) {
  Part *part;
  RegisterPlace &place = find(find_register(reg), &part);
  if (!stopped_) part->catch_up(clock_);
  part->load();
  part->model.hold(place, clear, set);
  part->choose_cache(cache_of(*part));
  place.net.put((place.net.get() & ~clear) | set);
  written(*part);
}

uint64_t Rack::read(int reg) {
  Part *part;
  const RegisterPlace &place = find(reg, &part);
  if (!stopped_) part->catch_up(clock_);
  part->load();
  return place.net.get();
}

void Rack::upset(int reg, uint64_t bits) {
  Part *part;
  const RegisterPlace &place = find(reg, &part);
  upset_ = true;
  if (!stopped_) part->catch_up(clock_);
  part->load();
  place.net.put(place.net.get() ^ bits);
  written(*part);
  settle();
}

// A register, or a port of a board or of one of its chips; but not a port of a card on the PC bus,
// which keeps an old value while the card is not selected.
Rack::Watched Rack::find_watched(const std::string &name) {
  Watched found{};
  if (const int reg = find_register(name); reg >= 0) {
    found.net = find(reg, &found.part).net;
    return found;
  }
  for (size_t reg = 0; own_card_ && reg < own_card_->size(); ++reg) {
    if (own_card_->name(reg) != name) continue;
    found.net = own_card_->net(reg);
    return found;
  }
  for (size_t n = 0; n < kWires.boards.size(); ++n) {
    const std::string board = std::string(kWires.boards[n].path) + ".";
    if (name.compare(0, board.size(), board) != 0) continue;
    const size_t dot = name.rfind('.');
    const std::string path = name.substr(0, dot + 1), port = name.substr(dot + 1);
    const BoardTable &table = board_table(kWires.boards[n].module);
    for (size_t chip = 1; chip < table.parts.size(); ++chip) {
      Part *part = parts_[board_begin_[n] + chip].get();
      if (path == board + table.parts[chip].path + ".")
        return {part, part->model.board->port(port)};
    }
    const auto is_port = [&](const PinInfo &pin) {
      return static_cast<size_t>(pin.board) == n && port == pin.port;
    };
    const auto pin = std::find_if(kWires.pins.begin(), kWires.pins.end(), is_port);
    if (path != board || pin == kWires.pins.end()) return {};
    for_ports(n, pin->inside, [&](Part &part, PartPort &at) {
      if ((!found.net || at.output) && !at.row->selected) found = {&part, at.net};
    });
  }
  return found;
}

int Rack::watch(const std::string &name) {
  Watched net = find_watched(name);
  if (skip_ || !net.net || net.net.bytes > 4) return -1;
  const int number = static_cast<int>(watched_.size());
  net.seen = net.get();
  watched_.push_back(net);
  changes_.push_back({clock_, number, net.seen});
  return number;
}

void Rack::compare_watched() {
  for (size_t n = 0; n < watched_.size(); ++n) {
    const uint32_t value = watched_[n].get();
    if (value == watched_[n].seen) continue;
    watched_[n].seen = value;
    changes_.push_back({clock_, static_cast<int>(n), value});
  }
}

void Rack::put_back(const Saved &state) {
  use(context_);
  for (const auto &part : parts_) {
    if (!stopped_) part->catch_up(clock_);
    part->pass(state.clock);
  }
  clock_ = state.clock;
  pins_.restore(state.pins);
  edges_ = {};
  // A reset without a clock that falls with these pins is over before the registers are written.
  settle();
  // Twice: a clear that seems to come with the registers, on other boards too, is no edge.
  pc_bus_.switches_changed = true;
  for (int twice = 0; twice < 2; ++twice) {
    for (const auto &part : parts_) part->load();
    for (size_t reg = 0; reg < registers().size(); ++reg) {
      Part *part;
      find(static_cast<int>(reg), &part).net.put(state.registers[reg]);
    }
    for (const auto &part : parts_) part->written(clock_);
    for (const auto &part : parts_) {
      send_outputs(*part);
      inputs_changed(*part);
    }
    pc_bus_.changed = true;
    if (own_card_) {
      own_card_->restore(state.card);
      send_card();
    }
    settle();
  }
  schedule_.clear();
  for (const auto &part : parts_) plan(*part);
  update_lines();
  lines_ = state.lines;
}

}  // namespace mmcs
