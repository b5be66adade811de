// SPDX-License-Identifier: Apache-2.0
// Length: one class, of which a third is the table of pins.
// The machine as a rack of models: one Verilated adaptor, one Verilated card per slot, and the
// backplane of rtl/mmcs.sv between them. For speed alone: each block is evaluated only at clocks at
// which it does more than count, and one evaluation then stands for all clocks since its last
// (docs/simulator.md, Skipping). The wiring below must say what rtl/mmcs.sv says; tests hold the
// two to the same hash.
//
// Time: edge t is the clock that makes clock() t. Every block looks at its inputs as they stood
// before the edge. A pin set at clock t passes the wire's flip-flop at edge t + 1, a switch one
// more.

#include <algorithm>
#include <climits>
#include <cstring>
#include <stdexcept>

#include "memory_save.h"
#include "model.h"
#include "verilated.h"

#include "Vadaptor.h"
#include "Vadaptor___024root.h"
#include "Vcard.h"
#include "Vcard___024root.h"
#include "Vencoder.h"
#include "Vencoder___024root.h"
#include "Vpit.h"
#include "Vpit___024root.h"

void Vadaptor___024root___eval(Vadaptor___024root *);
bool Vadaptor___024root___eval_phase__act(Vadaptor___024root *);
bool Vadaptor___024root___eval_phase__nba(Vadaptor___024root *);
void Vcard___024root___eval(Vcard___024root *);
void Vencoder___024root___eval(Vencoder___024root *);
void Vpit___024root___eval(Vpit___024root *);

extern "C" const int mmcs_build_cards;

namespace mmcs {
namespace {

constexpr int64_t kNever = INT64_MAX;
constexpr int kResetClks = 64;
constexpr int kMaxCards = 16;
constexpr int64_t kRest = 0xFFFF;                      // horizon of a block that has nothing to do
constexpr int64_t kEncoderStages = 3;                  // clocks from the pins to the count
constexpr unsigned kModeMask = 7, kFirstGateMode = 6;  // of the encoder counters, on port A
constexpr unsigned kEncJoint = 0x01;                   // port B: the counters see the joints
constexpr unsigned kPanicIrq = 7;                      // jumpers as rtl/mmcs.sv sets them
constexpr unsigned kLatchAll = 0x12;                   // CARD_LATCH_ALL: every card listens
constexpr unsigned kRegisterMask = 0x1F, kDipShift = 10, kDipMask = 0xF;

// Registers and pins, by the names that Verilator gives them (see upset.h).
// clang-format off
#define MMCS_CORE(name) adaptor_vme__DOT__u_core__DOT__##name
#define MMCS_JOINT(r, joint, name) \
  ((joint) ? (r).mark1__DOT__g_axis__BRA__1__KET____DOT__u_axis__DOT__##name \
           : (r).mark1__DOT__g_axis__BRA__0__KET____DOT__u_axis__DOT__##name)
// clang-format on

#define MMCS_COUNTER(name) mmcs_sim_encoder__DOT__u_encoder__DOT__##name
#define MMCS_SOCKET(name) adaptor_vme__DOT__u_core__DOT__u_pit__DOT__##name

// A signal that changes on its way: what it becomes, and after which edge.
template <typename T>
struct Wire {
  T next{};
  int64_t at = kNever;
};

struct VmePins {
  uint16_t a = 0, d = 0;
  uint8_t am = 0, as_n = 1, ds_n = 3, write_n = 1, lword_n = 1, iack_n = 1, iackin_n = 1;
};

struct SafetyPins {
  uint8_t sysreset_n = 0, estop_closed = 1, cable_ok = 1, pc_power = 1, irq_lost = 0;
};

struct Switches {
  uint8_t axis_enable = 3, adc_stuck = 0, absent = 0, sclock_open = 0, panic_open = 0, dip_xor = 0;
  uint32_t dac_stuck1 = 0, dac_stuck0 = 0;
};

struct Encoders {
  uint8_t a = 0, b = 0, i = 0;
};

// What changes of a block beyond its registers. Plain data, saved as bytes.
struct AdaptorTime {
  int64_t last = 0, due = 0;
  Wire<VmePins> vme;
  Wire<SafetyPins> safety;
};
// What the adaptor says to a card.
struct Bus {
  uint16_t a = 0;
  uint8_t d = 0, ior_n = 1, iow_n = 1, drq = 0, clk_en = 0;
};
struct CardTime {
  int64_t last = 0, due = 0;
  Wire<Bus> bus;
  Wire<Encoders> encoders;
  Wire<Switches> wires, switches;  // a switch has two flip-flops on its way
  Wire<uint32_t> adc;
  int64_t seen = -kNever;  // edge after which the encoder pins came to stand as they are shown
  bool eager = false;      // a change of them on its way must be looked at in its clock
  int64_t counted = 0;     // edge up to which the encoder counters are ahead of the card
};
struct RackTime {
  int64_t clock = 0;
  uint64_t evals = 0;
  unsigned lines = 0;
  int64_t pit_last = 0, pit_due = 0;
  uint32_t to_pit = 0;   // pins of the timer chip as it sees them, as its socket packs them
  uint32_t listens = 0;  // cards that see the command on the bus, a bit each
  uint32_t panics = 0;   // cards that pull PANIC
  uint8_t drq = 0, clk_en = 0;
  int64_t next = 0;        // earliest edge at which anything is to be done
  int64_t cards = 0;       // the same of the cards
  int64_t hands = kNever;  // the same of the switches
};

class Rack final : public Model {
 public:
  Rack(bool two_evals, bool skip, uint64_t seed) : two_evals_(two_evals), skip_(skip) {
    context_.randReset(2);
    context_.randSeed(static_cast<int>(seed % 0x7FFFFFFF) + 1);
    Verilated::threadContextp(&context_);
    adaptor_ = std::make_unique<Vadaptor>(&context_, "ADAPTOR");
    a_ = adaptor_->rootp;
    pit_ = std::make_unique<Vpit>(&context_, "PIT");
    p_ = pit_->rootp;
    encoder_ = std::make_unique<Vencoder>(&context_, "ENCODER");
    e_ = encoder_->rootp;
    for (int n = 0; n < mmcs_build_cards; ++n) {
      card_[n].top = std::make_unique<Vcard>(&context_, "CARD");
      card_[n].r = card_[n].top->rootp;
    }
    power_on();
  }
  // The models take their names out of the context of the thread, which may be another machine's.
  ~Rack() override { Verilated::threadContextp(&context_); }

  Stop run(int64_t n, int dtack, int64_t *ran) override;
  int64_t clock() const override { return t_.clock; }
  uint64_t evals() const override { return t_.evals; }
  unsigned lines() const override { return t_.lines; }
  bool dtack() const override { return !a_->vme_dtack_no; }

  void set(Pin pin, int index, unsigned value) override;
  int16_t drive(int axis) const override {
    return static_cast<int16_t>(card_[axis / 2].r->drive_v_o >> (16 * (axis & 1)));
  }
  unsigned leds(int card) const override { return card_[card].r->leds_o; }

  void vme_address(unsigned address, unsigned am, bool write, bool lword, unsigned data) override {
    VmePins &p = vme();
    p.a = static_cast<uint16_t>(address >> 1 & 0x7FFF);
    p.am = am & 63;
    p.write_n = !write;
    p.lword_n = !lword;
    p.d = static_cast<uint8_t>(data);
  }
  void vme_strobe(unsigned ds, bool iack) override {
    VmePins &p = vme();
    p.as_n = 0;
    p.ds_n = ~ds & 3;
    p.iack_n = !iack;
  }
  void vme_iackin(bool low) override { vme().iackin_n = !low; }
  void vme_release() override {
    VmePins &p = vme();
    p.as_n = p.iack_n = p.iackin_n = p.write_n = p.lword_n = 1;
    p.ds_n = 3;
  }
  unsigned vme_sample() override {
    return static_cast<unsigned>(a_->vme_iackout_no) << 17 |
           static_cast<unsigned>(a_->vme_d_oe_o) << 16 | 0xFF00u | a_->vme_d_o;
  }

  // A rack has no processor of its own.
  void soc_run(bool) {}
  void soc_ring() {}
  void soc_errors(unsigned) {}
  uint32_t soc_read(unsigned) const { return 0; }
  void soc_write(unsigned, uint32_t) {}
  unsigned report() const { return 0; }
  void take_report() {}
  unsigned take_bus_error() { return 0; }

  void set_encoder(int axis, unsigned pins) override;
  uint16_t encoder_register(int axis) override;
  uint64_t digest() override;
  void upset(Register reg, int axis, unsigned bits) override;
  std::vector<uint8_t> save() override;
  void restore(const std::vector<uint8_t> &state) override;
  bool trace(const std::string &) override { return false; }
  const std::string &failure() const override { return failure_; }

 private:
  struct Card {
    std::unique_ptr<Vcard> top;
    Vcard___024root *r = nullptr;
    CardTime t;
    Encoders encoders;
    Switches switches;
    Bus bus;
  };

  void power_on();
  void edge_adaptor(int64_t t);
  void catch_up_adaptor(int64_t t);
  void settle_adaptor(int64_t t);
  void edge_card(Card &card, int64_t t);
  void clock_card(Card &card, int64_t t);
  void show_bus(Card &card);
  void show_command(Card &card);
  void bring_up(Card &card);
  bool count_alone(Card &card, int64_t t);
  void count_edges(Card &card, int64_t clocks);
  void join_counters(Card &card);
  static bool encoders_move(const Card &card);
  void edge_pit(int64_t t);
  void drive_pit(int64_t t);
  void show_encoders(Card &card);
  Bus &bus(Card &card, int64_t t);
  void step(int64_t t);
  void drive_bus(int64_t t);
  void apply_pins(int64_t t);
  void apply_switches(int n, int64_t t);
  void look_at_panic(int n, int64_t t);
  void soon(Card &card, int64_t t);
  void plan();

  // Pins on their way through the wire; a second change before the edge joins the first.
  VmePins &vme() {
    t_.next = std::min(t_.next, t_.clock + 1);
    Wire<VmePins> &w = at_.vme;
    if (w.at == kNever) w = {vme_, t_.clock + 1};
    return w.next;
  }
  SafetyPins &safety() {
    t_.next = std::min(t_.next, t_.clock + 1);
    if (at_.safety.at == kNever) at_.safety = {safety_, t_.clock + 1};
    return at_.safety.next;
  }

  VerilatedContext context_;
  std::unique_ptr<Vadaptor> adaptor_;
  Vadaptor___024root *a_ = nullptr;
  std::unique_ptr<Vpit> pit_;
  Vpit___024root *p_ = nullptr;
  std::unique_ptr<Vencoder> encoder_;  // of no card: see count_edges()
  Vencoder___024root *e_ = nullptr;
  Card card_[kMaxCards];
  AdaptorTime at_;
  RackTime t_;
  VmePins vme_;
  SafetyPins safety_;
  bool two_evals_, skip_;
  bool stop_lines_ = false;
  bool cards_moved_ = true;  // plan() has to look at them
  bool stale_ = true;  // an input of the adaptor changed, and nothing has been worked out since
  std::string failure_;
};

// One rising edge by one evaluation, as ModelImpl::clock_once() of model.cpp.
template <typename Root>
inline void clock_block(Root *r, void (*eval)(Root *), bool both) {
  if (both) {
    r->clk_i = 0;
    eval(r);
    r->clk_i = 1;
  } else {
    r->__Vtrigprevexpr___TOP__clk_i__0 = 0;
  }
  eval(r);
}

// All clocks since the last edge at once, the last of them being t.
void Rack::edge_adaptor(int64_t t) {
  if (!a_->pc_ior_no) {
    unsigned data = 0xFF;
    for (uint32_t rest = t_.listens; rest; rest &= rest - 1) {
      Card &card = card_[__builtin_ctz(rest)];
      if (card.t.bus.at < t) show_command(card);
      if (card.r->pc_d_oe_o) data &= card.r->pc_d_o;
    }
    a_->pc_d_i = static_cast<CData>(data);
    stale_ = true;
  }
  if (t_.to_pit) {
    a_->MMCS_SOCKET(from_d) = p_->d_o;
    stale_ = true;
  }
  const unsigned lines =
      static_cast<unsigned>(a_->sclock_o) << 10 | static_cast<unsigned>(a_->brake_release_o) << 9 |
      static_cast<unsigned>(a_->panic_o) << 8 | (~(a_->vme_irq_no << 1) & kLineIrq);
  if (lines != t_.lines) {
    t_.lines = lines;
    stop_lines_ = true;
  }
  a_->extra_i = static_cast<SData>(t - at_.last - 1);
  if (stale_ || two_evals_) {
    clock_block(a_, Vadaptor___024root___eval, two_evals_);
    stale_ = false;
  } else {
    // What follows from the inputs is known: the clock alone. extra_i acts at the clock only, which
    // the Makefile makes sure of.
    a_->__Vtrigprevexpr___TOP__clk_i__0 = 0;
    Vadaptor___024root___eval_phase__act(a_);
    Vadaptor___024root___eval_phase__nba(a_);
  }
  at_.last = t;
  at_.due = t + (skip_ ? a_->horizon_o : 1);
}

// Before an input changes after edge t. An adaptor at rest counts nothing: its clocks up to here
// need not be made up for.
void Rack::catch_up_adaptor(int64_t t) {
  if (at_.last == t) return;
  if (at_.due - at_.last >= kRest) {
    at_.last = t;
  } else {
    edge_adaptor(t);
  }
}

// After it changed: what follows without a clock, and when the next clock matters.
void Rack::settle_adaptor(int64_t t) {
  Vadaptor___024root___eval(a_);
  stale_ = false;
  at_.due = t + (skip_ ? a_->horizon_o : 1);
}

// Up to edge t. A card's counters do not look at encoders and bus: when these change, the clocks
// since the last edge need not be made up for first, unless the encoders' flip-flops are still on
// the way.
void Rack::edge_card(Card &card, int64_t t) {
  CardTime &c = card.t;
  if (c.counted > c.last && (c.counted <= c.seen || encoders_move(card))) join_counters(card);
  for (;;) {
    const int64_t at = std::min(c.encoders.at, c.bus.at);
    if (at >= t) break;  // what changed after edge t is not seen at edge t
    const bool pins = c.encoders.at == at, bus = c.bus.at == at;
    if (c.last < at) {
      const int64_t later = pins ? c.bus.at : c.encoders.at;
      const int64_t next = std::min(t, later > at ? later : t);
      const bool unseen =
          std::max(c.last, c.counted) <= c.seen;  // the pins as they stood until now
      if (unseen || (bus && encoders_move(card)) || (pins && next - at < kEncoderStages)) {
        clock_card(card, at);
      }
    }
    if (pins) show_encoders(card);
    if (bus) show_bus(card);
  }
  clock_card(card, t);
}

// All clocks since the last edge at once, the last of them being t.
void Rack::clock_card(Card &card, int64_t t) {
  CardTime &c = card.t;
  if (t > c.adc.at) {
    card.r->adc_v_i = c.adc.next;
    c.adc.at = kNever;
  }
  card.r->extra_i = static_cast<SData>(t - c.last - 1);
  clock_block(card.r, Vcard___024root___eval, two_evals_);
  cards_moved_ = true;
  c.last = c.counted = t;
  c.due = t + (skip_ ? card.r->horizon_o : 1);
  if ((card.r->mark1__DOT__pa & kModeMask) >= kFirstGateMode) c.eager = true;
  if (c.bus.at != kNever) c.due = std::min(c.due, c.bus.at + 1);
  if (c.eager && c.encoders.at != kNever) c.due = std::min(c.due, c.encoders.at + 1);
}

void Rack::show_bus(Card &card) {
  const Bus &b = card.bus = card.t.bus.next;
  card.t.bus.at = kNever;
  card.r->pc_a_i = b.a;
  card.r->pc_d_i = b.d;
  card.r->pc_ior_ni = b.ior_n;
  card.r->pc_iow_ni = b.iow_n;
  card.r->pc_drq_i = b.drq;
  card.r->pc_clk_en_i = b.clk_en;
}

// A command that came with the last edge, and at this one its data are taken: it was cut short by
// the loss of power or cable. What the card answers to it follows without a clock.
void Rack::show_command(Card &card) {
  const int64_t at = card.t.bus.at;
  if (card.t.last < at) edge_card(card, at);
  show_bus(card);
  card.top->eval();
  soon(card, at);
}

// The encoder counters up to edge t, while nothing else happens to the card, by a model of their
// own; false if that cannot be.
bool Rack::count_alone(Card &card, int64_t t) {
  CardTime &c = card.t;
  if (c.eager || c.due <= t || c.bus.at < t || !card.bus.clk_en ||
      (card.r->mark1__DOT__pb & kEncJoint) == 0) {
    return false;
  }
  const int64_t from = std::max(c.last, c.counted);
  c.counted = t;
  if (c.encoders.at < t) {
    const int64_t at = c.encoders.at;
    count_edges(card, at - from);
    show_encoders(card);
    count_edges(card, t - at);
  } else {
    count_edges(card, t - from);
  }
  return true;
}

// So many clocks of both counters, with the pins as they are shown.
void Rack::count_edges(Card &card, int64_t clocks) {
  if (clocks <= 0) return;
  Vcard___024root &r = *card.r;
  for (int joint = 0; joint < 2; ++joint) {
    const unsigned a = card.encoders.a >> joint & 1, b = card.encoders.b >> joint & 1;
    CData &s1 = MMCS_JOINT(r, joint, u_encoder__DOT__s1_q);
    CData &s2 = MMCS_JOINT(r, joint, u_encoder__DOT__s2_q);
    CData &before = MMCS_JOINT(r, joint, u_encoder__DOT__prev_q);
    if (s1 == (a << 1 | b) && s2 == s1 && before == s1) continue;
    e_->m_i = r.mark1__DOT__pa & kModeMask;
    e_->a_i = static_cast<CData>(a);
    e_->b_i = static_cast<CData>(b);
    e_->extra_i = static_cast<SData>(std::min(clocks - 1, kRest));
    e_->MMCS_COUNTER(s1_q) = s1;
    e_->MMCS_COUNTER(s2_q) = e_->MMCS_COUNTER(now) = s2;
    e_->MMCS_COUNTER(prev_q) = before;
    e_->MMCS_COUNTER(count_q) = MMCS_JOINT(r, joint, u_encoder__DOT__count_q);
    clock_block(e_, Vencoder___024root___eval, two_evals_);
    s1 = e_->MMCS_COUNTER(s1_q);
    s2 = MMCS_JOINT(r, joint, u_encoder__DOT__now) = e_->MMCS_COUNTER(s2_q);
    before = e_->MMCS_COUNTER(prev_q);
    MMCS_JOINT(r, joint, u_encoder__DOT__count_q) = e_->MMCS_COUNTER(count_q);
    MMCS_JOINT(r, joint, u_encoder__DOT__moving) = e_->MMCS_COUNTER(moving);
  }
}

// The rest of the card comes up to where its counters are, which stay as they are.
void Rack::join_counters(Card &card) {
  Vcard___024root &r = *card.r;
  struct {
    CData s1, s2, before, moving;
    SData count;
  } kept[2];
  for (int joint = 0; joint < 2; ++joint) {
    kept[joint] = {
        MMCS_JOINT(r, joint, u_encoder__DOT__s1_q), MMCS_JOINT(r, joint, u_encoder__DOT__s2_q),
        MMCS_JOINT(r, joint, u_encoder__DOT__prev_q), MMCS_JOINT(r, joint, u_encoder__DOT__moving),
        MMCS_JOINT(r, joint, u_encoder__DOT__count_q)};
  }
  clock_card(card, card.t.counted);
  for (int joint = 0; joint < 2; ++joint) {
    MMCS_JOINT(r, joint, u_encoder__DOT__s1_q) = kept[joint].s1;
    MMCS_JOINT(r, joint, u_encoder__DOT__s2_q) = kept[joint].s2;
    MMCS_JOINT(r, joint, u_encoder__DOT__now) = kept[joint].s2;
    MMCS_JOINT(r, joint, u_encoder__DOT__prev_q) = kept[joint].before;
    MMCS_JOINT(r, joint, u_encoder__DOT__moving) = kept[joint].moving;
    MMCS_JOINT(r, joint, u_encoder__DOT__count_q) = kept[joint].count;
  }
}

// Some flip-flop behind the encoder pins differs from the next.
bool Rack::encoders_move(const Card &card) {
  return MMCS_JOINT(*card.r, 0, u_encoder__DOT__moving) ||
         MMCS_JOINT(*card.r, 1, u_encoder__DOT__moving);
}

void Rack::show_encoders(Card &card) {
  card.t.seen = card.t.encoders.at;
  card.t.encoders.at = kNever;
  card.encoders = card.t.encoders.next;
  card.r->enc_a_i = card.encoders.a;
  card.r->enc_b_i = card.encoders.b;
  card.r->enc_i_i = card.encoders.i;
}

// The bus of the card as it will be after edge t.
Bus &Rack::bus(Card &card, int64_t t) {
  if (card.t.bus.at == kNever) card.t.bus.next = card.bus;
  card.t.bus.at = t;
  soon(card, t);
  return card.t.bus.next;
}

void Rack::edge_pit(int64_t t) {
  p_->extra_i = static_cast<SData>(t - t_.pit_last - 1);
  clock_block(p_, Vpit___024root___eval, two_evals_);
  t_.pit_last = t;
  t_.pit_due = t + (skip_ ? p_->horizon_o : 1);
}

// What the adaptor says to the timer chip after edge t. Its counters do not look at the bus, but
// what it says acts at one clock.
void Rack::drive_pit(int64_t t) {
  const uint32_t pins = a_->MMCS_SOCKET(to_chip);
  if (pins == t_.to_pit) return;
  if (t_.pit_last < t) edge_pit(t);
  t_.to_pit = pins;
  p_->cs_ni = !(pins >> 12);
  p_->rd_ni = pins >> 11 & 1;
  p_->wr_ni = pins >> 10 & 1;
  p_->a_i = pins >> 8 & 3;
  p_->d_i = pins & 0xFF;
  t_.pit_due = t + 1;
}

// The card's inputs change after edge t: it looks at them at the next.
void Rack::soon(Card &card, int64_t t) {
  card.t.due = t + 1;
  cards_moved_ = true;
}

// What the adaptor says on the PC bus after edge t, for those cards that it concerns.
void Rack::drive_bus(int64_t t) {
  const bool ior_n = a_->pc_ior_no, iow_n = a_->pc_iow_no;
  const bool busy = !(ior_n && iow_n);
  if (busy && t_.listens == 0) {
    const unsigned address = a_->pc_a_o;
    const bool all = (address & kRegisterMask) == kLatchAll;
    for (int n = 0; n < mmcs_build_cards; ++n) {
      Card &card = card_[n];
      if (!all && card.r->dip_i != (address >> kDipShift & kDipMask)) continue;
      t_.listens |= 1u << n;
      Bus &b = bus(card, t);
      b.a = a_->pc_a_o;
      b.d = a_->pc_d_o;
      b.ior_n = ior_n;
      b.iow_n = iow_n;
    }
  } else if (!busy) {
    for (; t_.listens; t_.listens &= t_.listens - 1) {
      Bus &b = bus(card_[__builtin_ctz(t_.listens)], t);
      b.ior_n = b.iow_n = 1;
    }
  }
  if (t_.drq != a_->pc_drq_o || t_.clk_en != a_->pc_clk_en_o) {
    t_.drq = a_->pc_drq_o;
    t_.clk_en = a_->pc_clk_en_o;
    for (int n = 0; n < mmcs_build_cards; ++n) {
      Bus &b = bus(card_[n], t);
      b.drq = t_.drq;
      b.clk_en = t_.clk_en;
    }
  }
  const Vcard___024root &c = *card_[0].r;
  if (c.pc_reset_drv_i == a_->pc_reset_drv_o && c.power_i == a_->pc_power_o) return;
  for (int n = 0; n < mmcs_build_cards; ++n) {
    Card &card = card_[n];
    if (card.t.last < t) edge_card(card, t);
    card.r->pc_reset_drv_i = a_->pc_reset_drv_o;
    card.r->power_i = card.r->rst_ni = a_->pc_power_o;
    card.top->eval();
    look_at_panic(n, t);
    soon(card, t);
  }
}

// PANIC of a card may have changed after edge t.
void Rack::look_at_panic(int n, int64_t t) {
  const uint32_t bit = 1u << n;
  const uint32_t pulls = card_[n].r->pc_irq_o >> (kPanicIrq - 3) & 1 ? bit : 0;
  if ((t_.panics & bit) == pulls) return;
  const bool before = t_.panics != 0;
  t_.panics ^= bit;
  if ((t_.panics != 0) == before) return;
  catch_up_adaptor(t);
  a_->pc_irq_i = static_cast<CData>((t_.panics != 0) << (kPanicIrq - 3));
  settle_adaptor(t);
}

void Rack::apply_switches(int n, int64_t t) {
  Card &card = card_[n];
  if (card.t.last < t) edge_card(card, t);
  card.t.switches.at = kNever;
  const Switches &s = card.switches = card.t.switches.next;
  Vcard___024root &r = *card.r;
  r.axis_enable_i = s.axis_enable;
  r.adc_stuck_i = s.adc_stuck;
  r.absent_i = s.absent;
  r.sclock_open_i = s.sclock_open;
  r.panic_open_i = s.panic_open;
  r.dip_i = static_cast<CData>((n ^ s.dip_xor) & 15);
  r.dac_stuck1_i = s.dac_stuck1;
  r.dac_stuck0_i = s.dac_stuck0;
  // A card whose switch changes under a command may begin or cease to listen.
  if (!(a_->pc_ior_no && a_->pc_iow_no)) {
    Bus &b = bus(card, t);
    b.a = a_->pc_a_o;
    b.d = a_->pc_d_o;
    b.ior_n = a_->pc_ior_no;
    b.iow_n = a_->pc_iow_no;
    show_bus(card);  // its data may be taken at the next edge
    t_.listens |= 1u << n;
  }
  card.top->eval();
  soon(card, t);
  look_at_panic(n, t);
}

// Pins whose wire ends after edge t.
void Rack::apply_pins(int64_t t) {
  if (at_.vme.at <= t) {
    const VmePins &next = at_.vme.next;
    // The adaptor looks at the address under a strobe alone.
    const bool seen = (next.as_n & next.iackin_n & vme_.as_n & vme_.iackin_n) == 0 ||
                      (next.ds_n & vme_.ds_n) != 3 || next.iack_n != vme_.iack_n;
    if (seen) catch_up_adaptor(t);
    vme_ = at_.vme.next;
    at_.vme.at = kNever;
    a_->vme_a_i = vme_.a;
    a_->vme_am_i = vme_.am;
    a_->vme_d_i = static_cast<CData>(vme_.d);
    a_->vme_as_ni = vme_.as_n;
    a_->vme_ds_ni = vme_.ds_n;
    a_->vme_write_ni = vme_.write_n;
    a_->vme_lword_ni = vme_.lword_n;
    a_->vme_iack_ni = vme_.iack_n;
    a_->vme_iackin_ni = vme_.iackin_n;
    stale_ = true;
    if (seen) settle_adaptor(t);
  }
  if (at_.safety.at <= t) {
    catch_up_adaptor(t);
    safety_ = at_.safety.next;
    at_.safety.at = kNever;
    a_->vme_sysreset_ni = safety_.sysreset_n;
    a_->estop_closed_i = safety_.estop_closed;
    a_->cable_ok_i = safety_.cable_ok;
    a_->pc_power_i = safety_.pc_power;
    a_->irq_lost_i = safety_.irq_lost;
    stale_ = true;
    at_.due = t + 1;  // their first flip-flops say nothing of what is in front of them
  }
  if (t_.hands > t) return;
  t_.hands = kNever;
  for (int n = 0; n < mmcs_build_cards; ++n) {
    Card &card = card_[n];
    if (card.t.switches.at <= t) apply_switches(n, t);
    if (card.t.wires.at <= t) {
      card.t.switches = {card.t.wires.next, t + 1};
      card.t.wires.at = kNever;
    }
    t_.hands = std::min(t_.hands, std::min(card.t.switches.at, card.t.wires.at));
  }
}

// When anything is to be done next.
void Rack::plan() {
  if (cards_moved_) {
    cards_moved_ = false;
    int64_t cards = kNever;
    for (int n = 0; n < mmcs_build_cards; ++n) cards = std::min(cards, card_[n].t.due);
    t_.cards = cards;
  }
  t_.next = std::min(std::min(std::min(at_.due, t_.pit_due), std::min(t_.cards, t_.hands)),
                     std::min(at_.vme.at, at_.safety.at));
}

// Edge t: every block that is due sees its inputs as they stood before; then these change.
void Rack::step(int64_t t) {
  ++t_.evals;
  const bool adaptor = at_.due <= t;
  if (adaptor) edge_adaptor(t);
  bool timer = false;
  if (t_.pit_due <= t) {
    edge_pit(t);
    timer = p_->out_o != a_->MMCS_SOCKET(from_out);
  }
  uint32_t woken = 0;
  for (int n = 0; t_.cards <= t && n < mmcs_build_cards; ++n) {
    if (card_[n].t.due > t) continue;
    edge_card(card_[n], t);
    woken |= 1u << n;
  }
  if (timer) {
    catch_up_adaptor(t);
    a_->MMCS_SOCKET(from_out) = p_->out_o;
    settle_adaptor(t);
  }
  if (adaptor) drive_pit(t);
  if (adaptor || timer) drive_bus(t);
  for (; woken; woken &= woken - 1) look_at_panic(__builtin_ctz(woken), t);
  apply_pins(t);
  plan();
}

Stop Rack::run(int64_t n, int dtack, int64_t *ran) {
  const int64_t begin = t_.clock;
  int64_t end = begin + n;
  Stop stop = Stop::kDone;
  const unsigned wanted = dtack < 0 ? 2u : static_cast<unsigned>(dtack);
  // Clock by clock the level would be seen after the first.
  if (a_->vme_dtack_no == wanted) end = begin + 1;
  while (t_.clock < end) {
    if (t_.next > end) {
      t_.clock = end;
    } else {
      t_.clock = t_.next;
      step(t_.clock);
      if (stop_lines_) {
        stop_lines_ = false;
        stop = Stop::kLines;
        break;
      }
    }
    if (a_->vme_dtack_no == wanted) {
      stop = Stop::kDtack;
      break;
    }
  }
  *ran = t_.clock - begin;
  return stop;
}

void Rack::power_on() {
  t_.clock = -kResetClks;
  a_->clk_i = 1;
  a_->vme_as_ni = a_->vme_write_ni = a_->vme_lword_ni = a_->vme_iack_ni = a_->vme_iackin_ni = 1;
  a_->vme_ds_ni = 3;
  a_->vme_sysreset_ni = 0;
  a_->estop_closed_i = a_->cable_ok_i = a_->pc_power_i = 1;
  a_->pc_d_i = 0xFF;
  a_->rst_ni = 0;
  adaptor_->eval();
  at_.last = t_.clock;
  at_.due = t_.clock + 1;
  e_->clk_i = e_->rst_ni = 1;
  encoder_->eval();
  p_->clk_i = 1;
  p_->rst_ni = 0;
  p_->cs_ni = p_->rd_ni = p_->wr_ni = 1;
  pit_->eval();
  t_.pit_last = t_.clock;
  t_.pit_due = t_.clock + 1;
  for (int n = 0; n < mmcs_build_cards; ++n) {
    Card &card = card_[n];
    Vcard___024root &r = *card.r;
    r.clk_i = 1;
    r.rst_ni = 0;
    r.pc_ior_ni = r.pc_iow_ni = r.power_i = 1;
    card.bus.clk_en = r.pc_clk_en_i = t_.clk_en = a_->pc_clk_en_o;
    card.bus.drq = r.pc_drq_i = t_.drq = a_->pc_drq_o;
    r.axis_enable_i = 3;
    r.dip_i = static_cast<CData>(n);
    card.top->eval();
    card.t.last = t_.clock;
    card.t.due = t_.clock + 1;
    look_at_panic(n, t_.clock);
  }
  const bool skip = skip_;
  skip_ = false;
  plan();
  for (int i = 0; i < kResetClks; ++i) {
    if (i == 8) {
      a_->rst_ni = p_->rst_ni = 1;
      adaptor_->eval();
      pit_->eval();
      for (int n = 0; n < mmcs_build_cards; ++n) {
        card_[n].r->rst_ni = 1;
        card_[n].top->eval();
        look_at_panic(n, t_.clock);
      }
    }
    if (i == kResetClks / 2) safety().sysreset_n = 1;
    step(++t_.clock);
  }
  skip_ = skip;
  t_.evals = 0;
  stop_lines_ = false;
}

void Rack::set(Pin pin, int index, unsigned value) {
  const auto bit = [value](uint8_t &bits, int at) {
    bits = static_cast<uint8_t>((bits & ~(1u << at)) | (value & 1) << at);
  };
  const auto field = [value](uint32_t &bits, int at) {
    bits = (bits & ~(0xFFFu << at)) | (value & 0xFFF) << at;
  };
  const int64_t now = t_.clock;
  switch (pin) {
    case Pin::kSysreset:
      safety().sysreset_n = !(value & 1);
      return;
    case Pin::kEstop:
      safety().estop_closed = !(value & 1);
      return;
    case Pin::kCableCut:
      safety().cable_ok = !(value & 1);
      return;
    case Pin::kPcOff:
      safety().pc_power = !(value & 1);
      return;
    case Pin::kIrqLost:
      safety().irq_lost = value & 1;
      return;
    default:
      break;
  }
  const bool by_card = pin == Pin::kCardAbsent || pin == Pin::kSclockOpen ||
                       pin == Pin::kPanicOpen || pin == Pin::kDipXor;
  Card &card = card_[by_card ? index : index / 2];
  const int joint = by_card ? 0 : index & 1;
  if (pin == Pin::kAdcV) {
    Wire<uint32_t> &w = card.t.adc;
    if (w.at == kNever) {
      w.next = card.r->adc_v_i;
    } else if (w.at <= now) {  // its edge has passed unseen
      card.r->adc_v_i = w.next;
    }
    w.next = (w.next & ~(0xFFFFu << 16 * joint)) | (value & 0xFFFF) << 16 * joint;
    w.at = now + 1;
    return;
  }
  Wire<Switches> &w = card.t.wires;
  if (w.at == kNever) {
    w.next = card.t.switches.at == kNever ? card.switches : card.t.switches.next;
    w.at = now + 1;
    t_.hands = std::min(t_.hands, w.at);
    t_.next = std::min(t_.next, w.at);
  }
  Switches &s = w.next;
  switch (pin) {
    case Pin::kAxisEnable:
      bit(s.axis_enable, joint);
      break;
    case Pin::kAdcStuck:
      bit(s.adc_stuck, joint);
      break;
    case Pin::kCardAbsent:
      s.absent = value & 1;
      break;
    case Pin::kSclockOpen:
      s.sclock_open = value & 1;
      break;
    case Pin::kPanicOpen:
      s.panic_open = value & 1;
      break;
    case Pin::kDipXor:
      s.dip_xor = value & 15;
      break;
    case Pin::kDacStuck1:
      field(s.dac_stuck1, 12 * joint);
      break;
    case Pin::kDacStuck0:
      field(s.dac_stuck0, 12 * joint);
      break;
    default:
      break;
  }
}

// A and B alone go their way unnoticed: nothing but the count follows from them, in modes that
// count edges, so that they are looked at when something else happens to the card or when they
// change again.
void Rack::set_encoder(int axis, unsigned pins) {
  const int64_t now = t_.clock;
  const int joint = axis & 1;
  Card &card = card_[axis / 2];
  CardTime &c = card.t;
  const Encoders before = c.encoders.at == kNever ? card.encoders : c.encoders.next;
  const auto with = [joint](uint8_t bits, unsigned value) {
    return static_cast<uint8_t>((bits & ~(1u << joint)) | (value & 1) << joint);
  };
  const Encoders after{with(before.a, pins), with(before.b, pins >> 1), with(before.i, pins >> 2)};
  if (std::memcmp(&before, &after, sizeof after) == 0) return;
  if (c.encoders.at <= now) {  // an earlier one, through its wire but not yet looked at
    if (c.last < now && !count_alone(card, now)) edge_card(card, now);
    if (c.encoders.at != kNever) show_encoders(card);
    t_.next = std::min(t_.next, c.due);
  }
  if (c.encoders.at == kNever) c.eager = false;
  c.encoders = {after, now + 1};
  if (before.i != after.i || (card.r->mark1__DOT__pa & kModeMask) >= kFirstGateMode) c.eager = true;
  if (!c.eager) return;
  c.due = std::min(c.due, now + 2);
  t_.cards = std::min(t_.cards, c.due);
  t_.next = std::min(t_.next, c.due);
  cards_moved_ = true;
}

uint16_t Rack::encoder_register(int axis) {
  bring_up(card_[axis / 2]);
  return MMCS_JOINT(*card_[axis / 2].r, axis & 1, u_encoder__DOT__count_q);
}

// Encoder pins that went unnoticed have their effect, up to now.
void Rack::bring_up(Card &card) {
  if (card.t.last == t_.clock) return;
  if (card.t.encoders.at >= t_.clock && std::max(card.t.last, card.t.counted) > card.t.seen &&
      !encoders_move(card)) {
    return;
  }
  edge_card(card, t_.clock);
  plan();
}

uint64_t Rack::digest() {
  const uint32_t adaptor =
      static_cast<uint32_t>(a_->MMCS_CORE(u_pccsr__DOT__sclock_latch_q)) << 17 |
      static_cast<uint32_t>(a_->MMCS_CORE(u_pccsr__DOT__panic_latch_q)) << 16 |
      static_cast<uint32_t>(a_->MMCS_CORE(u_pccsr__DOT__csr_q)) << 8 | a_->MMCS_CORE(vector_q);
  uint64_t hash = 0xCBF29CE484222325ull ^ adaptor;
  for (int axis = 0; axis < 2 * mmcs_build_cards; ++axis) {
    const Vcard___024root &r = *card_[axis / 2].r;
    const uint32_t word =
        static_cast<uint32_t>(MMCS_JOINT(r, axis & 1, index_latch_q)) << 25 |
        static_cast<uint32_t>(MMCS_JOINT(r, axis & 1, u_heartbeat__DOT__run_q)) << 24 |
        static_cast<uint32_t>(MMCS_JOINT(r, axis & 1, u_dac__DOT__rank2_q)) << 12 |
        MMCS_JOINT(r, axis & 1, u_dac__DOT__rank1_q);
    hash = (hash ^ (uint64_t{word} << 16 | encoder_register(axis))) * 0x100000001B3ull;
  }
  return hash;
}

template <typename T>
void flip(T &value, unsigned bits) {
  value = static_cast<T>(value ^ bits);
}

void Rack::upset(Register reg, int axis, unsigned bits) {
  const int64_t now = t_.clock;
  if (reg == Register::kPccsr || reg == Register::kVector) {
    catch_up_adaptor(now);
    if (reg == Register::kPccsr) flip(a_->MMCS_CORE(u_pccsr__DOT__csr_q), bits);
    if (reg == Register::kVector) flip(a_->MMCS_CORE(vector_q), bits);
    Vadaptor___024root___eval_settle(a_);
    stale_ = true;
    at_.due = now + 1;
  } else {
    Card &card = card_[axis / 2];
    Vcard___024root &r = *card.r;
    const int joint = axis & 1;
    if (card.t.last < now) edge_card(card, now);
    if (reg == Register::kEncoder) flip(MMCS_JOINT(r, joint, u_encoder__DOT__count_q), bits);
    if (reg == Register::kDacRank1) flip(MMCS_JOINT(r, joint, u_dac__DOT__rank1_q), bits);
    if (reg == Register::kDacRank2) flip(MMCS_JOINT(r, joint, u_dac__DOT__rank2_q), bits);
    if (reg == Register::kIndexLatch) flip(MMCS_JOINT(r, joint, index_latch_q), bits);
    if (reg == Register::kHeartbeat) flip(MMCS_JOINT(r, joint, u_heartbeat__DOT__run_q), bits);
    Vcard___024root___eval_settle(card.r);
    soon(card, now);
    look_at_panic(axis / 2, now);
  }
  plan();
}

std::vector<uint8_t> Rack::save() {
  Verilated::threadContextp(&context_);
  MemorySave out;
  out << *adaptor_ << *pit_;
  out.put(&at_, sizeof at_);
  out.put(&t_, sizeof t_);
  out.put(&vme_, sizeof vme_);
  out.put(&safety_, sizeof safety_);
  for (int n = 0; n < mmcs_build_cards; ++n) {
    out << *card_[n].top;
    out.put(&card_[n].t, sizeof card_[n].t);
    out.put(&card_[n].encoders, sizeof(Encoders));
    out.put(&card_[n].switches, sizeof(Switches));
    out.put(&card_[n].bus, sizeof(Bus));
  }
  return out.take();
}

void Rack::restore(const std::vector<uint8_t> &state) {
  Verilated::threadContextp(&context_);
  MemoryRestore in(state);
  in >> *adaptor_ >> *pit_;
  in.get(&at_, sizeof at_);
  in.get(&t_, sizeof t_);
  in.get(&vme_, sizeof vme_);
  in.get(&safety_, sizeof safety_);
  for (int n = 0; n < mmcs_build_cards; ++n) {
    in >> *card_[n].top;
    in.get(&card_[n].t, sizeof card_[n].t);
    in.get(&card_[n].encoders, sizeof(Encoders));
    in.get(&card_[n].switches, sizeof(Switches));
    in.get(&card_[n].bus, sizeof(Bus));
  }
  cards_moved_ = stale_ = true;
  stop_lines_ = false;
}

}  // namespace

std::unique_ptr<Model> Model::create(bool two_evals, bool skip, uint64_t seed) {
  return std::make_unique<Rack>(two_evals, skip, seed);
}
int Model::cards() {
  return mmcs_build_cards;
}
int Model::clk_hz() {
  return MMCS_CLK_HZ;
}
bool Model::skip() {
  return true;
}
bool Model::traced() {
  return false;
}
#ifdef MMCS_SOC
bool Model::soc() {
  return false;
}
#endif

}  // namespace mmcs
