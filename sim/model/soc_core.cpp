// SPDX-License-Identifier: Apache-2.0
// See soc_core.h.

#include "soc_core.h"

#include <cstring>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr uint64_t kServoVector = 0x2C;  // machine external interrupt
constexpr uint64_t kClkMhz = MMCS_CLK_HZ / 1000000;
constexpr uint64_t kTimeout = 16 * kClkMhz;  // of an access, as mmcs_soc sets it
constexpr int32_t kMostRings = 1000;
const std::string kWhole = "TOP.mmcs_soc.u_host";
const std::pair<const char *, const char *> kRegisters[] = {
#include "extra.inc"
};

}  // namespace

SocCore::SocCore(const VerilatedContext &context, Board &board, const std::string &scope, bool own)
    : context_(context), board_(board), scope_(scope) {
  if (own) {
    clocks_[0] = board_.trigger("cpu_clk_i");
    clocks_[1] = clocks_[0] | board_.trigger("clk_i");
    if (clocks_[0] == 0 || clocks_[0] == clocks_[1])
      throw std::runtime_error("the SoC has no clock");
  }
  clk_ = board_.port("clk_i");
  run_q_ = inner("", "run_q");
  core_rst_ = inner("", "core_rst_nq");
  run_.port = board_.port("run_i");
  cpu_clk_ = board_.port("cpu_clk_i");
  ring_ = board_.port("ring_i");
  take_ = board_.port("report_take_i");
  report_valid_ = board_.port("report_valid_o");
  report_port_ = board_.port("report_o");
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
  us_ = inner("", "us_q");
  part_ = inner("", "pre_q");
  busy_ = inner(".u_cpu.u_ibex_core", "core_busy_o");
  cycles_ = inner(".u_cpu.u_ibex_core.cs_registers_i.mcycle_counter_i", "counter_q");
  const Net memory = inner(".u_ram", "memory");
  memory_ = reinterpret_cast<uint32_t *>(memory.at);
  words_ = static_cast<unsigned>(memory.bytes) / 4;
  for (const auto &[path, name] : kRegisters) {
    const Net net = inner(std::string(path).substr(kWhole.size()), name);
    registers_.push_back(net);
    // Memories change with other registers only.
    const bool counts = net.at == us_.at || net.at == part_.at || net.at == cycles_.at;
    if (!counts && net.bytes <= 8) standing_.emplace_back(net, 0);
  }
}

Net SocCore::inner(const std::string &path, const std::string &name) const {
  const Net net = find_net(context_, scope_ + path, name);
  if (!net) throw std::runtime_error("the SoC has no " + path + "." + name);
  return net;
}

void SocCore::before_clock() {
  quick_ = quick();
  for (int n = 1; n < MMCS_CPU_CLKS; ++n) {
    look_at_step();
    if (quick_) {
      board_.clocks(clocks_[0]);
      hold_interrupt();
      continue;
    }
    cpu_clk_.put(1);
    board_.eval();
    hold_interrupt();
    cpu_clk_.put(0);
    board_.eval();
  }
  look_at_step();
  // An access that is to fail: its time is over as it begins.
  if (errors_left_ > 0 && far_req_.get() && !clock_q_.get() && state_q_.get() == 0) {
    --errors_left_;
    bus_error_ = static_cast<unsigned>(a_q_.get()) << 1 | 1;
    timer_q_.put(kTimeout);
    board_.settle();
  }
  taken_ = report_valid_.get() && !take_.get();
  if (taken_) report_ = static_cast<unsigned>(report_port_.get());
  cpu_clk_.put(!quick_);
}

void SocCore::edge() {
  if (quick_) {
    board_.clocks(clocks_[1]);
  } else {
    clk_.put(1);
    board_.eval();
    clk_.put(0);
  }
}

// What the computer above sets passes a flip-flop on its way in.
void SocCore::after_clock() {
  hold_interrupt();
  take_.put(taken_);
  run_.port.put(run_.wanted);
  ring_.put(rings_ > 0);
  if (rings_ > 0) --rings_;
  if (errors_coming_ >= 0) errors_left_ = errors_coming_;
  errors_coming_ = errors_wanted_;
  errors_wanted_ = -1;
  if (quick_) {
    board_.inputs();
    return;
  }
  cpu_clk_.put(0);
  board_.eval();
}

// What the processor does, as SocStep has it: nothing but these accesses and the fetch of the
// interrupt's vector tells the phases of a servo pass.
void SocCore::look_at_step() {
  if (!watcher_) return;
  if (instr_req_.get() && instr_addr_.get() == kServoVector) watcher_(SocStep::kInterrupt, 0);
  if (start_.get() && !clock_i_.get()) watcher_(SocStep::kAccess, 0);
  if (done_.get() && !clock_q_.get()) {
    watcher_(write_q_.get() ? SocStep::kWrite : SocStep::kRead,
             static_cast<unsigned>(a_q_.get()) << 1 | 1);
  }
}

// The processor sees no interrupt while its wire is open.
void SocCore::hold_interrupt() {
  if (!irq_open_ || irq_q_.get() == 0) return;
  irq_q_.put(0);
  board_.settle();
}

bool SocCore::rests() {
  cycles_each_ = cycles_.get() - cycles_before_;
  cycles_before_ = cycles_.get();
  if (busy() || irq_open_ || take_.get() || ring_.get() || rings_ > 0) return false;
  if (errors_coming_ >= 0 || errors_wanted_ >= 0 || run_.port.get() != run_.wanted) return false;
  bool moved = false;
  for (auto &[net, before] : standing_) {
    const uint64_t now = net.get();
    moved = moved || now != before;
    before = now;
  }
  return !moved;
}

// Asleep it counts microseconds, and cycles as in the last clock; both wrap as they do by clocks.
void SocCore::pass(int64_t clocks) {
  const uint64_t n = static_cast<uint64_t>(clocks), parts = part_.get() + n;
  us_.put(us_.get() + parts / kClkMhz);
  part_.put(parts % kClkMhz);
  cycles_.put(cycles_.get() + n * cycles_each_);
  board_.settle();
}

std::vector<uint8_t> SocCore::save() const {
  const int32_t own[] = {static_cast<int32_t>(run_.wanted),
                         rings_,
                         errors_wanted_,
                         errors_coming_,
                         errors_left_,
                         static_cast<int32_t>(run_.port.get()),
                         static_cast<int32_t>(ring_.get()),
                         static_cast<int32_t>(take_.get())};
  const uint8_t *at = reinterpret_cast<const uint8_t *>(own);
  std::vector<uint8_t> bytes(at, at + sizeof own);
  for (const Net &net : registers_) bytes.insert(bytes.end(), net.at, net.at + net.bytes);
  return bytes;
}

size_t SocCore::restore(const std::vector<uint8_t> &state) {
  int32_t own[8];
  size_t size = sizeof own;
  for (const Net &net : registers_) size += static_cast<size_t>(net.bytes);
  if (state.size() < size) throw std::invalid_argument("a snapshot of another machine");
  std::memcpy(own, state.data(), sizeof own);
  const int32_t most[] = {1, kMostRings, INT32_MAX, INT32_MAX, INT32_MAX, 1, 1, 1};
  for (int n = 0; n < 8; ++n) {
    const int32_t least = n >= 2 && n <= 3 ? -1 : 0;  // of errors that nobody wants
    if (own[n] < least || own[n] > most[n]) {
      throw std::invalid_argument("a snapshot of another machine");
    }
  }
  kept_.assign(state.begin() + sizeof own, state.begin() + static_cast<std::ptrdiff_t>(size));
  run_.wanted = static_cast<unsigned>(own[0]);
  rings_ = own[1];
  errors_wanted_ = own[2];
  errors_coming_ = own[3];
  errors_left_ = own[4];
  run_.port.put(static_cast<uint64_t>(own[5]));
  ring_.put(static_cast<uint64_t>(own[6]));
  take_.put(static_cast<uint64_t>(own[7]));
  cpu_clk_.put(0);
  report_ = bus_error_ = 0;
  return size;
}

void SocCore::put() {
  const uint8_t *at = kept_.data();
  for (const Net &net : registers_) {
    net.load(at);
    at += net.bytes;
  }
  board_.settle();
}

}  // namespace mmcs
