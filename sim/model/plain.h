// SPDX-License-Identifier: Apache-2.0
// rtl/mmcs.sv Verilated whole: every clock, both its edges, as a simulator would. With assertions
// and bus checkers, and in trace builds waveforms.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "board.h"
#include "model.h"
#if MMCS_TRACE
#include "waves.h"
#endif

namespace mmcs {

class Plain : public Model {
 public:
  Plain(uint64_t seed, const std::string &card);
  ~Plain() override;

  Stop run(int64_t n, int dtack, int64_t *ran) override;
  bool dtack() const override { return dtack_ && dtack_.get() == 0; }
  bool alive() const override { return alive_.get() != 0; }
  int16_t drive(int axis) const override;
  unsigned leds(int card) const override;
  unsigned vme_sample() override;
  uint64_t read(int reg) override { return nets_[static_cast<size_t>(reg)].get(); }
  void upset(int reg, uint64_t bits) override;
  void host_phase(unsigned phase, uint32_t pc) override;
  bool trace(const std::string &path) override;
  std::string take_doubt() override { return std::exchange(doubt_, ""); }

 protected:
  void power_on();
  void clock_once();
  void half(bool rise, double at);
  void look_at_lines();
  void hold_checkers(bool held);
  bool idle() const;
  void put_back(const Saved &state) override;
  void follow_card() override { exchange(true); }
  void exchange(bool card_changed);
  void apply_held_bits() {
    if (held_bits_.apply()) written();
  }
  void written();
  void look_for_errors();
  // A variable below the top, or a port of it.
  Net find(const std::string &path, const std::string &name) const;
  // Ports: what pins.h does to a machine.
  void put(Port port, int lsb, int width, uint64_t value) override;
  void stop_clock(bool stopped) override { stopped_ = stopped; }
  void cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) override;
  void stick(const std::string &reg, uint64_t clear, uint64_t set) override;

  const Context context_;
  std::unique_ptr<Board> board_;
  Net ports_[kPorts];
  std::vector<Net> card_inputs_, card_outputs_;  // ports that the own card is at, as it has them
  Net clk_, dtack_, d_oe_, drive_, leds_, alive_;
  std::vector<Net> nets_;      // of registers()
  std::vector<Net> checkers_;  // what forces the reset of each
  std::vector<std::pair<Net, int>> line_nets_;
  HeldBits held_bits_;
#if MMCS_TRACE
  std::unique_ptr<Waves> waves_;
#endif
  bool card_clocked_ = false;  // outputs of the own card have changed since the clock rose
  bool held_ = false;          // the checkers are in reset
  int idle_clks_ = 0, master_ = 0;
  bool doubted_ = false;  // an assertion has failed since the last upset
  std::string doubt_;
};

}  // namespace mmcs
