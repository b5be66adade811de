// SPDX-License-Identifier: Apache-2.0
// The machine made of its boards, each Verilated by itself, wired as rtl/mmcs.sv wires them. A
// board at rest gets no clock (unit.h); docs/simulator/simulator.md tells how.
//
// Time: edge t is the clock that makes clock() t. Everything sees its inputs as they stood before
// the edge; a pin set at clock t stands at the port after edge t + 1.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "block.h"
#include "ears.h"
#include "model.h"
#include "wires.h"

namespace mmcs {

class Rack : public Model, protected Ports, private Listener {
 public:
  Rack(bool slow, bool skip, uint64_t seed);
  // The models take their names out of the context of the thread, which may be another machine's.
  ~Rack() override { Verilated::threadContextp(&context_); }

  void power_on();
  Stop run(int64_t n, int dtack, int64_t *ran) override;
  int64_t clock() const override { return clock_; }
  uint64_t evals() const override { return evals_; }
  void set_evals(uint64_t evals) override { evals_ = evals; }
  bool was_upset() const override { return upset_; }
  void set_upset(bool upset) override { upset_ = upset; }
  unsigned lines() const override { return lines_; }
  bool dtack() const override { return dtack_.get() == 0; }
  bool alive() const override { return alive_.get() != 0; }
  int16_t drive(int axis) const override {
    return static_cast<int16_t>(drives_[static_cast<size_t>(axis / 2)]->value() >> 16 * (axis & 1));
  }
  unsigned leds(int card) const override {
    return static_cast<unsigned>(leds_[static_cast<size_t>(card)]->value());
  }
  Pins &pins() override { return pins_; }
  bool expect(std::vector<EncoderEdge> &edges) override;
  unsigned vme_sample() override;

  uint64_t read(int reg) override;
  void upset(int reg, uint64_t bits) override;
  std::vector<uint8_t> save() override;
  void restore(const std::vector<uint8_t> &state) override;
  bool trace(const std::string &) override { return false; }
  int watch(const std::string &name) override;
  const std::string &failure() const override { return failure_; }

 protected:
  // A SoC's host is a board, too (soc_core.h). Around each clock of the machine that it gets:
  virtual void before_clock() {}
  virtual void host_edge() {}
  virtual void after_clock() {}
  virtual bool halted() const { return false; }
  // The last one changed nothing but what counts for ever; so many more were like it.
  virtual bool host_rests() { return false; }
  virtual void host_pass(int64_t) {}
  Board &host_board() { return *host_->board().model; }
  std::string host_scope() const { return host_->units[0].model->name() + ".soc_host"; }
  bool host_alone() const { return !slow_; }
  void wake_host();
  void catch_up_host();
  void stick(const std::string &reg, uint64_t clear, uint64_t set) override;
  VerilatedContext context_;

 private:
  void wire();
  void host_clocks();
  void plan_host(bool due);
  void step(int64_t t);
  void arrive_until(int64_t t);
  void changed(int net, int lsb, int width) override;
  void show(Slot &slot);
  void arrive(Slot &slot, uint64_t value);
  struct Reader;
  void arrive_directly(const Reader &reader, int lsb, int width, uint64_t value);
  void touch(Block &block);
  void drive(Slot &slot);
  bool outputs(Block &block);
  void look_at_lines();
  void alone(int64_t end);
  void settle();
  void catch_up(Block &block);
  void listen();
  void plan(const Block &block);
  int64_t cards_due();
  Net find(int reg, Block **block);
  Net find_watched(const std::string &name);
  void look_at_watched();
  struct Watched {
    Net net;
    uint32_t seen;
  };
  std::vector<Watched> watched_;
  std::vector<std::pair<Net, Block *>> nets_;  // of registers()
  // Ports: what pins.h does to a machine.
  void put(Port port, int lsb, int width, uint64_t value) override;
  void disturb() override { upset_ = true; }
  void stop_clock(bool stopped) override;
  void cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) override;
  uint64_t look(const std::string &reg) override { return read(find_register(reg)); }

  Wires wires_;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::vector<std::unique_ptr<Slot>> slots_;
  struct Reader {
    int lsb, width;
    Slot *slot;
  };
  std::vector<std::vector<Reader>> readers_;              // of each net
  std::vector<std::vector<std::vector<Reader>>> by_bit_;  // of each bit of the inputs' nets
  // Does something for each port that is on these bits of a net.
  template <class F>
  void for_readers(int net, int lsb, int width, F f) {
    const size_t n = static_cast<size_t>(net);
    const bool one = width == 1 && !by_bit_[n].empty();
    for (const Reader &r : one ? by_bit_[n][static_cast<size_t>(lsb)] : readers_[n]) {
      if (r.lsb < lsb + width && lsb < r.lsb + r.width) f(r);
    }
  }
  std::vector<std::vector<int>> followers_;  // logic that looks at each net
  std::vector<char> due_;                    // logic that must be worked out
  std::vector<int> logic_;
  std::vector<Block *> touched_;
  std::vector<const Slot *> drives_, leds_;
  int ports_[kPorts];
  bool direct_[kPorts];  // nothing but ports of boards is on this net: it has no value of its own
  // The bus that cards hear: nets by the decoder's ports, slots by card.
  Ears ears_;
  int bus_[5] = {-1, -1, -1, -1, -1};
  std::vector<std::vector<Slot *>> heard_;
  std::vector<Net> dips_;
  std::vector<Block *> cards_;
  uint32_t listening_ = 0, cut_ = 0;
  bool bus_moved_ = false, dips_moved_ = true;
  Pins pins_;
  std::vector<EncoderEdge> coming_;  // from coming_[next_coming_] on
  size_t next_coming_ = 0;
  // The edge after which the next of them stands at the ports.
  int64_t coming_at() const {
    return next_coming_ < coming_.size() ? coming_[next_coming_].clock + 1 : kNever;
  }
  Net dtack_, iackout_, d_oe_, alive_;
  int d_ = -1;  // the net of what the bus master reads, the logic and the port that it follows from
  std::vector<int> d_logic_;
  std::vector<Slot *> d_slots_;
  Block *adaptor_ = nullptr, *host_ = nullptr;
  int64_t host_clock_ = 0;  // the edge up to which the host is
  std::vector<std::pair<Net, int>> line_nets_;
  Words line_words_, net_words_;  // these; outputs that go to cards
  int64_t clock_ = 0;
  std::vector<int64_t> due_at_;  // the next edge of each board
  int64_t cards_due_ = 0;        // the earliest of those of cards, unless one has moved
  bool cards_moved_ = true;
  uint64_t evals_ = 0;
  unsigned lines_ = 0, shown_lines_ = 0;
  bool stop_lines_ = false;
  bool slow_, skip_;
  bool upset_ = false;
  bool stopped_ = false;  // no clock comes
  std::string failure_;
};

}  // namespace mmcs
