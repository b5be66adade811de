// SPDX-License-Identifier: Apache-2.0
// The machine made of its parts, each Verilated by itself, wired as rtl/mmcs.sv wires them. A part
// at rest gets no clock (part.h); docs/simulator/simulator.md tells how.
//
// Time: edge t is the clock that makes clock() t. Everything sees its inputs as they stood before
// the edge; a pin set at clock t stands at the port after edge t + 1.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ears.h"
#include "model.h"
#include "part.h"
#include "wires.h"

namespace mmcs {

// A port of a board on its net.
struct Wire {
  Part *part;
  const PartPort *port;
  int net, lsb, width;
  int board;
  const char *name;           // of the board's port
  uint64_t held = 0, at = 0;  // bits that a fault holds, and at what
  uint64_t shown = 0;         // of an output: what the net has of it

  uint64_t through(uint64_t value) const { return (value & ~held) | at; }
  uint64_t get() const { return part->get(*port); }
  uint64_t value() const { return through(get()); }
};

class Rack : public Model, private Listener {
 public:
  Rack(bool slow, bool skip, uint64_t seed);
  // The models take their names out of the context of the thread, which may be another machine's.
  ~Rack() override;

  void power_on();
  // Of so many hits of a part the model is asked about one, too; a difference is an error.
  void check(int hits) {
    for (const auto &part : parts_) part->check = hits;
  }
  Stop run(int64_t n, int dtack, int64_t *ran) override;
  bool dtack() const override { return level() == 0; }
  bool alive() const override { return alive_->get() != 0; }
  int16_t drive(int axis) const override {
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
  const Context context_;

 private:
  void wire();
  void select();
  int net_of(size_t board, const char *port);
  bool is_output(size_t board, int net);
  template <class F>
  void for_ports(size_t board, int net, F f) {
    const size_t end = board + 1 < first_.size() ? first_[board + 1] : parts_.size();
    for (size_t n = first_[board]; n < end; ++n) {
      for (const auto &port : parts_[n]->ports()) {
        if (port->row->net == net) f(*parts_[n], *port);
      }
    }
  }
  unsigned level() const { return dtack_ ? static_cast<unsigned>(dtack_->get()) : 1u; }
  void add_parts(const BoardInfo &board);
  void step(int64_t t);
  // What stands at the ports after edge t arrives. What waits is older: the levels of power-on wait
  // when the first edge comes.
  void arrive_until(int64_t t) {
    if (pins_.waiting()) pins_.apply();
    if (coming_at_ <= t) take_coming(t);
  }
  void changed(int net, int lsb, int width) override;
  void show(Wire &wire);
  template <class Input>
  void arrive(Part &part, const Input &port, uint64_t value) {
    if (stopped_) part.pass(clock_);
    if (part.put(port, value, clock_)) touch(part);
  }
  void touch(const Part &part) { touched_ |= uint64_t{1} << part.number; }
  void drive(Wire &wire);
  void tell(Part &part);
  void look_at_lines();
  void settle();
  void listen();
  void plan(const Part &part);
  void plan_all();
  int64_t first_due();
  int64_t first_later();
  void forget(Cache &cache);
  Place &find(int reg, Part **part);
  void written(Part &part);
  Net find_watched(const std::string &name);
  void look_at_watched();
  struct Watched {
    Net net;
    uint32_t seen;
  };
  std::vector<Watched> watched_;
  // Ports: what pins.h does to a machine.
  void put(Port port, int lsb, int width, uint64_t value) override;
  void put_wide(Port port, int lsb, int width, uint64_t value);
  void stop_clock(bool stopped) override;
  void put_back(const Saved &state) override;
  void cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) override;

  Wires wires_;
  std::map<std::string, std::shared_ptr<Cache>> caches_;  // by module
  std::vector<std::unique_ptr<Part>> parts_;
  std::vector<size_t> first_;  // of each board its first part: itself; then its chips
  std::vector<std::unique_ptr<Wire>> board_wires_;
  struct Reader {
    int lsb, width;
    Wire *wire;
  };
  std::vector<std::vector<Reader>> readers_;  // of each net
  std::vector<std::vector<int>> followers_;   // logic that looks at each net
  std::vector<char> due_;                     // logic that must be worked out
  std::vector<int> logic_;
  uint64_t touched_ = 0;  // parts that must follow
  std::vector<const Wire *> drives_, leds_;
  // A port of the machine. Nothing but ports of boards is on its net (then the net has no value of
  // its own): where each of its fields goes.
  struct Arrival {
    Part *part;
    uint64_t mask;
    int left, cell;  // rotated so far, to control inputs or, if this is not -1, to a cell
  };
  struct Input {
    int net = -1, shift = 0;
    std::vector<Arrival> arrivals;
    std::vector<unsigned> fields;  // of each field the first one; then the end
  };
  Input inputs_[kPorts];
  // The bus that cards hear: nets by the decoder's ports, wires by card.
  Ears ears_;
  static constexpr size_t kBusPorts = 5;
  int bus_[kBusPorts] = {-1, -1, -1, -1, -1};
  std::vector<char> on_bus_;  // by net
  struct Heard {
    Wire *wire;
    size_t net;  // in bus_
  };
  std::vector<std::vector<Heard>> heard_;
  std::vector<std::pair<Part *, const PartPort *>> dips_;
  std::vector<unsigned> dip_values_ = std::vector<unsigned>(static_cast<size_t>(kWires.cards));
  uint32_t listening_ = 0;
  unsigned heard_bus_[kBusPorts] = {};  // what they saw last
  bool bus_moved_ = false, dips_moved_ = true, commanded_ = true;
  std::vector<EncoderEdge> coming_;  // from coming_[next_coming_] on
  size_t next_coming_ = 0;
  int64_t coming_at_ = kNever;  // the edge after which the next of them stands at the ports
  void plan_coming() {
    coming_at_ = next_coming_ < coming_.size() ? coming_[next_coming_].clock + 1 : kNever;
  }
  void take_coming(int64_t t);
  const Wire *dtack_ = nullptr, *iackout_ = nullptr, *d_oe_ = nullptr, *alive_ = nullptr;
  int d_ = -1;  // the net of what the bus master reads, the logic and the port that it follows from
  std::vector<int> d_logic_;
  std::vector<Wire *> d_wires_;
  std::vector<std::pair<const Wire *, int>> lines_of_;
  // Parts: due at the next edge; at a later one before late_; from there on. The first later one;
  // 0: to be found.
  uint64_t due_next_ = 0, due_soon_ = 0, due_late_ = 0, every_ = 0;
  int64_t late_ = 0, first_later_ = 0, due_at_[64] = {};
  uint64_t runs_ = 0;
  bool stop_lines_ = false;
  bool slow_, skip_;
};

}  // namespace mmcs
