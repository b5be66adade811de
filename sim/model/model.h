// SPDX-License-Identifier: Apache-2.0
// The Verilated machine as a plain C++ object: pins in, clocks, lines out.
//
// Knows nothing of plant, firmware or time in seconds. Create, run clocks, destroy; several may
// exist at once.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mmcs_sim.h"
#include "own_card.h"
#include "pins.h"
#include "tables.h"

namespace mmcs {

// Bits of Model::lines().
inline constexpr unsigned kLineIrq = 0xFE;  // bit n = IRQn* requesting
inline constexpr unsigned kLinePanic = 1u << 8;
inline constexpr unsigned kLineBrakeRelease = 1u << 9;
inline constexpr unsigned kLineSclock = 1u << 10;
// The outputs of the machine that they are, with the lowest bit of each.
inline constexpr std::pair<const char *, int> kLinePorts[] = {
    {"vme_irq_no", 1}, {"panic_o", 8}, {"brake_release_o", 9}, {"sclock_o", 10}};

// The three wires of an encoder from a clock on, as Pins::set_encoder() takes them.
struct EncoderEdge {
  int64_t clock;
  int axis;
  unsigned pins;
};

// What the cache of one module did in this machine since it was made, and what it holds now.
struct CacheFigures {
  std::string module;
  uint64_t hits, misses;  // steps taken from the cache; steps that the model was run for
  uint64_t states, bytes;
};

enum class Stop { kDone, kLines, kDtack, kFailed };

// What a snapshot of the hardware holds: registers in the order of registers(), so that every build
// understands it, those of an own card, and the pins.
struct Saved {
  int64_t clock = 0;
  unsigned lines = 0;
  std::vector<uint64_t> registers, pins, card;
};

class Model : protected Ports {
 public:
  // skip: idle parts get no clock, if the build can. card: the library of cards of one's own
  // (own_card.h), or "".
  static std::unique_ptr<Model> create(bool skip, uint64_t seed, const std::string &card);

  static int cards();
  static int clk_hz();

  // Advances up to n clocks. Stops after the clock in which a line changed, or, if dtack is 0 or
  // 1, in which DTACK* has that level. *ran: clocks that passed.
  virtual Stop run(int64_t n, int dtack, int64_t *ran) = 0;
  int64_t clock() const { return clock_; }
  uint64_t evals() const { return evals_; }
  void set_evals(uint64_t evals) { evals_ = evals; }  // a count, and no part of the state
  // There has been an upset, or a line that was held: assertions end nothing any more. No part of
  // the state either.
  bool was_upset() const { return upset_; }
  void set_upset(bool upset) { upset_ = upset; }
  unsigned lines() const { return lines_; }
  // A cycle of the bus master.
  struct BusRequest {
    uint32_t address;
    unsigned am;
    unsigned ds;  // bit 0 = DS0*, bit 1 = DS1*
    bool write;
    unsigned data;
    int64_t latest;   // clocks until a time-out
    int64_t due = 0;  // the clock at which something else comes
  };
  struct BusReply {
    unsigned data;
    int64_t answered, end;  // clocks
  };
  // As one step. False: it is not known what it does, or something else comes meanwhile; it is to
  // be made clock by clock.
  virtual bool bus_cycle(const BusRequest &, BusReply *) { return false; }
  // Clock by clock: address first, strobes a clock later, release after DTACK*. advance(n, dtack)
  // lets up to n clocks pass, to this level of DTACK*; answered() is called before the release.
  template <class Advance, class Answered>
  BusReply clock_by_clock(const BusRequest &q, Advance advance, Answered answered) {
    BusReply reply{};
    pins_.vme_address(q.address, q.am, q.write, q.data);
    advance(1, -1);
    pins_.vme_strobes(q.ds);
    advance(q.latest, 0);
    reply.data = pins_.vme_data(vme_sample() & 0xFFFF);
    reply.answered = clock_;
    answered(reply);
    release(advance);
    reply.end = clock_;
    return reply;
  }
  // The end of a cycle. A slave may hold DTACK* for kReleaseClks before the master goes on.
  template <class Advance>
  void release(Advance advance) {
    constexpr int64_t kReleaseClks = 256;
    pins_.vme_idle();
    advance(kReleaseClks, 1);
    advance(1, -1);
  }
  virtual bool dtack() const = 0;  // DTACK* is low
  virtual bool alive() const = 0;  // level of the adaptor's sign of life

  Pins &pins() { return pins_; }
  // "" or why this machine has no such input; Pin::kCount: an upset.
  virtual std::string cannot(Pin) const { return ""; }
  // All edges of encoders that come from now on, in order. False: each is to be set at its clock.
  virtual bool expect(std::vector<EncoderEdge> &) { return false; }
  virtual int16_t drive(int axis) const = 0;
  virtual unsigned leds(int card) const = 0;

  // What the bus master sees: bit 17 IACKOUT*, bit 16 the slave drives D07..D00, 15..0 the data.
  virtual unsigned vme_sample() = 0;

  // What a processor outside is doing, for the waveform only.
  virtual void host_phase(unsigned, uint32_t) {}

  // A register of registers(), read without disturbing it.
  virtual uint64_t read(int reg) = 0;
  // Flips these bits, as a particle would; everything behind the register follows at once.
  virtual void upset(int reg, uint64_t bits) = 0;
  // The own card, or null; an upset in it.
  const OwnCard *own_card() const { return own_card_.get(); }
  virtual void upset_card(size_t reg, uint64_t bits) {
    upset_ = true;
    own_card_->upset(reg, bits);
    follow_card();
  }
  uint64_t digest();  // of all registers

  // Everything that changes in the RTL, as bytes that every build of the machine understands.
  virtual std::vector<uint8_t> save();
  virtual void restore(const std::vector<uint8_t> &state);

  // Starts a trace now, ends one that runs; "" only ends it.
  virtual bool trace(const std::string &) { return false; }
  // After each clock, what of these nets has changed; -1: there is no such net, or no way
  // (mmcs_sim.h).
  virtual int watch(const std::string &) { return -1; }
  const std::vector<mmcs_change> &changes() const { return changes_; }
  // The sentence of the first assertion that failed, or empty.
  const std::string &failure() const { return failure_; }
  // The first that failed since the last upset, which run() does not end at; asking forgets it.
  virtual std::string take_doubt() { return ""; }
  virtual std::vector<CacheFigures> cache_figures() const { return {}; }

 protected:
  virtual void put_back(const Saved &state) = 0;
  // What follows from the own card's outputs, and from the bus behind them.
  virtual void follow_card() {}
  void open_card(const std::string &library) {
    if (!library.empty()) own_card_ = std::make_unique<OwnCard>(library);
  }
  // The Mark I of this slot has given its place to an own card: it has no power.
  bool pulled(int slot) const { return own_card_ && own_card_->stands_in(slot); }
  void pull_cards() {
    for (int slot = 0; slot < cards(); ++slot) {
      if (pulled(slot)) cut(card_path(slot), "power_i", 1, 0);
    }
  }
  void look_at_card() {
    if (failure_.empty() && !upset_) failure_ = own_card_->clash();
  }
  void disturb() override { upset_ = true; }
  uint64_t read_register(const std::string &reg) override { return read(find_register(reg)); }

  BusReply clock_by_clock(const BusRequest &q) {
    const auto advance = [this](int64_t n, int dtack) { run(n, dtack, &n); };
    return clock_by_clock(q, advance, [](const BusReply &) {});
  }
  // run() where clocks(most) lets so many clocks pass, or fewer, and returns how many.
  template <class F>
  Stop run_by(int64_t n, int dtack, int64_t *ran, F clocks) {
    const int64_t begin = clock_;
    Stop stop = Stop::kDone;
    const auto answered = [&] { return dtack >= 0 && this->dtack() == (dtack == 0); };
    while (stop == Stop::kDone && clock_ < begin + n) {
      const bool changed = lines_ != shown_lines_;
      lines_ = shown_lines_;
      const int64_t passed = clocks(changed || answered() ? 1 : begin + n - clock_);
      clock_ += passed;
      evals_ += static_cast<uint64_t>(passed);
      stop = !failure_.empty() ? Stop::kFailed
             : changed         ? Stop::kLines
             : answered()      ? Stop::kDtack
                               : Stop::kDone;
    }
    *ran = clock_ - begin;
    return stop;
  }

  std::unique_ptr<OwnCard> own_card_;
  Pins pins_{*this, cards()};
  int64_t clock_ = 0;
  uint64_t evals_ = 0;
  unsigned lines_ = 0, shown_lines_ = 0;  // as run() reports them, a clock after they change
  bool upset_ = false;
  bool stopped_ = false;  // no clock comes
  std::string failure_;
  std::vector<mmcs_change> changes_;
};

}  // namespace mmcs
