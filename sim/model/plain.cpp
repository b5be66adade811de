// SPDX-License-Identifier: Apache-2.0
// See plain.h.

#include "plain.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "verilated.h"
#include "wires.h"

namespace mmcs {

std::unique_ptr<Board> create_Vmmcs(VerilatedContext &, const std::string &);
extern thread_local std::string printed;

namespace {

constexpr int kResetClks = 64;
constexpr double kPsPerClk = 1e12 / MMCS_CLK_HZ;
const std::string kTop = "TOP.mmcs";
const char *const kCheckers[] = {
#include "checkers.inc"
};
// After a way back the bus checkers begin anew when the buses have been idle for so long.
constexpr int kIdleClks = 16;

// Of what Verilator says of a failed assertion: its name and its sentence.
std::string sentence(const std::string &said) {
  const std::string before = "Assertion failed in TOP.";
  const size_t at = said.rfind(before);
  if (at != std::string::npos) return said.substr(at + before.size());
  return said.empty() ? "an assertion of the RTL failed" : said;
}

}  // namespace

Plain::Plain(uint64_t seed, const std::string &card) : context_(create_context(seed)) {
  context_->fatalOnError(false);
  context_->traceEverOn(MMCS_TRACE);
  context_->timeunit(-9);
  context_->timeprecision(-12);
  context_->assertOn(true);
  board_ = create_Vmmcs(*context_, "TOP");
  clk_ = board_->port("clk_i");
  dtack_ = board_->port("vme_dtack_no");
  d_oe_ = board_->port("vme_d_oe_o");
  drive_ = board_->port("drive_v_o");
  leds_ = board_->port("card_leds_o");
  alive_ = board_->port("alive_o");
  for (int port = 0; port < kPorts; ++port) {
    ports_[port] = board_->port(kPortNames[port]);
  }
  for (const Register &r : registers()) {
    const size_t dot = r.name.rfind('.');
    nets_.push_back(find(r.name.substr(0, dot), r.name.substr(dot + 1)));
    nets_.back().width = r.width;
  }
  for (const char *path : kCheckers) {
    find(path, "rst_ni__VforceVal").put(0);
    checkers_.push_back(find(path, "rst_ni__VforceEn"));
  }
  master_ = find_register("u_adaptor.u_core.u_master.state_q");
  for (const auto &[name, bit] : kLinePorts) line_nets_.emplace_back(board_->port(name), bit);
  for (const char *name : OwnCard::kInputs) card_inputs_.push_back(board_->port(name));
  for (const char *name : OwnCard::kOutputs) card_outputs_.push_back(board_->port(name));
  open_card(card);
  power_on();
}

Plain::~Plain() {
  use(context_);
#if MMCS_TRACE
  waves_.reset();
#endif
}

Net Plain::find(const std::string &path, const std::string &name) const {
  const Net net = find_net(*context_, scope_of(kTop, path), name);
  if (!net) throw std::runtime_error("the model has no " + path + "." + name);
  return net;
}

void Plain::power_on() {
  pins_.power_on();
  const Net reset = board_->port("rst_ni");
  reset.put(0);
  clock_ = -kResetClks;
  if (own_card_) board_->eval();  // the first frees what is cut
  pull_cards();
  follow_card();
  for (int i = 0; i < kResetClks; ++i) {
    if (i == 8) {
      reset.put(1);
      board_->eval();
      exchange(false);
    }
    if (i == kResetClks / 2) pins_.set(Pin::kSysreset, 0, 0);
    lines_ = shown_lines_;
    clock_once();
    ++clock_;
  }
  clock_ = 0;
  evals_ = 0;
  lines_ = shown_lines_;
}

void Plain::half(bool rise, double at) {
  const uint64_t now = static_cast<uint64_t>(std::llround(at));
  context_->time(now);
  clk_.put(rise);
  board_->eval();
  if (rise)
    card_clocked_ = own_card_ && own_card_->clock();
  else
    exchange(card_clocked_);
#if MMCS_TRACE
  if (waves_) waves_->dump(now);
#endif
}

// The machine and the own card follow each other until neither changes.
void Plain::exchange(bool card_changed) {
  if (!own_card_) return;
  for (int round = 0; round < OwnCard::kMostRounds; ++round) {
    if (card_changed) {
      for (size_t n = 0; n < card_outputs_.size(); ++n) {
        card_outputs_[n].put(own_card_->output(static_cast<OwnCard::Output>(n)));
      }
      board_->eval();
      look_at_card();
    }
    for (size_t n = 0; n < card_inputs_.size(); ++n) own_card_->put(n, card_inputs_[n].get());
    card_changed = own_card_->follow();
    if (!card_changed) return;
  }
  failure_ = OwnCard::kUnstable;
}

// A rising edge; held bits are put back; pins change; a falling edge.
void Plain::clock_once() {
  if (stopped_) {
    if (pins_.waiting()) pins_.apply();
    board_->eval();
    exchange(false);
    return look_at_lines();
  }
  const double t = static_cast<double>(clock_ + kResetClks) * kPsPerClk;
  half(true, t);
  apply_held_bits();
  if (pins_.waiting()) pins_.apply();
  half(false, t + kPsPerClk / 2);
  apply_held_bits();  // a pin may have begun a reset
  if (held_) {
    idle_clks_ = idle() ? idle_clks_ + 1 : 0;
    if (idle_clks_ == kIdleClks) hold_checkers(false);
  }
  look_at_lines();
}

// What follows from registers that were written: nets, and what these clear.
void Plain::written() {
  board_->settle();
  board_->eval();
  exchange(false);
}

void Plain::hold_checkers(bool held) {
  idle_clks_ = 0;
  held_ = held;
  for (const Net &reset : checkers_) reset.put(held);
}

// No cycle under way on either bus, nor the end of one.
bool Plain::idle() const {
  const bool vme = ports_[kVmeAs].get() == 1 && ports_[kVmeDs].get() == 3 &&
                   ports_[kVmeIack].get() == 1 && ports_[kVmeIackin].get() == 1 &&
                   ports_[kVmeSysreset].get() == 1 && !dtack() && d_oe_.get() == 0;
  return vme && nets_[static_cast<size_t>(master_)].get() == 0;
}

void Plain::look_at_lines() {
  unsigned lines = 0;
  for (const auto &[net, bit] : line_nets_) lines |= static_cast<unsigned>(net.get()) << bit;
  shown_lines_ = lines ^ kLineIrq;
}

Stop Plain::run(int64_t n, int dtack, int64_t *ran) {
  use(context_);
  return run_by(n, dtack, ran, [this](int64_t) {
    clock_once();
    look_for_errors();
    return 1;
  });
}

void Plain::look_for_errors() {
  if (!context_->gotError()) return;
  const std::string text = sentence(printed);
  if (!upset_ && failure_.empty()) failure_ = text;
  if (upset_ && !doubted_) {
    doubt_ = text;
    doubted_ = true;
  }
  printed.clear();
  context_->gotError(false);
  context_->gotFinish(false);
}

int16_t Plain::drive(int axis) const {
  if (pulled(axis / 2)) return own_card_->drive(axis);
  return static_cast<int16_t>(drive_.get(16 * axis, 16));
}

unsigned Plain::leds(int card) const {
  return static_cast<unsigned>(leds_.get(11 * card, 11));
}

unsigned Plain::vme_sample() {
  const auto port = [this](const char *name) {
    return static_cast<unsigned>(board_->port(name).get());
  };
  return port("vme_iackout_no") << 17 | port("vme_d_oe_o") << 16 | port("vme_d_o");
}

void Plain::put(Port port, int lsb, int width, uint64_t value) {
  if (!ports_[port] || (own_card_ && own_card_->take(port, lsb, value))) return;
  ports_[port].put(lsb, width, value);
}

// By Verilator's own means (plain.vlt).
void Plain::cut(const std::string &board, const char *port, uint64_t mask, uint64_t value) {
  find(board, std::string(port) + "__VforceVal").put(value);
  find(board, std::string(port) + "__VforceEn").put(mask);
}

void Plain::stick(const std::string &reg, uint64_t clear, uint64_t set) {
  held_bits_.hold(nets_[static_cast<size_t>(find_register(reg))], clear, set);
  apply_held_bits();
}

void Plain::upset(int reg, uint64_t bits) {
  use(context_);
  const Net &net = nets_[static_cast<size_t>(reg)];
  net.put(net.get() ^ bits);
  upset_ = true;
  doubted_ = false;
  written();
  apply_held_bits();  // a bit that is held does not flip
  look_at_lines();
}

// What the bus checkers remember is of the time before: they begin anew, as after power-on.
void Plain::put_back(const Saved &state) {
  use(context_);
  clock_ = state.clock;
  pins_.restore(state.pins);
  clk_.put(0);
  hold_checkers(!checkers_.empty());
  // More than once: a clear without a clock that falls with the snapshot's pins is over by then.
  const int last = own_card_ ? 2 : 1;
  for (int round = 0; round <= last; ++round) {
    for (size_t reg = 0; reg < nets_.size(); ++reg) nets_[reg].put(state.registers[reg]);
    board_->settle();
    if (own_card_) own_card_->restore(state.card);
    if (round == last) break;
    follow_card();
    board_->eval();
  }
  look_at_lines();
  lines_ = state.lines;
}

void Plain::host_phase([[maybe_unused]] unsigned phase, [[maybe_unused]] uint32_t pc) {
#if MMCS_TRACE
  find("u_host_view", "phase").put(phase & 7);
  find("u_host_view", "pc").put(pc);
#endif
}

bool Plain::trace(const std::string &path) {
#if MMCS_TRACE
  use(context_);
  waves_.reset();
  if (path.empty()) return false;
  waves_ = std::make_unique<Waves>(path);
  board_->trace(waves_.get());
  if (own_card_) waves_->add(*own_card_);
  waves_->open(path.c_str());
  if (!waves_->isOpen()) waves_.reset();
  return waves_ != nullptr;
#else
  static_cast<void>(path);
  return false;
#endif
}

#if MMCS_TRACE
std::unique_ptr<Model> Model::create(bool, uint64_t seed, const std::string &card) {
  return std::make_unique<Plain>(seed, card);
}
#endif

}  // namespace mmcs
