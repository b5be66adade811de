// SPDX-License-Identifier: Apache-2.0
// The backplane of a sweep.

#include "vme.h"

namespace {
constexpr long kTimeOut = 800;               // 4 us: two PC cycles, the first one withdrawn, take 3
constexpr long kOtherRise[3] = {7, 16, 21};  // when in our clock the other boards' clocks rise
}  // namespace

Backplane::Backplane() {
  reset();
}

bool Backplane::clock_moves(long phase) {
  if (phase == 0 || phase == 12) return true;
  for (long rise : kOtherRise) {
    if (phase == rise || phase == (rise + 12) % kClock) return true;
  }
  return false;
}

void Backplane::clocks(long phase) {
  if (phase == 0) dut.clk_i = 1;
  if (phase == 12) dut.clk_i = 0;
  for (unsigned n = 0; n < 3; ++n) {
    if (phase == kOtherRise[n]) dut.clk_other_i |= 1U << n;
    if (phase == (kOtherRise[n] + 12) % kClock) dut.clk_other_i &= ~(1U << n) & 7U;
  }
}

void Backplane::reset() {
  dut.as_ni = dut.write_ni = dut.lword_ni = dut.iack_ni = dut.sysreset_ni = 1;
  dut.ds_ni = 3;
  dut.a_i = 0;
  dut.am_i = 0x3F;
  dut.d_i = 0xFF;
  dut.iackin_ni = 0xF;
  dut.estop_closed_i = dut.cable_ok_i = dut.pc_power_i = 1;
  dut.pc_d_i = 0xFF;
  dut.pc_wait_i = 0;
  dut.pc_irq_i = 0;
  dut.req_i = 0;
  on_bus = nullptr;
  fast_dtack_ = false;
  passed = answers = 0;
  dut.rst_ni = 0;
  wait(2 * kClock);
  dut.rst_ni = 1;
  wait(4 * kClock);
  write(kVector, kMyVector);
  write(kPccsr, kArmed | kBase);
}

// What must hold whenever anything moves, between clock edges too.
void Backplane::look() {
  const bool strobed = dut.ds_ni != 3;
  const unsigned fell = dut.dtack_o & ~dtack_was_;
  const unsigned rose = ~dut.dtack_o & dtack_was_;
  if (fell) {
    if (!strobed) fail("DTACK* falls without a strobe");
    if (fell & 2) {
      const bool asked = on_bus && (on_bus->ack ? on_bus->address == 5 : on_bus->ours());
      if (!asked) fail("DTACK* falls in a cycle that is not ours");
    }
    if (on_bus && on_bus->ack) answers |= fell;
    if (passed & fell) fail("an acknowledge is passed on and answered");
  }
  if (rose && strobed && dut.sysreset_ni) {
    fail("DTACK* rises before the strobes");
  }
  const unsigned outs = dut.iackout_no;
  const unsigned passes = out_was_ & ~outs & 0xF;
  if (passes) {
    passed |= passes;
    if (passes & answers) fail("an acknowledge is answered and passed on");
    if (passes & ~(dut.as_ni ? 0U : 0xFU)) fail("IACKOUT* falls while AS* is high");
  }
  if ((~outs & 0xF) & dut.iackin_ni) fail("IACKOUT* is low while IACKIN* is high");
  if (dut.as_ni && outs != 0xF) fail("IACKOUT* is low while AS* is high");
  if (fast && (passes & 2)) {
    after(6, [this] {
      if (dut.ds_ni == 3 || (dut.iackout_no & 2)) return;
      fast_dtack_ = true;
      answers |= (dut.a_i & 7) == 3 ? 4U : 8U;
      if (answers & 2) fail("an acknowledge is answered and passed on");
    });
  }
  if (!strobed) fast_dtack_ = false;
  for (unsigned n = 0; n < 3; ++n) {  // the chain from board to board
    const unsigned bit = 2U << n;
    const unsigned level = (outs >> n & 1U) * bit;
    if (((outs ^ out_was_) >> n) & 1U) {
      after(chain_delay, [this, bit, level] { dut.iackin_ni = (dut.iackin_ni & ~bit) | level; });
    }
  }
  if (dut.d_oe_o & (dut.d_oe_o - 1U)) fail("two boards drive the data");
  if (dut.d_oe_o && !strobed) fail("data is driven without a strobe");
  if ((dut.d_oe_o & 2) && on_bus && !on_bus->ack && (!on_bus->ours() || on_bus->write)) {
    fail("data is driven into another's cycle");
  }
  if (!dut.pc_ior_no) dut.pc_d_i = static_cast<unsigned char>(dut.pc_a_o ^ 0x5AU);
  if (!iow_was_ && dut.pc_iow_no) written.push_back({dut.pc_a_o, dut.pc_d_o});
  iow_was_ = dut.pc_iow_no;
  dtack_was_ = dut.dtack_o;
  out_was_ = outs;
}

void Backplane::put_address(const Cycle &cycle) {
  dut.a_i = static_cast<unsigned short>((cycle.ack ? cycle.address << 1 : cycle.address) >> 1);
  dut.am_i = static_cast<unsigned char>(cycle.am);
  dut.iack_ni = !cycle.ack;
  dut.eval();
  look();
}

void Backplane::put(const Cycle &cycle) {
  dut.write_ni = !cycle.write;
  dut.d_i = static_cast<unsigned char>(cycle.write ? cycle.data : 0xFF);
  put_address(cycle);
}

void Backplane::as(bool low) {
  dut.as_ni = !low;
  if (!low) {  // the first slot's driver lets go of the chain, 25 ns later
    after(5, [this] {
      if (dut.as_ni) dut.iackin_ni |= 1;
    });
  }
  settle();
}

void Backplane::ds(unsigned levels) {
  dut.ds_ni = static_cast<unsigned char>(levels);
  if (levels == 3) on_bus = nullptr;
  settle();
}

void Backplane::strobe(const Cycle &cycle) {
  on_bus = &cycle;
  passed = answers = 0;
  ds(cycle.ds);
}

bool Backplane::answered(const Cycle &cycle, unsigned *data) {
  const bool got = wait_for([this] { return dtack(); }, kTimeOut);
  if (got && data) {
    *data = dut.d_oe_o & 2 ? dut.d_o : 0x100U;
    if (!cycle.write && dut.dtack_o == 2 && !(dut.d_oe_o & 2)) fail("DTACK* without data");
  }
  return got;
}

void Backplane::release() {
  ds(3);
  as(false);
  wait_for([this] { return !dtack(); }, kTimeOut);
  if (dtack()) fail("DTACK* stays low");
}

bool Backplane::run(const Cycle &cycle, unsigned *data) {
  put(cycle);
  wait(3);
  as(true);
  wait(1);
  strobe(cycle);
  if (cycle.ack) {
    after(4, [this] {
      if (!dut.as_ni) dut.iackin_ni &= 0xE;
    });
  }
  const bool got = answered(cycle, data);
  release();
  return got;
}

bool Backplane::write(unsigned address, unsigned value) {
  const Cycle cycle{address, true, value};
  wait(8);
  const bool got = run(cycle);
  if (!got) fail("a write is not answered");
  return got;
}

unsigned Backplane::read(unsigned address) {
  const Cycle cycle{address, false, 0};
  unsigned data = 0x200;
  wait(8);
  if (!run(cycle, &data)) fail("a read is not answered");
  return data;
}

void Backplane::request(bool on) {
  write(kPccsr, kBase);
  if (!on) return;
  write(0x6407, 0x70);  // timer 1, mode 0: SCLOCK falls
  write(kPccsr, kArmed | kSclockIrq | kBase);
  write(0x6407, 0x74);  // mode 2: it rises
  wait(3 * kClock);
}

void Backplane::check_health() {
  if (failed()) return;
  wait(3 * kClock);
  const unsigned value = 0x11 + (++toggle_ & 0x3F);
  written.clear();
  write(kCard | 0x3FU, value);
  if (written.size() != 1 || written[0].data != value || written[0].address != 0x31F) {
    fail("the next write goes wrong");
  }
  const unsigned got = read(kCard | 0x15U);
  if (got != (0x30AU ^ 0x5AU) % 256U) fail("the next read goes wrong");
  written.clear();
}
