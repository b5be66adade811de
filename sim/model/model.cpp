// SPDX-License-Identifier: Apache-2.0
// Length: one class around one hot loop, with the table of its pins.
// The Verilated machine: clock loop, pins, hands. One translation unit with the generated code of
// the design in the speed build, so that the compiler sees the whole loop. Above 400 lines, as it
// is one class, of which a tenth is the table of pins.

#include "model.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "fields.h"
#include "verilated.h"
#if MMCS_TRACE
#include "verilated_fst_c.h"
#endif
#if MMCS_SAVABLE
#include "memory_save.h"
#endif

#include "Vmmcs.h"
#include "Vmmcs___024root.h"
#include "Vmmcs__Dpi.h"
#include "upset.h"
#if MMCS_SOC
#include "soc_memory.h"
#endif

void Vmmcs___024root___eval(Vmmcs___024root *);
void Vmmcs___024root___eval_settle(Vmmcs___024root *);
void Vmmcs___024root___eval_nba(Vmmcs___024root *);
bool Vmmcs___024root___eval_phase__act(Vmmcs___024root *);

// A clock's evaluation may go straight to the registers; see clock_once().
#define MMCS_DIRECT (MMCS_GATE && !MMCS_SOC)

namespace mmcs {
namespace {

constexpr int kCards = MMCS_CARDS;
constexpr int kResetClks = 64;
#if MMCS_SOC
constexpr int kCpuClks = MMCS_CPU_CLKS;  // of the processor, in one of the machine
#endif
constexpr double kPsPerClk = 1e12 / MMCS_CLK_HZ;
// svPutUserData wants a key; its address is enough.
int user_key;
// What the model prints and where it stopped; collected here until the run that caused it looks.
thread_local std::string printed;

class ModelImpl final : public Model {
 public:
  ModelImpl(bool two_evals, uint64_t seed) : two_evals_wanted_(two_evals), two_evals_(two_evals) {
    context_.randReset(2);
    context_.randSeed(static_cast<int>(seed % 0x7FFFFFFF) + 1);
    context_.fatalOnError(false);
    context_.traceEverOn(MMCS_TRACE);
    context_.timeunit(-9);
    context_.timeprecision(-12);
    context_.assertOn(true);
    Verilated::threadContextp(&context_);
    top_ = std::make_unique<Vmmcs>(&context_, "TOP");
    power_on();
  }
  ~ModelImpl() override {
    enter();
#if MMCS_TRACE
    if (fst_) fst_->close();
#endif
    top_->final();
  }

  Stop run(int64_t n, int dtack, int64_t *ran) override;
  int64_t clock() const override { return clock_; }
  uint64_t evals() const override { return evals_; }
  unsigned lines() const override { return lines_; }
  bool dtack() const override { return !top_->vme_dtack_no; }

  void set(Pin pin, int index, unsigned value) override;
  void set_encoder(int axis, unsigned pins) override {
    dirty_ = true;
    put_field(top_->enc_a_i, axis, 1, pins & 1);
    put_field(top_->enc_b_i, axis, 1, pins >> 1 & 1);
    put_field(top_->enc_i_i, axis, 1, pins >> 2 & 1);
  }
  int16_t drive(int axis) const override {
    return static_cast<int16_t>(get_field(top_->drive_v_o, 16 * axis, 16));
  }
  unsigned leds(int card) const override {
    return static_cast<unsigned>(get_field(top_->card_leds_o, 11 * card, 11));
  }

#if MMCS_TRACE
  void host_phase(unsigned phase, [[maybe_unused]] uint32_t pc) override {
    top_->host_phase_i = phase & 7;
#if !MMCS_SOC
    top_->host_pc_i = pc;
#endif
  }
#endif

#if MMCS_SOC
  void vme_address(unsigned, unsigned, bool, bool, unsigned) override {}
  void vme_strobe(unsigned, bool) override {}
  void vme_iackin(bool) override {}
  void vme_release() override {}
  unsigned vme_sample() override { return 0x2FFFF; }
  void soc_run(bool on) override {
    dirty_ = true;
    top_->soc_run_i = on;
  }
  void soc_ring() override {
    dirty_ = true;
    top_->soc_ring_i = !top_->soc_ring_i;
  }
  void soc_errors(unsigned accesses) override {
    dirty_ = true;
    top_->soc_errors_i = (~top_->soc_errors_i & 0x10000u) | std::min(accesses, 0xFFFFu);
  }
  void watch_soc(const std::function<void(SocStep, unsigned)> &watcher) override {
    watcher_ = watcher;
  }
  uint32_t soc_read(unsigned word) const override { return soc_word(*top_->rootp, word); }
  void soc_write(unsigned word, uint32_t value) override { soc_word(*top_->rootp, word) = value; }
#else
  void soc_run(bool) override {}
  void soc_ring() override {}
  void soc_errors(unsigned) override {}
  uint32_t soc_read(unsigned) const override { return 0; }
  void soc_write(unsigned, uint32_t) override {}
  void vme_address(unsigned address, unsigned am, bool write, bool lword, unsigned data) override {
    enter();
    mmcs_vme_address(address, am, write, lword, data);
  }
  void vme_strobe(unsigned ds, bool iack) override {
    enter();
    mmcs_vme_strobe(ds, iack);
  }
  void vme_iackin(bool low) override {
    enter();
    mmcs_vme_iackin(low);
  }
  void vme_release() override {
    enter();
    mmcs_vme_release();
  }
  unsigned vme_sample() override {
    enter();
    return mmcs_vme_sample();
  }
#endif
  unsigned report() const override { return report_; }
  void take_report() override { report_ = 0; }
  unsigned take_bus_error() override { return std::exchange(bus_error_, 0u); }

  uint16_t encoder_register(int axis) override;
  uint64_t digest() override;
  void upset(Register reg, int axis, unsigned bits) override;
  std::vector<uint8_t> save() override;
  void restore(const std::vector<uint8_t> &state) override;
  bool trace(const std::string &path) override;
  const std::string &failure() const override { return failure_; }

  void lines_changed(unsigned lines) {
    lines_ = lines;
    lines_changed_ = true;
  }
  void reported(unsigned what) { report_ = what; }
  void bus_error(unsigned offset) { bus_error_ = offset; }
  void stepped(SocStep step, unsigned offset) {
    if (watcher_) watcher_(step, offset);
  }

 private:
  void power_on();
  void clock_once();
#if MMCS_DIRECT
  void clock_known();
  void clock_triggered(uint64_t triggers);
  uint64_t triggered_by(CData &before);
#endif
  void learn_triggers();
  void clock_plain();
  void set_clocks(bool level);
  void rest_clocks_high();
#if MMCS_SOC
  // Without gating the processor's clock never rests.
  bool cpu_awake() const { return !MMCS_GATE || top_->cpu_awake_o; }
#endif
  void settle_clock();
  // The exported functions act on the instance whose scope is set, and may move a hand.
  void enter() {
    dirty_ = true;
    Verilated::threadContextp(&context_);
    svSetScope(scope_);
  }
  void look_at(int axis);
  void check_failure();

  VerilatedContext context_;
  std::unique_ptr<Vmmcs> top_;
#if MMCS_TRACE
  std::unique_ptr<VerilatedFstC> fst_;
#endif
  svScope scope_ = nullptr;
  std::vector<svScope> probes_;
  int64_t clock_ = 0;
  uint64_t evals_ = 0;
  unsigned lines_ = 0;
  bool lines_changed_ = false;
  unsigned report_ = 0;
  unsigned bus_error_ = 0;
  std::function<void(SocStep, unsigned)> watcher_;
  bool dirty_ = true;  // a pin or hand has moved since the last clock
  bool moved_ = true;  // before that clock
  uint64_t by_clk_ = 0, by_adaptor_ = 0, by_cards_ = 0;  // what these clocks trigger
  const bool two_evals_wanted_;
  bool two_evals_;  // as wanted, or because the waveforms are being recorded
  std::string failure_;
};

// One rising edge by one evaluation, with liberties that are of this pinned version of Verilator.
// Edges are found by comparing the clock with its value at the last evaluation, kept in the
// variable named here; setting that to 0 stands for the falling edge, at which nothing in this
// design happens (one clock, rising edges only). The evaluation is called without the wrapper
// around it, which locks two mutexes for messages between threads and objects to delete, of which
// there are none. And as long as no pin moves there is nothing to be found out: what a rising clock
// triggers is known (learn_triggers()), and so the evaluation goes straight to the registers.
// Together they save two thirds of the time. Only this, learn_triggers() and upset() touch names
// internal to Verilator; test_one_eval_equals_two compares it with clock_plain().
inline void ModelImpl::clock_once() {
#if MMCS_DIRECT
  if (!dirty_ && !moved_) {
    clock_known();
    return;
  }
  moved_ = dirty_;
#endif
#if MMCS_SOC
  // The processor's clocks that fall within this one, then the one that falls together with it.
  for (int n = 1; n < kCpuClks && cpu_awake(); ++n) {
    top_->rootp->__Vtrigprevexpr___TOP__cpu_clk_i__0 = 0;
    Vmmcs___024root___eval(top_->rootp);
  }
  if (cpu_awake()) top_->rootp->__Vtrigprevexpr___TOP__cpu_clk_i__0 = 0;
#endif
  top_->rootp->__Vtrigprevexpr___TOP__clk_i__0 = 0;
#if MMCS_GATE
  if (dirty_ | top_->adaptor_awake_o) top_->rootp->__Vtrigprevexpr___TOP__clk_adaptor_i__0 = 0;
  if (dirty_ | top_->cards_awake_o) top_->rootp->__Vtrigprevexpr___TOP__clk_cards_i__0 = 0;
#endif
  Vmmcs___024root___eval(top_->rootp);
}

#if MMCS_DIRECT
// The registers behind these clocks, then what follows from them: a reset that the machine gives
// itself is an edge that has to be looked for.
inline void ModelImpl::clock_triggered(uint64_t triggers) {
  Vmmcs___024root &r = *top_->rootp;
  r.__VnbaTriggered[0] = triggers;
  Vmmcs___024root___eval_nba(&r);
  r.__VnbaTriggered[0] = 0;
  if (r.mmcs_sim_top__DOT__u_mmcs__DOT__card_rst_n !=
      r.__Vtrigprevexpr___TOP__mmcs_sim_top__DOT__u_mmcs__DOT__card_rst_n__0) {
    Vmmcs___024root___eval(&r);
  }
}

inline void ModelImpl::clock_known() {
  uint64_t triggers = by_clk_;
  if (top_->adaptor_awake_o) triggers |= by_adaptor_;
  if (top_->cards_awake_o) triggers |= by_cards_;
  clock_triggered(triggers);
}

// What the rise of one clock alone triggers.
uint64_t ModelImpl::triggered_by(CData &before) {
  Vmmcs___024root &r = *top_->rootp;
  before = 0;
  Vmmcs___024root___eval_phase__act(&r);
  const uint64_t triggers = r.__VnbaTriggered[0];
  r.__VnbaTriggered = decltype(r.__VnbaTriggered){};
  return triggers;
}
#endif

void ModelImpl::learn_triggers() {
#if MMCS_DIRECT
  Vmmcs___024root &r = *top_->rootp;
  rest_clocks_high();
  by_clk_ = triggered_by(r.__Vtrigprevexpr___TOP__clk_i__0);
  by_adaptor_ = triggered_by(r.__Vtrigprevexpr___TOP__clk_adaptor_i__0);
  by_cards_ = triggered_by(r.__Vtrigprevexpr___TOP__clk_cards_i__0);
#endif
}

// A gated clock rises only where its block is awake, or inputs have moved.
void ModelImpl::set_clocks(bool level) {
#if MMCS_GATE
  top_->clk_adaptor_i = level && (dirty_ || top_->adaptor_awake_o);
  top_->clk_cards_i = level && (dirty_ || top_->cards_awake_o);
#endif
#if MMCS_SOC
  top_->cpu_clk_i = level && cpu_awake();
#endif
  top_->clk_i = level;
}

// Both edges, as a simulator would.
void ModelImpl::clock_plain() {
#if MMCS_TRACE
  const double t = static_cast<double>(clock_ + kResetClks) * kPsPerClk;
  const uint64_t rise = static_cast<uint64_t>(t + 0.5);
  const uint64_t fall = static_cast<uint64_t>(t + kPsPerClk / 2 + 0.5);
  context_.time(rise);
#endif
#if MMCS_SOC
  for (int n = 1; n < kCpuClks && cpu_awake(); ++n) {
    for (int level = 1; level >= 0; --level) {
#if MMCS_TRACE
      // between the fall before and this rise
      const uint64_t at = static_cast<uint64_t>(
          t - kPsPerClk + kPsPerClk * (2 * n + 1 - level) / (2 * kCpuClks) + 0.5);
      context_.time(at);
#endif
      top_->cpu_clk_i = level;
      top_->eval();
#if MMCS_TRACE
      if (fst_) fst_->dump(at);
#endif
    }
  }
#if MMCS_TRACE
  context_.time(rise);
#endif
#endif
  set_clocks(1);
  top_->eval();
#if MMCS_TRACE
  if (fst_) fst_->dump(rise);
  context_.time(fall);
#endif
  set_clocks(0);
  top_->eval();
#if MMCS_TRACE
  if (fst_) fst_->dump(fall);
#endif
}

void ModelImpl::power_on() {
  set_clocks(0);
  top_->rst_ni = 0;
  top_->sysreset_i = 1;
  top_->moved_i = 1;
  put_field(top_->axis_enable_i, 0, 2 * kCards, ~0ull);
  top_->eval();
  scope_ = svGetScopeFromName("TOP.mmcs_sim_top");
  if (!scope_) throw std::runtime_error("the model has no scope mmcs_sim_top");
  for (int axis = 0; axis < 2 * kCards; ++axis) {
    const std::string name = "TOP.mmcs_sim_top.g_probe[" + std::to_string(axis / 2) + "].u_joint" +
                             std::to_string(axis % 2 + 1);
    probes_.push_back(svGetScopeFromName(name.c_str()));
    if (!probes_.back()) throw std::runtime_error("the model has no scope " + name);
  }
  svPutUserData(scope_, &user_key, this);
  enter();
  clock_ = -kResetClks;
  for (int i = 0; i < kResetClks; ++i, ++clock_) {
    if (i == 8) top_->rst_ni = 1;
    if (i == kResetClks / 2) top_->sysreset_i = 0;
    clock_plain();
  }
  clock_ = 0;
  if (!two_evals_) {
    learn_triggers();
    rest_clocks_high();
  }
  lines_changed_ = false;
}

// Where clock_once() finds them.
void ModelImpl::rest_clocks_high() {
  top_->clk_i = 1;
  top_->rootp->__Vtrigprevexpr___TOP__clk_i__0 = 1;
#if MMCS_SOC
  top_->cpu_clk_i = 1;
  top_->rootp->__Vtrigprevexpr___TOP__cpu_clk_i__0 = 1;
#endif
#if MMCS_GATE
  top_->clk_adaptor_i = 1;
  top_->clk_cards_i = 1;
  top_->rootp->__Vtrigprevexpr___TOP__clk_adaptor_i__0 = 1;
  top_->rootp->__Vtrigprevexpr___TOP__clk_cards_i__0 = 1;
#endif
}

// Both ways of clocking start from their own level of the clock.
void ModelImpl::settle_clock() {
  if (two_evals_) {
    set_clocks(0);
    top_->eval();
  } else {
    rest_clocks_high();
  }
}

Stop ModelImpl::run(int64_t n, int dtack, int64_t *ran) {
  Verilated::threadContextp(&context_);
  svSetScope(scope_);
  int64_t done = 0;
  Stop stop = Stop::kDone;
  // Compared after every clock; 2 matches neither level.
  const unsigned wanted = dtack < 0 ? 2u : static_cast<unsigned>(dtack);
  while (done < n) {
    top_->moved_i = dirty_;
    if (two_evals_) {
      clock_plain();
    } else {
      clock_once();
    }
    dirty_ = false;
    ++done;
    ++clock_;
    ++evals_;
    if (lines_changed_) {
      lines_changed_ = false;
      stop = Stop::kLines;
      break;
    }
    if (report_ != 0 || bus_error_ != 0) {
      stop = Stop::kReport;
      break;
    }
    if (top_->vme_dtack_no == wanted) {
      stop = Stop::kDtack;
      break;
    }
#if !MMCS_SPEED
    if (context_.gotError()) {
      check_failure();
      stop = Stop::kFailed;
      break;
    }
#endif
  }
  *ran = done;
  return stop;
}

void ModelImpl::check_failure() {
  if (failure_.empty()) failure_ = printed.empty() ? "an assertion of the RTL failed" : printed;
  printed.clear();
  context_.gotError(false);
  context_.gotFinish(false);
}

void ModelImpl::set(Pin pin, int index, unsigned value) {
  dirty_ = true;
  Vmmcs &p = *top_;
  switch (pin) {
    case Pin::kSysreset:
      p.sysreset_i = value & 1;
      break;
    case Pin::kEstop:
      p.estop_i = value & 1;
      break;
    case Pin::kCableCut:
      p.cable_cut_i = value & 1;
      break;
    case Pin::kPcOff:
      p.pc_off_i = value & 1;
      break;
    case Pin::kIrqLost:
      p.irq_lost_i = value & 1;
      break;
    case Pin::kIrqOpen:
#if MMCS_SOC
      p.soc_irq_open_i = value & 1;
#endif
      break;
    case Pin::kAxisEnable:
      put_field(p.axis_enable_i, index, 1, value);
      break;
    case Pin::kAdcStuck:
      put_field(p.adc_stuck_i, index, 1, value);
      break;
    case Pin::kCardAbsent:
      put_field(p.card_absent_i, index, 1, value);
      break;
    case Pin::kSclockOpen:
      put_field(p.sclock_open_i, index, 1, value);
      break;
    case Pin::kPanicOpen:
      put_field(p.panic_open_i, index, 1, value);
      break;
    case Pin::kDipXor:
      put_field(p.dip_xor_i, 4 * index, 4, value);
      break;
    case Pin::kDacStuck1:
      put_field(p.dac_stuck1_i, 12 * index, 12, value);
      break;
    case Pin::kDacStuck0:
      put_field(p.dac_stuck0_i, 12 * index, 12, value);
      break;
    case Pin::kAdcV:
      put_field(p.adc_v_i, 16 * index, 16, value);
      break;
    case Pin::kCount:
      break;
  }
}

// The probe of the axis, a scope of its own; the hands' scope comes back with the next enter().
void ModelImpl::look_at(int axis) {
  dirty_ = true;
  Verilated::threadContextp(&context_);
  svSetScope(probes_[static_cast<size_t>(axis)]);
}

uint16_t ModelImpl::encoder_register(int axis) {
  look_at(axis);
  return static_cast<uint16_t>(mmcs_encoder_register());
}

uint64_t ModelImpl::digest() {
  enter();
  uint64_t hash = 0xCBF29CE484222325ull ^ mmcs_adaptor_digest();
  for (int axis = 0; axis < 2 * kCards; ++axis) {
    look_at(axis);
    const uint64_t word = uint64_t{mmcs_axis_digest()} << 16 | (mmcs_encoder_register() & 0xFFFF);
    hash = (hash ^ word) * 0x100000001B3ull;
  }
  return hash;
}

void ModelImpl::upset(Register reg, int axis, unsigned bits) {
  enter();
  flip_register(*top_->rootp, reg, axis, bits);
  Vmmcs___024root___eval_settle(top_->rootp);
}

#if MMCS_SAVABLE
std::vector<uint8_t> ModelImpl::save() {
  Verilated::threadContextp(&context_);
  MemorySave out;
  out << *top_;
  out.put(&clock_, sizeof clock_);
  out.put(&evals_, sizeof evals_);
  out.put(&lines_, sizeof lines_);
  out.put(&dirty_, sizeof dirty_);
  return out.take();
}

void ModelImpl::restore(const std::vector<uint8_t> &state) {
  enter();
  MemoryRestore in(state);
  in >> *top_;
  in.get(&clock_, sizeof clock_);
  in.get(&evals_, sizeof evals_);
  in.get(&lines_, sizeof lines_);
  in.get(&dirty_, sizeof dirty_);
  lines_changed_ = false;
  settle_clock();
}
#else
std::vector<uint8_t> ModelImpl::save() {
  throw std::runtime_error("this build cannot save");
}
void ModelImpl::restore(const std::vector<uint8_t> &) {
  throw std::runtime_error("this build cannot restore");
}
#endif

bool ModelImpl::trace(const std::string &path) {
#if MMCS_TRACE
  Verilated::threadContextp(&context_);
  if (fst_) fst_->close();
  fst_.reset();
  // Waveforms show every clock and both its edges.
  const bool before = two_evals_;
  two_evals_ = two_evals_wanted_ || !path.empty();
  if (two_evals_ != before) settle_clock();
  if (path.empty()) return false;
  fst_ = std::make_unique<VerilatedFstC>();
  top_->trace(fst_.get(), 99);
  fst_->open(path.c_str());
  if (!fst_->isOpen()) fst_.reset();
  return fst_ != nullptr;
#else
  static_cast<void>(path);
  return false;
#endif
}

}  // namespace

std::unique_ptr<Model> Model::create(bool two_evals, bool, uint64_t seed) {
  return std::make_unique<ModelImpl>(two_evals, seed);
}
int Model::cards() {
  return kCards;
}
int Model::clk_hz() {
  return MMCS_CLK_HZ;
}
bool Model::skip() {
  return false;
}
bool Model::traced() {
  return MMCS_TRACE;
}
bool Model::soc() {
  return MMCS_SOC;
}

}  // namespace mmcs

#if !MMCS_SPEED
// Verilator's runtime prints and stops through these; see print_hook.h.
extern "C" int mmcs_model_print(const char *format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  mmcs::printed += text;
  while (!mmcs::printed.empty() && mmcs::printed.back() == '\n') mmcs::printed.pop_back();
  return length;
}

void vl_stop(const char *file, int line, const char *) {
  if (mmcs::printed.empty()) mmcs::printed = std::string(file) + ":" + std::to_string(line);
  Verilated::threadContextp()->gotError(true);
}
#endif

// The imported DPI function: called by the model in the clock in which a line changed.
extern "C" void mmcs_lines_changed(unsigned lines) {
  void *self = svGetUserData(svGetScope(), &mmcs::user_key);
  if (self) static_cast<mmcs::ModelImpl *>(self)->lines_changed(lines);
}

#if MMCS_SOC
extern "C" void mmcs_soc_reported(unsigned what) {
  void *self = svGetUserData(svGetScope(), &mmcs::user_key);
  if (self) static_cast<mmcs::ModelImpl *>(self)->reported(what);
}
extern "C" void mmcs_soc_bus_error(unsigned offset) {
  void *self = svGetUserData(svGetScope(), &mmcs::user_key);
  if (self) static_cast<mmcs::ModelImpl *>(self)->bus_error(offset);
}
extern "C" void mmcs_soc_stepped(unsigned step, unsigned offset) {
  void *self = svGetUserData(svGetScope(), &mmcs::user_key);
  if (self) static_cast<mmcs::ModelImpl *>(self)->stepped(static_cast<mmcs::SocStep>(step), offset);
}
#endif
