// SPDX-License-Identifier: Apache-2.0
// The machine made of its parts, each Verilated by itself, wired as rtl/mmcs.sv wires them. Terms:
// docs/simulator/simulator.md.
//
// Time: edge t is the clock that makes clock() t. All parts see their inputs as they were before
// the edge; a pin set at clock t is at the port after edge t + 1.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "glue.h"
#include "model.h"
#include "part.h"
#include "schedule.h"
#include "wires.h"

namespace mmcs {

// A port of a board on a net of rtl/mmcs.sv.
struct Wire {
  Part *part;
  const PartPort *port;
  int net, lsb, width;
  int board;
  const char *name;                // of the board's port
  uint64_t held = 0, held_at = 0;  // bits that a fault holds, and at what
  Net glue{};                      // of an output that the glue reads: there

  uint64_t through(uint64_t value) const { return (value & ~held) | held_at; }
  uint64_t get() const { return part->get(*port); }
  uint64_t value() const { return through(get()); }
};

class Rack : public Model {
 public:
  Rack(bool skip, uint64_t seed, const std::string &card);
  // The models take their names out of the context of the thread, which may be another machine's.
  ~Rack() override;

  // Every so many hits of a part are compared with the model; a difference is an error.
  void check(int hits) {
    for (const auto &part : parts_) part->check = hits;
    check_ = hits;
  }
  bool bus_cycle(const BusRequest &request, BusReply *reply) override;
  Stop run(int64_t n, int dtack, int64_t *ran) override;
  bool dtack() const override { return dtack_level() == 0; }
  bool alive() const override { return alive_->get() != 0; }
  int16_t drive(int axis) const override {
    if (pulled(axis / 2)) return own_card_->drive(axis);
    return static_cast<int16_t>(drives_[static_cast<size_t>(axis / 2)]->value() >> 16 * (axis & 1));
  }
  unsigned leds(int card) const override {
    return static_cast<unsigned>(leds_[static_cast<size_t>(card)]->value());
  }
  bool expect(std::vector<EncoderEdge> &edges) override;
  unsigned vme_sample() override;

  uint64_t read(int reg) override;
  void upset(int reg, uint64_t bits) override;
  int watch(const std::string &name) override;
  std::vector<CacheFigures> cache_figures() const override;

 protected:
  void stick(const std::string &reg, uint64_t clear, uint64_t set) override;
  void follow_card() override {
    card_.changed = own_card_ != nullptr;
    settle();
  }
  const Context context_;

 private:
  class Cycles;
  struct Watched {
    Part *part;
    Net net;
    uint32_t seen = 0;
    uint32_t get() const {
      if (part) part->load();  // else of an own card
      return static_cast<uint32_t>(net.get());
    }
  };
  // How it is wired (rack_wire.cpp).
  void add_parts(const BoardInfo &board);
  void wire();
  void wire_pin(const PinInfo &info, std::vector<char> &read);
  void wire_glue(std::vector<char> &read);
  void wire_input(Port port);
  void wire_outputs(const std::vector<char> &read);
  void wire_card(std::vector<char> &read);
  void ignore_unselected();
  template <class F>
  void for_ports(size_t board, int net, F f) {
    const size_t end = board + 1 < board_begin_.size() ? board_begin_[board + 1] : parts_.size();
    for (size_t n = board_begin_[board]; n < end; ++n) {
      for (const auto &port : parts_[n]->model.ports()) {
        if (port->row->net == net) f(*parts_[n], *port);
      }
    }
  }

  // Nets and time (rack.cpp).
  void put_net(int net, int lsb, int width, uint64_t value);
  void drive_net(Wire &wire);
  void update_input(Wire &wire);
  void send_outputs(Part &part);
  void power_on();
  void update_lines();
  void update_pc_bus();
  void eval_glue();
  void eval_card();
  void send_card();
  void settle();
  template <class Input>
  void put_input(Part &part, const Input &port, uint64_t value) {
    if (stopped_) part.pass(clock_);
    if (part.put(port, value, clock_)) inputs_changed(part);
  }
  void inputs_changed(const Part &part) { changed_inputs_ |= uint64_t{1} << part.number; }
  void plan(const Part &part) { schedule_.plan(part.number, part.due(), clock_); }
  int64_t first_due();
  void step(int64_t t);
  // What is at the ports after edge t. What waits in pins_ is older than encoder edges: the levels
  // of power-on wait when the first edge comes.
  void apply_inputs_until(int64_t t) {
    if (pins_.waiting()) pins_.apply();
    if (edges_.at <= t) apply_edges(t);
  }
  void apply_edges(int64_t t);
  void forget(Cache &cache);
  unsigned dtack_level() const { return dtack_ ? static_cast<unsigned>(dtack_->get()) : 1u; }

  // What is done to it from outside (rack_access.cpp).
  void put(Port port, int lsb, int width, uint64_t value) override;
  void stop_clock(bool stopped) override;
  void put_back(const Saved &state) override;
  void cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) override;
  const std::shared_ptr<Cache> &cache_of(const Part &part) { return caches_[part.model.module()]; }
  RegisterPlace &find(int reg, Part **part);
  void written(Part &part);
  Watched find_watched(const std::string &name);
  void compare_watched();

  const bool skip_;

  // The data fields of each part; nets; what Cycles has of its own.
  static constexpr size_t kFirstNet = Schedule::kMostParts * kMostFields;
  std::vector<uint32_t> data_ = std::vector<uint32_t>(kFirstNet + 2 * Nets::words() + 2);
  std::map<std::string, std::shared_ptr<Cache>> caches_;  // by module
  std::vector<std::unique_ptr<Part>> parts_;
  std::vector<size_t> board_begin_;  // the first part of each board

  Nets nets_;
  struct Reader {
    int lsb, width;
    Wire *wire;
  };
  std::vector<std::vector<Reader>> readers_;  // of each net
  std::vector<std::unique_ptr<Wire>> board_wires_;
  Glue glue_{*context_};
  bool glue_changed_ = true;                    // an output that the glue reads
  bool glue_stale_ = false;                     // its inputs are not those of the nets
  std::vector<Wire *> glue_wires_;              // outputs that it reads
  std::vector<std::pair<Net, int>> glue_nets_;  // what it drives for boards: its net, ours
  std::vector<Wire *> vme_data_wires_;          // outputs that lead to the bus master only
  Net vme_data_;                                // in the glue

  struct Input {
    int net = -1, shift = 0;  // its fields are 1 << shift wide
    std::vector<Link> arrivals;
    std::vector<unsigned> fields;  // the first arrival of each field; then the end
  };
  Input inputs_[kPorts];  // where each port of the machine leads

  struct CardInput {
    Wire *wire;
    size_t signal;
  };
  struct PcBus {
    enum { kAddress, kAen, kIor, kIow, kData, kSignals };
    static constexpr int kWidth[kSignals] = {16, 1, 1, 1, 8};
    Decoder decoder;
    int nets[kSignals] = {-1, -1, -1, -1, -1};
    unsigned values[kSignals] = {};  // as the selected cards have them
    std::vector<char> has_net;       // by net
    std::vector<std::vector<CardInput>> cards;
    std::vector<std::pair<Part *, const PartPort *>> switches;  // of each card
    std::vector<unsigned> dips;                                 // their values
    uint32_t selected = 0;                                      // cards, by bit
    bool changed = false, switches_changed = true, command = true;
  };
  PcBus pc_bus_;  // which selected cards alone receive

  struct {
    int nets[std::size(OwnCard::kInputs)] = {};
    int wait = -1;         // the net of pcx_wait_i
    bool changed = false;  // a net that it reads
    int rounds = 0;        // of it and the bus, since they settled
  } card_;

  struct {
    std::vector<EncoderEdge> all;
    size_t next = 0;
    int64_t at = kNever;  // the clock edge after which the next of them is at the ports
    void plan() { at = next < all.size() ? all[next].clock + 1 : kNever; }
  } edges_;

  Schedule schedule_;
  uint64_t changed_inputs_ = 0, all_parts_ = 0;  // by bit: with inputs to be evaluated; all
  uint64_t runs_ = 0;
  bool stop_lines_ = false;  // lines changed a clock ago

  const Wire *dtack_ = nullptr, *iackout_ = nullptr, *d_oe_ = nullptr, *alive_ = nullptr;
  std::vector<const Wire *> drives_, leds_;               // of each card
  std::vector<std::pair<const Wire *, int>> line_wires_;  // with their lowest bit in lines()
  std::vector<Watched> watched_;

  std::unique_ptr<Cycles> cycles_;  // bus cycles as one step; null: none yet
  int check_ = 0;                   // every so many of them are compared with their clocks
  unsigned checked_ = 0;
};

}  // namespace mmcs
