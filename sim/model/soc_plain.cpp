// SPDX-License-Identifier: Apache-2.0
// See soc_plain.h.

#include "soc_plain.h"

#include <cstring>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr uint64_t kServoVector = 0x2C;                      // machine external interrupt
constexpr uint64_t kTimeout = 16 * (MMCS_CLK_HZ / 1000000);  // of an access, as mmcs_soc sets it
const std::string kHost = "TOP.mmcs_soc.u_host";

}  // namespace

SocPlain::SocPlain(uint64_t seed) : Plain(seed) {
  run_.port = board_->port("run_i");
  cpu_clk_ = board_->port("cpu_clk_i");
  ring_ = board_->port("ring_i");
  take_ = board_->port("report_take_i");
  report_valid_ = board_->port("report_valid_o");
  report_port_ = board_->port("report_o");
  start_ = inner(".u_bridge", "start_i");
  clock_i_ = inner(".u_bridge", "clock_i");
  done_ = inner(".u_bridge", "done_o");
  far_req_ = inner(".u_bridge", "far_req");
  write_q_ = inner(".u_bridge", "write_q");
  a_q_ = inner(".u_bridge", "a_q");
  clock_q_ = inner(".u_bridge", "clock_q");
  state_q_ = inner(".u_bridge", "state_q");
  timer_q_ = inner(".u_bridge", "timer_q");
  instr_req_ = inner("", "instr_req");
  instr_addr_ = inner("", "instr_addr");
  irq_q_ = inner("", "irq_q");
  busy_ = inner(".u_cpu.u_ibex_core", "core_busy_o");
  const Net memory = inner(".u_ram", "memory");
  memory_ = reinterpret_cast<uint32_t *>(memory.at);
  words_ = static_cast<unsigned>(memory.bytes) / 4;
  power_on();
}

Net SocPlain::inner(const std::string &path, const std::string &name) const {
  const Net net = find_net(context_, kHost + path, name);
  if (!net) throw std::runtime_error("the SoC has no " + path + "." + name);
  return net;
}

// The processor's clocks that fall between two of the machine; the last falls together with it.
void SocPlain::before_clock() {
  for (int n = 1; n < MMCS_CPU_CLKS; ++n) {
    look_at_step();
    cpu_clk_.put(1);
    board_->eval();
    hold_interrupt();
    cpu_clk_.put(0);
    board_->eval();
  }
  look_at_step();
  // An access that is to fail: its time is over as it begins.
  if (errors_left_ > 0 && far_req_.get() && !clock_q_.get() && state_q_.get() == 0) {
    --errors_left_;
    bus_error_ = static_cast<unsigned>(a_q_.get()) << 1 | 1;
    timer_q_.put(kTimeout);
    board_->settle();
  }
  taken_ = report_valid_.get() && !take_.get();
  if (taken_) report_ = static_cast<unsigned>(report_port_.get());
  cpu_clk_.put(1);
}

// What the computer above sets passes a flip-flop on its way in.
void SocPlain::after_clock() {
  hold_interrupt();
  take_.put(taken_);
  run_.port.put(run_.wanted);
  ring_.put(rings_ > 0);
  if (rings_ > 0) --rings_;
  if (errors_coming_ >= 0) errors_left_ = errors_coming_;
  errors_coming_ = errors_wanted_;
  errors_wanted_ = -1;
  Plain::host_phase(busy_.get() & 1 ? phase_ : 0, 0);  // asleep it is in no phase
  cpu_clk_.put(0);
  board_->eval();
}

// What the processor does, as SocStep has it: nothing but these accesses and the fetch of the
// interrupt's vector tells the phases of a servo pass.
void SocPlain::look_at_step() {
  if (!watcher_) return;
  if (instr_req_.get() && instr_addr_.get() == kServoVector) watcher_(SocStep::kInterrupt, 0);
  if (start_.get() && !clock_i_.get()) watcher_(SocStep::kAccess, 0);
  if (done_.get() && !clock_q_.get()) {
    watcher_(write_q_.get() ? SocStep::kWrite : SocStep::kRead,
             static_cast<unsigned>(a_q_.get()) << 1 | 1);
  }
}

// The processor sees no interrupt while its wire is open.
void SocPlain::hold_interrupt() {
  if (!irq_open_ || irq_q_.get() == 0) return;
  irq_q_.put(0);
  board_->settle();
}

void SocPlain::stick(const std::string &reg, uint64_t clear, uint64_t set) {
  if (reg == "irq") {
    irq_open_ = set != 0;
  } else {
    Plain::stick(reg, clear, set);
  }
}

std::vector<uint8_t> SocPlain::save() {
  std::vector<uint8_t> bytes = Plain::save();
  const int32_t own[] = {static_cast<int32_t>(run_.wanted),
                         rings_,
                         errors_wanted_,
                         errors_coming_,
                         errors_left_,
                         static_cast<int32_t>(run_.port.get()),
                         static_cast<int32_t>(ring_.get()),
                         static_cast<int32_t>(take_.get())};
  const uint8_t *at = reinterpret_cast<const uint8_t *>(own);
  bytes.insert(bytes.begin(), at, at + sizeof own);
  return bytes;
}

void SocPlain::restore(const std::vector<uint8_t> &state) {
  int32_t own[8];
  if (state.size() < sizeof own) throw std::invalid_argument("a snapshot of another machine");
  std::memcpy(own, state.data(), sizeof own);
  run_.wanted = static_cast<unsigned>(own[0]);
  rings_ = own[1];
  errors_wanted_ = own[2];
  errors_coming_ = own[3];
  errors_left_ = own[4];
  run_.port.put(static_cast<uint64_t>(own[5]));
  ring_.put(static_cast<uint64_t>(own[6]));
  take_.put(static_cast<uint64_t>(own[7]));
  cpu_clk_.put(0);
  Plain::restore({state.begin() + sizeof own, state.end()});
  report_ = bus_error_ = 0;
}

}  // namespace mmcs
