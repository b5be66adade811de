// SPDX-License-Identifier: Apache-2.0
// Sweeps of one card: encoder, index, latch, one-shot, switch, RESET DRV against the bus and each
// other.

#include "Vbench_edges_card.h"
#include "world.h"

namespace {

constexpr unsigned kPortA = 0, kPortB = 1, kPortC = 2, kControl = 3, kMsb = 4, kLsb = 5;
constexpr unsigned kDacLow = 8, kDacHigh = 9, kAdcLow = 0x0C, kAdcHigh = 0x0E;
constexpr unsigned kJoints = 0x03, kSclock = 0x04, kIndex = 0x10;  // of port B
constexpr long kHeartbeat = 160 * kClock;
constexpr long kWindow = 1;  // steps before a clock in which a synchroniser takes either level

class Card : public World<Vbench_edges_card> {
 public:
  Card() { reset(); }
  // Two changes so far apart are seen in their order.
  long apart() const { return either ? kWindow + 1 : 0; }

  void reset() override {
    dut.ior_ni = dut.iow_ni = 1;
    dut.reset_drv_i = dut.sclock_i = 0;
    dut.a_i = 0;
    dut.d_i = 0xFF;
    dut.enable_i = 0;
    dut.power_i = 1;
    dut.enc_a_i = dut.enc_b_i = dut.enc_i_i = 0;
    dut.adc_v_i = 0;
    where_ = 0;
    dut.window_i = either ? static_cast<unsigned short>(kWindow * kStepPs + 1000) : 0;
    dut.rst_ni = 0;
    wait(2 * kClock);
    dut.rst_ni = 1;
    wait(2 * kClock);
    set_up();
  }

  void set_up(unsigned port_b = kJoints | kSclock) {
    write(kControl, 0x89);
    write(kPortA, 5);
    write(kPortB, port_b);
    wait(10 * kClock);
  }

  // The bus moves one step after a rising edge, as the adaptor's flip-flops do.
  void write(unsigned reg, unsigned value) {
    align(1);
    dut.a_i = static_cast<unsigned short>(0x300 | reg);
    dut.d_i = static_cast<unsigned char>(value);
    settle();
    wait(kClock);
    dut.iow_ni = 0;
    settle();
    wait(4 * kClock);
    dut.iow_ni = 1;
    settle();
    wait(kClock);
  }

  unsigned read(unsigned reg) {
    align(1);
    dut.a_i = static_cast<unsigned short>(0x300 | reg);
    settle();
    wait(kClock);
    dut.ior_ni = 0;
    settle();
    wait(4 * kClock);
    const unsigned value = dut.d_oe_o ? dut.d_o : 0xFFU;
    dut.ior_ni = 1;
    settle();
    wait(kClock);
    return value;
  }

  unsigned count() {
    read(kPortC);
    const unsigned msb = read(kMsb);
    return msb << 8 | read(kLsb);
  }

  void preset(unsigned value) {
    read(kPortC);
    write(kMsb, value >> 8);
    write(kLsb, value & 0xFF);
  }

  // One quarter period of axis 1.
  void step(int direction) {
    where_ = (where_ + direction) & 3;
    dut.enc_a_i = where_ == 1 || where_ == 2;
    dut.enc_b_i = where_ >= 2;
  }

  void sclock() {
    dut.sclock_i = 1;
    after(4 * kClock, [this] { dut.sclock_i = 0; });
  }

  long panic_low = 0, panic_high = 0;  // shortest levels of PANIC since cleared

 protected:
  bool clock_moves(long phase) override { return phase == 0 || phase == 12; }
  void clocks(long phase) override { dut.clk_i = phase == 0; }
  void look() override {
    if (dut.ior_ni && dut.d_oe_o) fail("data is driven without IOR#");
    if (dut.panic_o == panic_was_) return;
    long &shortest = panic_was_ ? panic_high : panic_low;
    if (now - panic_at_ < shortest) shortest = now - panic_at_;
    panic_at_ = now;
    panic_was_ = dut.panic_o;
  }

 private:
  int where_ = 0;
  long panic_at_ = 0;
  bool panic_was_ = false;
};

template <class F>
void sweep(Card &card, const char *name, long from, long to, long kinds, F one) {
  for (long kind = 0; kind < kinds; ++kind) {
    card.sweep(from, to, [&](long at, long phase) {
      one(kind, at, phase);
      card.end_case(name, "kind %ld, at %ld, phase %ld", kind, at, phase);
    });
  }
}

// Two edges of the encoder; going back slowly by two must undo what they counted, or they were one.
void scene_edges(Card &card) {
  sweep(card, "encoder", 0, kAround, 4, [&](long kind, long at, long phase) {
    const int way = kind & 1 ? -1 : 1;
    if (kind & 2) {
      card.dut.enc_b_i ^= 2;  // the other axis moves as well, against nothing
    }
    card.preset(0x0100);
    card.align(phase);
    card.after(1, [&card, way] { card.step(way); });
    card.after(1 + at, [&card, way] { card.step(way); });
    card.wait(kAround + 6 * kClock);
    const unsigned both = 0x100U + static_cast<unsigned>(2 * way);
    const unsigned got = card.count();
    // So close to each other they may be taken in the wrong order.
    const bool swapped = card.either && at <= kWindow && got == 0x200U - both;
    if (got != both && !swapped && (at >= kClock + card.apart() || got != 0x100))
      card.fail("a wrong count");
  });
  card.end_scene("encoder edges",
                 "A and B 0–375 ns apart, both directions: exact from one clock on, "
                 "both or none below");
}

void scene_latch(Card &card) {
  sweep(card, "latch", -4 * kClock, kAround, 2, [&](long kind, long at, long phase) {
    card.preset(0x00FF);
    card.count();
    card.align(1);
    card.after(6 * kClock, [&card] { card.sclock(); });
    card.after(6 * kClock + at + phase - 1, [&card] { card.step(1); });
    card.wait(16 * kClock);
    const unsigned msb = card.read(kind ? kLsb : kMsb), lsb = card.read(kind ? kMsb : kLsb);
    const unsigned latched = kind ? lsb << 8 | msb : msb << 8 | lsb;
    const long edge = at + phase - 1;
    if (latched != 0xFF && latched != 0x100) card.fail("a latched count in pieces");
    if (edge <= -3 * kClock - card.apart() && latched != 0x100)
      card.fail("an edge long before the latch is missing");
    if (edge > 0 && latched != 0xFF) card.fail("an edge after the latch is in it");
    if (card.count() != 0x100) card.fail("the live count is wrong");
  });
  card.end_scene("latch and edge",
                 "an encoder edge −500–500 ns from SCLOCK, the latch read in both "
                 "orders");
}

// An edge that comes with the index is in the count that it latches, whatever SCLOCK does.
void scene_index(Card &card) {
  sweep(card, "index", -5 * kClock, 2 * kClock, 2, [&](long kind, long at, long phase) {
    card.set_up(kJoints | kSclock | kIndex);
    card.preset(0x2000);
    card.count();
    card.align(phase);
    const long t = 6 * kClock;  // the index
    card.after(t, [&card] {
      card.step(1);
      card.dut.enc_i_i = 1;
    });
    if (kind) card.after(t + 5 * kClock, [&card] { card.step(1); });
    card.after(t + 6 * kClock, [&card] { card.dut.enc_i_i = 0; });
    // SCLOCK is the adaptor's: it moves just after a clock edge
    const long clock = ((t - at) + phase) / kClock * kClock - phase + 1;
    card.after(clock, [&card] { card.sclock(); });
    card.wait(24 * kClock);
    if (!(card.read(kPortC) & 2)) card.fail("the index is not latched");
    const unsigned msb = card.read(kMsb), got = msb << 8 | card.read(kLsb);
    const bool later = clock > t + 3 * kClock;  // SCLOCK may have latched after the index
    // So close to a clock the index may be taken a clock before its edge.
    const bool first = card.either && phase >= kClock - kWindow && got == 0x2000;
    if (got != 0x2001 && !first && !(later && kind && got == 0x2002))
      card.fail("not the count of the index");
    card.set_up();
  });
  card.end_scene("index and latch",
                 "the index with an edge, −250–625 ns from SCLOCK, at rest and "
                 "moving");
}

void scene_index_edge(Card &card) {
  sweep(card, "index edge", -kAround, kAround, 2, [&](long kind, long at, long phase) {
    card.set_up(kJoints | kIndex);
    const int way = kind ? -1 : 1;
    card.preset(0x4000);
    card.align(phase);
    card.after(kAround, [&card] { card.dut.enc_i_i = 1; });
    card.after(kAround + at, [&card, way] { card.step(way); });
    card.after(3 * kAround, [&card] { card.dut.enc_i_i = 0; });
    card.wait(5 * kAround);
    const unsigned msb = card.read(kMsb), got = msb << 8 | card.read(kLsb);
    const unsigned moved = 0x4000U + static_cast<unsigned>(way);
    if (got != 0x4000 && got != (moved & 0xFFFF)) card.fail("a wrong count");
    if (at <= -card.apart() && got != (moved & 0xFFFF))
      card.fail("an edge before the index is missing");
    if (at > kClock + card.apart() && got != 0x4000) card.fail("a later edge is in the count");
    card.set_up();
  });
  card.end_scene("index and edge", "an encoder edge within ±3 clocks of the index");
}

void scene_read(Card &card) {
  sweep(card, "read", 0, 14 * kClock, 4, [&](long kind, long at, long phase) {
    const int way = kind & 1 ? -1 : 1;
    card.preset(way > 0 ? 0x00FF : 0x0100);
    card.align(phase);
    card.after(at, [&card, way] { card.step(way); });
    const unsigned first = card.read(kind & 2 ? kLsb : kMsb),
                   next = card.read(kind & 2 ? kMsb : kLsb);
    const unsigned got = kind & 2 ? next << 8 | first : first << 8 | next;
    if (got != 0x00FF && got != 0x0100) card.fail("a pair in pieces");
    card.wait(kAround);
    card.wait(2 * kClock);
    if (card.count() != (way > 0 ? 0x0100U : 0x00FFU)) card.fail("a count is lost");
  });
  card.end_scene("pair read and edge",
                 "an encoder edge at any 5 ns of a pair of reads, both orders");
}

void scene_write(Card &card) {
  sweep(card, "write", 0, 18 * kClock, 4, [&](long kind, long at, long phase) {
    const int way = kind & 1 ? -1 : 1;
    const unsigned value = way > 0 ? 0x12FFU : 0x1300U, moved = value + static_cast<unsigned>(way);
    card.preset(0x00FF);
    card.read(kPortC);
    card.align(phase);
    card.after(at, [&card, way] { card.step(way); });
    card.write(kind & 2 ? kLsb : kMsb, kind & 2 ? value & 0xFF : value >> 8);
    card.write(kind & 2 ? kMsb : kLsb, kind & 2 ? value >> 8 : value & 0xFF);
    card.wait(3 * kAround);
    const unsigned got = card.count();
    if (got != value && got != (moved & 0xFFFF)) card.fail("a preset in pieces");
  });
  card.end_scene("pair write and edge",
                 "an encoder edge at any 5 ns of a pair of writes, both orders");
}

// A lone byte, read or written, first after RESET or later, leaves nothing behind another access.
void scene_lone(Card &card) {
  sweep(card, "lone byte", 0, 0, 16, [&](long kind, long, long) {
    if (kind & 1) {
      card.dut.reset_drv_i = 1;
      card.wait(3 * kClock);
      card.dut.reset_drv_i = 0;
      card.wait(kClock);
    }
    const unsigned reg = kind & 2 ? kLsb : kMsb;
    if (kind & 4)
      card.write(reg, 0x77);
    else
      card.read(reg);
    if (kind & 1) card.set_up();
    if (kind & 8) card.sclock();
    card.wait(6 * kClock);
    if (kind & 8) card.count();  // what was latched
    card.preset(0x1234);
    if (card.count() != 0x1234) card.fail("a preset or the read after it is wrong");
    for (int n = 0; n < 3; ++n) {
      card.step(1);
      card.wait(6 * kClock);
      if (card.count() != 0x1235U + static_cast<unsigned>(n)) card.fail("a read is stale");
    }
    for (int n = 0; n < 3; ++n) {
      card.step(-1);
      card.wait(6 * kClock);
    }
  });
  card.end_scene("lone byte", "a single byte access, first after RESET or later, then pairs");
}

// The D/A's low byte is written around the end of the pulse: PANIC rises once or not at all.
void scene_heartbeat(Card &card) {
  sweep(card, "heartbeat", -kAround, kAround, 2, [&](long kind, long at, long phase) {
    card.dut.enable_i = 1;
    card.write(kDacLow, 0);
    card.wait(kHeartbeat - 8 * kClock + at);
    card.panic_low = card.panic_high = 1000000;
    if (kind) {  // the axis switch moves as well
      card.after(2 * kClock + phase, [&card] { card.dut.enable_i = 0; });
      card.after(5 * kClock + phase, [&card] { card.dut.enable_i = 1; });
    }
    card.write(kDacLow, 0x55);
    card.wait(6 * kClock);
    if (card.dut.panic_o) card.fail("PANIC after a heartbeat");
    if (!kind && card.panic_high < kClock - 1) card.fail("PANIC has a glitch");
    card.dut.enable_i = 0;
    card.wait(kHeartbeat + 2 * kClock);
  });
  card.end_scene("heartbeat",
                 "the D/A written within ±3 clocks of the end of the one-shot, the axis "
                 "switch moving or not");
}

void scene_reset_drv(Card &card) {
  sweep(card, "RESET DRV", 0, 8 * kClock, 2, [&](long kind, long at, long phase) {
    card.align(phase);
    card.after(at, [&card, kind] { (kind ? card.dut.power_i : card.dut.reset_drv_i) = !kind; });
    card.after(at + 6 * kClock,
               [&card, kind] { (kind ? card.dut.power_i : card.dut.reset_drv_i) = kind; });
    card.write(kPortA, 0x1D);
    card.wait(14 * kClock);
    if (card.dut.drive_v_o) card.fail("a drive moves after RESET");
    card.set_up();
    card.preset(0x5A5A);
    if (card.count() != 0x5A5A) card.fail("the card does not come back");
    card.write(kPortA, 0x15);
    if (card.read(kPortA) != 0x15) card.fail("the PPI does not come back");
    card.write(kPortA, 5);
  });
  card.end_scene("RESET DRV and power", "at any 5 ns of a write");
}

void scene_adc(Card &card) {
  sweep(card, "A/D", -kAround, kAround, 1, [&](long, long at, long) {
    card.write(kDacLow, 0);
    card.write(kDacHigh, 8);
    card.dut.adc_v_i = 0x1000;
    card.align(1);
    card.after(kClock, [&card] { card.sclock(); });
    card.after(3 * kClock, [&card] { card.dut.adc_v_i = 0x5000; });
    card.after((17 + at / kClock) * kClock, [&card] { card.sclock(); });
    card.wait(60 * kClock);
    const unsigned low = card.read(kAdcLow), code = (card.read(kAdcHigh) & 0xF) << 8 | low;
    if (code != 0x900 && code != 0xD00) card.fail("a conversion in pieces");
    if (!(card.read(kPortC) & 0x10)) card.fail("a conversion without end");
  });
  card.end_scene("A/D and latch", "a second latch within ±3 clocks of the end of the conversion");
}

}  // namespace

int main(int argc, char **argv) {
  Verilated::commandArgs(argc, argv);
  Verilated::threadContextp()->randSeed(1);
  Card card;
  const Options options(argc, argv);
  card.sample = options.sample;
  struct {
    const char *name;
    void (*run)(Card &);
  } scenes[] = {{"edges", scene_edges},         {"latch", scene_latch},
                {"index", scene_index},         {"index_edge", scene_index_edge},
                {"read", scene_read},           {"write", scene_write},
                {"lone", scene_lone},           {"heartbeat", scene_heartbeat},
                {"reset_drv", scene_reset_drv}, {"adc", scene_adc}};
  for (const bool either : {false, true}) {
    card.either = either;
    for (auto &scene : scenes) {
      if (!options.wants(scene.name)) continue;
      card.reset();
      scene.run(card);
    }
  }
  card.either = false;
  card.end_scene("all of these", "synchronisers either way");
  return card.total != 0;
}
