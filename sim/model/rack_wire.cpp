// SPDX-License-Identifier: Apache-2.0
// How the boards of a rack are wired, from the tables that generate.py made of rtl/mmcs.sv.

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "rack.h"

namespace mmcs {
namespace {

// Ports of a card, as rack.h numbers the signals.
const char *const kPcBus[] = {"pc_a_i", "pc_aen_i", "pc_ior_ni", "pc_iow_ni", "pc_d_i"};

}  // namespace

// A board's parts, with the nets between them.
void Rack::add_parts(const BoardInfo &board) {
  const BoardTable &table = board_table(board.module);
  const std::string name = "B" + std::to_string(board_begin_.size()) + "_";
  const size_t first = parts_.size();
  board_begin_.push_back(first);
  for (size_t n = 0; n < table.parts.size(); ++n) {
    const std::string module = table.parts[n].module;
    auto model = Board::create(module, *context_, name + std::to_string(n));
    if (parts_.size() == Schedule::kMostParts)
      throw std::logic_error("a machine of too many parts");
    parts_.push_back(std::make_unique<Part>(table, n, std::move(model), &caches_[module], *context_,
                                            &data_[parts_.size() * kMostFields]));
    parts_.back()->number = parts_.size() - 1;
    all_parts_ |= uint64_t{1} << parts_.back()->number;
  }
  for (size_t n = first; n < parts_.size(); ++n) {
    for (const auto &out : parts_[n]->model.ports()) {
      if (!out->output) continue;
      for_ports(board_begin_.size() - 1, out->row->net, [&](Part &part, PartPort &port) {
        if (!port.output) out->links.push_back({&part, port.mask, port.shift, port.field});
      });
    }
  }
}

// Data outputs that are not observed while no command or chip select is low.
void Rack::ignore_unselected() {
  const auto &bus = pc_bus_;
  uint64_t commands = 0;
  const auto adaptor = [this, &bus](auto f) {
    for (const auto &wire : board_wires_) {
      if (wire->board == 0 && wire->port->output && bus.has_net[static_cast<size_t>(wire->net)])
        f(*wire);
    }
  };
  adaptor([&](const Wire &w) {
    if (w.net == bus.nets[PcBus::kIor] || w.net == bus.nets[PcBus::kIow]) commands |= w.port->mask;
  });
  adaptor([&](const Wire &w) {
    if (w.port->data && w.port->links.empty() && !own_card_)
      w.part->model.ignore_while(commands, *w.port);
  });
  for (const auto &part : parts_) {
    for (const auto &port : part->model.ports()) {
      if (!port->output || !port->data || port->wire || port->links.size() != 1) continue;
      const Link &link = port->links[0];
      for (const auto &in : link.part->model.ports()) {
        if (in->row->net != port->row->net || in->row->select < 0) continue;
        const int net = link.part->model.ports()[static_cast<size_t>(in->row->select)]->row->net;
        for (const auto &by : part->model.ports()) {
          if (by->output && by->row->net == net) part->model.ignore_while(by->mask, *port);
        }
      }
    }
  }
}

// Every port of every board on its net. read: of each net, whether a board or the glue reads it.
void Rack::wire() {
  std::vector<char> read(kWires.nets.size());
  readers_.resize(kWires.nets.size());
  pc_bus_.has_net.resize(kWires.nets.size());
  pc_bus_.cards.resize(static_cast<size_t>(kWires.cards));
  pc_bus_.dips.resize(static_cast<size_t>(kWires.cards));
  for (const PinInfo &info : kWires.pins) wire_pin(info, read);
  if (own_card_) wire_card(read);
  wire_glue(read);
  for (int port = 0; port < kPorts; ++port) wire_input(static_cast<Port>(port));
  wire_outputs(read);
  if (skip_) ignore_unselected();
}

// A port of a board, in each part that has it.
void Rack::wire_pin(const PinInfo &info, std::vector<char> &read) {
  const size_t board = static_cast<size_t>(info.board), net = static_cast<size_t>(info.net);
  const auto is = [&info](const char *name) { return std::strcmp(info.port, name) == 0; };
  for_ports(board, info.inside, [&](Part &part, PartPort &port) {
    if (port.output != info.out) return;  // a part of the board reads what the board drives
    auto wire = std::make_unique<Wire>(
        Wire{&part, &port, info.net, info.lsb + port.row->lsb, port.width, info.board, info.port});
    if (port.output) {
      port.wire = wire.get();
    } else if (port.row->selected) {
      for (size_t n = 0; n < PcBus::kSignals; ++n) {
        if (!is(kPcBus[n])) continue;
        pc_bus_.nets[n] = info.net;
        pc_bus_.has_net[net] = 1;
        pc_bus_.cards[board - 1].push_back({wire.get(), n});  // the adaptor is board 0
      }
      read[net] = 1;
    } else {
      readers_[net].push_back({wire->lsb, wire->width, wire.get()});
      read[net] = 1;
    }
    if (is("dip_i")) pc_bus_.switches.emplace_back(&part, &port);
    if (is("drive_v_o")) drives_.push_back(wire.get());
    if (is("leds_o")) leds_.push_back(wire.get());
    board_wires_.push_back(std::move(wire));
  });
}

// An own card reads the PC bus at any time.
void Rack::wire_card(std::vector<char> &read) {
  for (size_t n = 0; n < std::size(card_.nets); ++n) {
    card_.nets[n] = Nets::find(OwnCard::kInputs[n]);
    if (own_card_->has(n)) read[static_cast<size_t>(card_.nets[n])] = 1;
  }
  card_.wait = Nets::find(OwnCard::kOutputs[OwnCard::kWait]);
}

// Ports of boards at the logic of mmcs.sv. It is evaluated when a source of a net that boards read
// changes; for a net that only the bus master reads, when it is read.
void Rack::wire_glue(std::vector<char> &read) {
  const auto is_read = [&read](int net) { return read[static_cast<size_t>(net)] != 0; };
  for (size_t round = 0; round < kWires.logic.size(); ++round) {
    for (const LogicInfo &logic : kWires.logic) {
      if (std::none_of(logic.targets.begin(), logic.targets.end(), is_read)) continue;
      for (int n : logic.sources) read[static_cast<size_t>(n)] = 1;
    }
  }
  for (const LogicInfo &logic : kWires.logic) {
    for (const auto &wire : board_wires_) {
      if (!wire->port->output ||
          std::count(logic.sources.begin(), logic.sources.end(), wire->net) == 0)
        continue;
      if (!wire->glue) glue_wires_.push_back(wire.get());
      wire->glue =
          glue_.board_output(kWires.boards[static_cast<size_t>(wire->board)].path, wire->name);
      if (!is_read(wire->net)) vme_data_wires_.push_back(wire.get());
    }
    for (int n : logic.targets) {
      if (is_read(n))
        glue_nets_.emplace_back(glue_.net(kWires.nets[static_cast<size_t>(n)].name), n);
    }
  }
  vme_data_ = glue_.net("vme_d_o");
}

// Where the fields of a port of the machine go: to inputs of parts, without a net between.
void Rack::wire_input(Port port) {
  Input &input = inputs_[port];
  const int n = input.net = Nets::find(kPortNames[port]);
  if (n < 0) throw std::runtime_error(std::string("rtl/mmcs.sv has no port ") + kPortNames[port]);
  const int width = kPortFields[port], whole = kWires.nets[static_cast<size_t>(n)].width;
  while (1 << input.shift < width) ++input.shift;
  input.fields = {0};
  for (int at = 0; at < whole; at += 1 << input.shift) {
    for (const Reader &r : readers_[static_cast<size_t>(n)]) {
      if (r.lsb >= at + width || at >= r.lsb + r.width) continue;
      if (own_card_ && own_card_->has(port, at)) continue;
      const PartPort &to = *r.wire->port;
      const int up = std::max(at - r.lsb, 0), down = std::max(r.lsb - at, 0);
      const uint64_t own = (uint64_t{1} << width) - 1, all = (uint64_t{1} << r.width) - 1;
      const uint64_t mask = (own >> down << up & all) << to.shift;
      input.arrivals.push_back({r.wire->part, mask, (up - down + to.shift) & 63, to.field});
    }
    input.fields.push_back(static_cast<unsigned>(input.arrivals.size()));
  }
}

// What is read of the boards' outputs: nets, lines, and what Model reads at any time.
void Rack::wire_outputs(const std::vector<char> &read) {
  for (const auto &part : parts_) {
    for (const auto &port : part->model.ports()) {
      if (port->wire && !read[static_cast<size_t>(port->wire->net)]) port->wire = nullptr;
      if (port->wire || !port->links.empty()) part->observe(*port);
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
  for (const auto &[name, bit] : kLinePorts) {
    const Wire *wire = of_adaptor(name);
    wire->part->line_mask |= wire->port->mask;
    line_wires_.emplace_back(wire, bit);
  }
  std::vector<const Wire *> sampled = {alive_, dtack_};
  for (const auto &[wire, bit] : line_wires_) sampled.push_back(wire);
  sampled.insert(sampled.end(), drives_.begin(), drives_.end());
  sampled.insert(sampled.end(), leds_.begin(), leds_.end());
  for (const Wire *wire : sampled) wire->part->observe(*wire->port);
}

}  // namespace mmcs
