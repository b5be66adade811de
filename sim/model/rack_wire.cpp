// SPDX-License-Identifier: Apache-2.0
// How the boards of a rack are wired, from the tables that generate.py made of rtl/mmcs.sv.

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "rack.h"

namespace mmcs {
namespace {

const char *const kBus[] = {"pc_a_i", "pc_aen_i", "pc_ior_ni", "pc_iow_ni", "pc_d_i"};

}  // namespace

// A board's parts, with the nets between them.
void Rack::add_parts(const BoardInfo &board) {
  const BoardTable &table = board_table(board.module);
  const std::string name = "B" + std::to_string(first_.size()) + "_";
  const size_t first = parts_.size();
  first_.push_back(first);
  for (size_t n = 0; n < table.parts.size(); ++n) {
    const std::string module = table.parts[n].module;
    auto model = Board::create(module, *context_, name + std::to_string(n));
    parts_.push_back(
        std::make_unique<Part>(table, n, std::move(model), &caches_[module], *context_));
    parts_.back()->number = parts_.size() - 1;
    every_ |= uint64_t{1} << parts_.back()->number;
  }
  for (size_t n = first; n < parts_.size(); ++n) {
    for (const auto &out : parts_[n]->ports()) {
      if (!out->out) continue;
      for_ports(first_.size() - 1, out->row->net, [&](Part &part, PartPort &port) {
        if (!port.out) out->links.push_back({&part, port.mask, port.at, port.data});
      });
    }
  }
}

// Data outputs that nobody looks at while no command or chip select is low.
void Rack::select() {
  uint64_t commands = 0;
  const auto adaptor = [this](auto f) {
    for (const auto &wire : board_wires_) {
      if (wire->board == 0 && wire->port->out && on_bus_[static_cast<size_t>(wire->net)]) f(*wire);
    }
  };
  adaptor([&](const Wire &w) {
    if (w.net == bus_[2] || w.net == bus_[3]) commands |= w.port->mask;
  });
  adaptor([&](const Wire &w) {
    if (w.port->data && w.port->links.empty()) w.part->select(commands, *w.port);
  });
  for (const auto &part : parts_) {
    for (const auto &port : part->ports()) {
      if (!port->out || !port->data || port->wire || port->links.size() != 1) continue;
      const Link &link = port->links[0];
      for (const auto &in : link.part->ports()) {
        if (in->row->net != port->row->net || in->row->select < 0) continue;
        const int net = link.part->ports()[static_cast<size_t>(in->row->select)]->row->net;
        for (const auto &by : part->ports()) {
          if (by->out && by->row->net == net) part->select(by->mask, *port);
        }
      }
    }
  }
}

// The net of a board's port.
int Rack::net_of(size_t board, const char *name) {
  const BoardTable &table = board_table(kWires.boards[board].module);
  for (const NetRow &row : table.nets) {
    if (std::strcmp(row.port, name) == 0) return row.net;
  }
  throw std::runtime_error(std::string("a board has no port ") + name);
}

// Some part of the board drives it, and it is no net between parts that look at a pin.
bool Rack::is_output(size_t board, int net) {
  bool found = false;
  for_ports(board, net, [&](Part &, PartPort &port) { found = found || port.out; });
  return found;
}

// Every port of every board on its net.
void Rack::wire() {
  readers_.resize(kWires.nets.size());
  followers_.resize(kWires.nets.size());
  on_bus_.resize(kWires.nets.size());
  due_.resize(kWires.logic.size());
  heard_.resize(static_cast<size_t>(kWires.cards));
  std::vector<char> read(kWires.nets.size());
  for (const PinInfo &info : kWires.pins) {
    if (std::strcmp(info.port, "clk_i") == 0) continue;
    const size_t board = static_cast<size_t>(info.board);
    const bool output = is_output(board, net_of(board, info.port));
    for_ports(board, net_of(board, info.port), [&](Part &part, PartPort &port) {
      if (port.out != output) return;  // a part of the board itself looks at what it drives
      auto wire = std::make_unique<Wire>(Wire{&part, &port, info.net, info.lsb + port.row->lsb,
                                              port.width, info.board, info.port});
      const size_t net = static_cast<size_t>(info.net);
      if (port.out) {
        port.wire = wire.get();
      } else if (port.row->heard) {
        for (size_t n = 0; n < kBusPorts; ++n) {
          if (std::strcmp(kBus[n], info.port) != 0) continue;
          bus_[n] = info.net;
          on_bus_[net] = 1;
          heard_[board - 1].push_back({wire.get(), n});  // cards follow the adaptor
        }
        read[net] = 2;
      } else {
        readers_[net].push_back({wire->lsb, wire->width, wire.get()});
        read[net] = 1;
      }
      if (std::strcmp(info.port, "dip_i") == 0) dips_.emplace_back(&part, &port);
      if (std::strcmp(info.port, "drive_v_o") == 0) drives_.push_back(wire.get());
      if (std::strcmp(info.port, "leds_o") == 0) leds_.push_back(wire.get());
      board_wires_.push_back(std::move(wire));
    });
  }
  // Logic that nobody looks at need not be worked out, and what the bus master reads when it does.
  d_ = Wires::find("vme_d_o");
  for (size_t l = 0; l < kWires.logic.size(); ++l) {
    const LogicInfo &logic = kWires.logic[l];
    if (std::count(logic.targets.begin(), logic.targets.end(), d_) == 0) continue;
    d_logic_.push_back(static_cast<int>(l));
    for (const auto &wire : board_wires_) {
      if (wire->port->out &&
          std::count(logic.sources.begin(), logic.sources.end(), wire->net) != 0) {
        d_wires_.push_back(wire.get());
      }
    }
  }
  for (size_t round = 0; round < kWires.logic.size(); ++round) {
    for (size_t l = 0; l < kWires.logic.size(); ++l) {
      const LogicInfo &logic = kWires.logic[l];
      if (due_[l] || std::none_of(logic.targets.begin(), logic.targets.end(),
                                  [&](int n) { return read[static_cast<size_t>(n)] != 0; })) {
        continue;
      }
      due_[l] = 1;
      logic_.push_back(static_cast<int>(l));
      for (int n : logic.sources) {
        read[static_cast<size_t>(n)] = 1;
        followers_[static_cast<size_t>(n)].push_back(static_cast<int>(l));
      }
    }
  }
  for (int port = 0; port < kPorts; ++port) {
    Input &input = inputs_[port];
    const int n = input.net = Wires::find(kPortNames[port]);
    if (n < 0) throw std::runtime_error(std::string("rtl/mmcs.sv has no port ") + kPortNames[port]);
    if (!followers_[static_cast<size_t>(n)].empty()) continue;
    const int width = kPortFields[port], whole = kWires.nets[static_cast<size_t>(n)].width;
    while (1 << input.shift < width) ++input.shift;
    input.fields = {0};
    for (int at = 0; at < whole; at += 1 << input.shift) {
      for (const Reader &r : readers_[static_cast<size_t>(n)]) {
        if (r.lsb >= at + width || at >= r.lsb + r.width) continue;
        const PartPort &to = *r.wire->port;
        const int up = std::max(at - r.lsb, 0), down = std::max(r.lsb - at, 0);
        const int left = up - down + (to.data ? 0 : to.at);
        const uint64_t own = (uint64_t{1} << width) - 1, all = (uint64_t{1} << r.width) - 1;
        const uint64_t mask = (own >> down << up & all) << (to.data ? 0 : to.at);
        input.arrivals.push_back({r.wire->part, mask, left & 63, to.data ? to.at : -1});
      }
      input.fields.push_back(static_cast<unsigned>(input.arrivals.size()));
    }
  }
  // An output matters to its board's neighbours if a pin or logic is on its net.
  for (const auto &part : parts_) {
    for (const auto &port : part->ports()) {
      if (port->wire && !read[static_cast<size_t>(port->wire->net)]) port->wire = nullptr;
    }
  }
  const auto of_adaptor = [this](const char *name) {
    const Wire *found = nullptr;
    for (const auto &wire : board_wires_) {
      if (wire->board == 0 && std::strcmp(wire->name, name) == 0) found = wire.get();
    }
    if (!found) throw std::runtime_error(std::string("the adaptor has no port ") + name);
    return found;
  };
  iackout_ = of_adaptor("vme_iackout_no");
  d_oe_ = of_adaptor("vme_d_oe_o");
  dtack_ = of_adaptor("vme_dtack_no");
  alive_ = of_adaptor("alive_o");
  const std::pair<const char *, int> lines[] = {
      {"vme_irq_no", 1}, {"panic_o", 8}, {"brake_release_o", 9}, {"sclock_o", 10}};
  for (const auto &[name, bit] : lines) {
    const Wire *wire = of_adaptor(name);
    wire->part->line_mask |= wire->port->mask;
    lines_of_.emplace_back(wire, bit);
  }
  for (const auto &part : parts_) part->wired();
  std::vector<const Wire *> shown = {alive_};
  shown.insert(shown.end(), drives_.begin(), drives_.end());
  shown.insert(shown.end(), leds_.begin(), leds_.end());
  shown.push_back(dtack_);
  for (const Wire *wire : shown) wire->part->show(*wire->port);
  if (skip_) select();
}

}  // namespace mmcs
