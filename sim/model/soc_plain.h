// SPDX-License-Identifier: Apache-2.0
// mmcs_soc, the machine with its own processor, between the computer above it and its pins. The
// memory is looked at directly, while the processor waits for its report to be taken.
#pragma once

#include <utility>

#include "plain.h"

namespace mmcs {

class SocPlain final : public Plain {
 public:
  explicit SocPlain(uint64_t seed);

  void soc_run(bool on) override { run_.wanted = on; }
  void soc_ring() override { ++rings_; }
  void soc_errors(unsigned accesses) override { errors_wanted_ = static_cast<int>(accesses); }
  void watch_soc(const std::function<void(SocStep, unsigned)> &watcher) override {
    watcher_ = watcher;
  }
  uint32_t soc_read(unsigned word) const override { return memory_[word % words_]; }
  void host_phase(unsigned phase, uint32_t) override { phase_ = phase; }
  void soc_write(unsigned word, uint32_t value) override { memory_[word % words_] = value; }
  unsigned report() const override { return report_; }
  void take_report() override { report_ = 0; }
  unsigned take_bus_error() override { return std::exchange(bus_error_, 0u); }
  std::vector<uint8_t> save() override;
  void restore(const std::vector<uint8_t> &state) override;

 private:
  void before_clock() override;
  void after_clock() override;
  bool halted() const override { return report_ != 0 || bus_error_ != 0; }
  void stick(const std::string &reg, uint64_t clear, uint64_t set) override;
  void look_at_step();
  void hold_interrupt();
  Net inner(const std::string &path, const std::string &name) const;

  // An input of the SoC, and what stands at it after the next edge.
  struct Wire {
    Net port;
    unsigned wanted = 0;
  };
  Wire run_;
  Net cpu_clk_, ring_, take_, report_valid_, report_port_;
  Net start_, clock_i_, done_, write_q_, a_q_, clock_q_, state_q_, timer_q_, far_req_;
  Net instr_req_, instr_addr_, irq_q_, busy_;
  uint32_t *memory_ = nullptr;
  unsigned words_ = 0;
  bool irq_open_ = false, taken_ = false;
  int rings_ = 0, errors_wanted_ = -1, errors_coming_ = -1, errors_left_ = 0;
  unsigned report_ = 0, bus_error_ = 0, phase_ = 0;
  std::function<void(SocStep, unsigned)> watcher_;
};

}  // namespace mmcs
