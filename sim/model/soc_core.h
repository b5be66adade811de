// SPDX-License-Identifier: Apache-2.0
// The host of mmcs_soc, with its processor, between the computer above it and its clocks: part of
// the machine as a whole, or a board of its own. Memory is looked at directly, while the processor
// waits for its report to be taken.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "board.h"
#include "model.h"

namespace mmcs {

class SocCore {
 public:
  // scope: of soc_host in the model of this board.
  // own: this board is the host alone.
  SocCore(const VerilatedContext &context, Board &board, const std::string &scope, bool own);

  void run(bool on) { run_.wanted = on; }
  void ring() { ++rings_; }
  void errors(unsigned accesses) { errors_wanted_ = static_cast<int>(accesses); }
  void watch(const std::function<void(SocStep, unsigned)> &watcher) { watcher_ = watcher; }
  uint32_t &word(unsigned n) const { return memory_[n % words_]; }
  void show(unsigned phase) { phase_ = phase; }
  unsigned shown() const { return busy() ? phase_ : 0; }  // asleep it is in no phase
  unsigned report() const { return report_; }
  void take_report() { report_ = 0; }
  unsigned take_bus_error() { return std::exchange(bus_error_, 0u); }
  bool halted() const { return report_ != 0 || bus_error_ != 0; }
  void open_interrupt(bool open) { irq_open_ = open; }

  // Before a clock of the machine: the processor's clocks that fall between two of them. The last
  // falls together with it: its clock is high then, but where both come by edge().
  void before_clock();
  // As a board of its own: that edge, of both clocks.
  void edge();
  // After it: the processor's clock is low.
  void after_clock();

  // The last clock changed nothing but what counts for ever, and nothing is on its way.
  bool rests();
  // So many clocks of the machine that were like it.
  void pass(int64_t clocks);

  // Registers of the host, and what is on its way in; put(): the registers once more.
  std::vector<uint8_t> save() const;
  size_t restore(const std::vector<uint8_t> &state);
  void put();

 private:
  // No reset can come by the next clocks: their registers may be evaluated without the clock's
  // edges.
  bool quick() const {
    return clocks_[0] != 0 && run_.wanted && run_.port.get() && run_q_.get() == 3 &&
           core_rst_.get();
  }
  bool busy() const { return (busy_.get() & 1) != 0; }
  void look_at_step();
  void hold_interrupt();
  Net inner(const std::string &path, const std::string &name) const;

  // An input of the SoC, and what stands at it after the next edge.
  struct Wire {
    Net port;
    unsigned wanted = 0;
  };
  const VerilatedContext &context_;
  Board &board_;
  const std::string scope_;
  std::vector<Net> registers_;
  std::vector<uint8_t> kept_;                       // of registers_, as restore() found them
  std::vector<std::pair<Net, uint64_t>> standing_;  // those that tell whether it rests
  Wire run_;
  uint64_t clocks_[2] = {0, 0};  // as triggers: the processor's, and both
  bool quick_ = false;           // this clock of the machine is
  Net clk_, run_q_, core_rst_, cpu_clk_, ring_, take_, report_valid_, report_port_;
  Net start_, clock_i_, done_, write_q_, a_q_, clock_q_, state_q_, timer_q_, far_req_;
  Net instr_req_, instr_addr_, irq_q_, busy_, us_, part_, cycles_;
  uint64_t cycles_before_ = 0, cycles_each_ = 0;
  uint32_t *memory_ = nullptr;
  unsigned words_ = 0;
  bool irq_open_ = false, taken_ = false;
  int rings_ = 0, errors_wanted_ = -1, errors_coming_ = -1, errors_left_ = 0;
  unsigned report_ = 0, bus_error_ = 0, phase_ = 0;
  std::function<void(SocStep, unsigned)> watcher_;
};

// A machine, Plain or Rack, whose host this is.
template <class Base>
class SocModel final : public Base {
 public:
  template <class... Arguments>
  explicit SocModel(Arguments... arguments)
      : Base(arguments...),
        core_(*this->context_, this->host_board(), this->host_scope(), this->host_alone()) {
    this->power_on();
  }

  void soc_run(bool on) override {
    core_.run(on);
    this->wake_host();
  }
  void soc_ring() override {
    core_.ring();
    this->wake_host();
  }
  void soc_errors(unsigned accesses) override {
    core_.errors(accesses);
    this->wake_host();
  }
  void watch_soc(const std::function<void(SocStep, unsigned)> &watcher) override {
    core_.watch(watcher);
  }
  uint32_t soc_read(unsigned word) const override { return core_.word(word); }
  void soc_write(unsigned word, uint32_t value) override { core_.word(word) = value; }
  void host_phase(unsigned phase, uint32_t) override { core_.show(phase); }
  unsigned report() const override { return core_.report(); }
  void take_report() override { core_.take_report(); }
  unsigned take_bus_error() override { return core_.take_bus_error(); }

  std::vector<uint8_t> save() override {
    this->catch_up_host();
    std::vector<uint8_t> bytes = core_.save();
    const std::vector<uint8_t> rest = Base::save();
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    return bytes;
  }
  void restore(const std::vector<uint8_t> &state) override {
    const auto head = static_cast<std::ptrdiff_t>(core_.restore(state));
    Base::restore({state.begin() + head, state.end()});
    core_.put();
    this->wake_host();
  }

 private:
  void before_clock() override { core_.before_clock(); }
  void host_edge() override { core_.edge(); }
  void after_clock() override {
    core_.after_clock();
    Base::host_phase(core_.shown(), 0);
  }
  bool halted() const override { return core_.halted(); }
  bool host_rests() override { return core_.rests(); }
  void host_pass(int64_t clocks) override { core_.pass(clocks); }
  void stick(const std::string &reg, uint64_t clear, uint64_t set) override {
    if (reg != "irq") return Base::stick(reg, clear, set);
    core_.open_interrupt(set != 0);
    this->wake_host();
  }

  SocCore core_;
};

}  // namespace mmcs
