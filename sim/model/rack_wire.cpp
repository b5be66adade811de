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

// Every port of every board on its net.
void Rack::wire() {
  readers_.resize(kWires.nets.size());
  by_bit_.resize(kWires.nets.size());
  followers_.resize(kWires.nets.size());
  due_.resize(kWires.logic.size());
  heard_.resize(static_cast<size_t>(kWires.cards));
  dips_.resize(static_cast<size_t>(kWires.cards));
  std::vector<char> read(kWires.nets.size());
  for (const PinInfo &info : kWires.pins) {
    Block &block = *blocks_[static_cast<size_t>(info.board)];
    auto slot = std::make_unique<Slot>();
    slot->block = &block;
    slot->port = block.find("", info.port);
    slot->port.width = info.width;
    slot->net = info.net;
    slot->lsb = info.lsb;
    slot->width = info.width;
    for (size_t p = 0; p < block.table.port_count; ++p) {
      if (std::strcmp(block.table.ports[p].name, info.port) == 0) slot->row = &block.table.ports[p];
    }
    if (!slot->row) throw std::runtime_error(std::string("a board has no port ") + info.port);
    block.look_of(*slot);
    const size_t net = static_cast<size_t>(info.net);
    const int card = info.board - 1;  // the cards follow the adaptor in rtl/mmcs.sv
    if (slot->row->out) {
      block.outs.push_back(slot.get());
    } else if (slot->row->heard) {
      heard_[static_cast<size_t>(card)].push_back(slot.get());
      for (int n = 0; n < 5; ++n) {
        if (std::strcmp(kBus[n], info.port) == 0) bus_[n] = info.net;
      }
      read[net] = 2;
    } else {
      readers_[net].push_back({info.lsb, info.width, slot.get()});
      read[net] = 1;
    }
    if (std::strcmp(info.port, "dip_i") == 0) dips_[static_cast<size_t>(card)] = slot->port;
    if (std::strcmp(info.port, "drive_v_o") == 0) drives_.push_back(slot.get());
    if (std::strcmp(info.port, "leds_o") == 0) leds_.push_back(slot.get());
    slots_.push_back(std::move(slot));
  }
  // Logic that nobody looks at need not be worked out, and what the bus master reads when it does.
  d_ = Wires::find("vme_d_o");
  for (size_t l = 0; l < kWires.logic.size(); ++l) {
    const LogicInfo &logic = kWires.logic[l];
    if (std::count(logic.targets.begin(), logic.targets.end(), d_) == 0) continue;
    d_logic_.push_back(static_cast<int>(l));
    for (const auto &slot : slots_) {
      if (slot->row->out &&
          std::count(logic.sources.begin(), logic.sources.end(), slot->net) != 0) {
        d_slots_.push_back(slot.get());
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
    const bool bare = MMCS_SOC && port == kVmeSysreset;
    const int n = ports_[port] = Wires::find(bare ? "sysreset_ni" : kPortNames[port]);
    if (n < 0 && MMCS_SOC && port < kVmeSysreset) continue;  // a SoC has no VMEbus
    if (n < 0) throw std::runtime_error(std::string("rtl/mmcs.sv has no port ") + kPortNames[port]);
    auto &bits = by_bit_[static_cast<size_t>(n)];
    bits.resize(static_cast<size_t>(kWires.nets[static_cast<size_t>(n)].width));
    for (const Reader &r : readers_[static_cast<size_t>(n)]) {
      r.slot->port.put(0);
      for (int bit = r.lsb; bit < r.lsb + r.width; ++bit) {
        bits[static_cast<size_t>(bit)].push_back(r);
      }
    }
    direct_[port] = followers_[static_cast<size_t>(n)].empty();
  }
  // An output matters to its board's neighbours if a pin or logic is on its net.
  adaptor_ = blocks_[0].get();
  for (auto &block : blocks_) {
    if (std::strcmp(block->table.module, "mark1") == 0) cards_.push_back(block.get());
    if (std::strcmp(block->table.module, "soc_host") == 0) host_ = block.get();
    auto &outs = block->outs;
    outs.erase(std::remove_if(outs.begin(), outs.end(),
                              [&](const Slot *s) {
                                const size_t n = static_cast<size_t>(s->net);
                                return !read[n];
                              }),
               outs.end());
    for (const Slot *s : outs) block->out_words.add(block->board().base, s->port);
  }
  alive_ = adaptor_->find("", "alive_o");
  static char one = 1;
  dtack_ = {&one, 1, 1, 1};
  if (!host_) {
    iackout_ = adaptor_->find("", "vme_iackout_no");
    d_oe_ = adaptor_->find("", "vme_d_oe_o");
    dtack_ = adaptor_->find("", "vme_dtack_no");
    adaptor_->out_words.add(adaptor_->board().base, dtack_);
  }
  const std::pair<const char *, int> lines[] = {{host_ ? "irq_req_o" : "vme_irq_no", host_ ? 5 : 1},
                                                {"panic_o", 8},
                                                {"brake_release_o", 9},
                                                {"sclock_o", 10}};
  for (const auto &[name, bit] : lines) {
    line_nets_.emplace_back(adaptor_->find("", name), bit);
    line_words_.add(adaptor_->board().base, line_nets_.back().first);
    adaptor_->out_words.add(adaptor_->board().base, line_nets_.back().first);
  }
  for (const Slot *s : adaptor_->outs) net_words_.add(adaptor_->board().base, s->port);
}

}  // namespace mmcs
