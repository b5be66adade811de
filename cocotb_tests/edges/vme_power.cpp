// SPDX-License-Identifier: Apache-2.0
// Sweeps of PCCSR, button, cable and power.

#include "scenes.h"

void scene_pccsr(Backplane &bus) {
  const Cycle arm{kPccsr, true, kArmed | kPanicIrq | kBase};
  bus.sweep(-kAround, 4 * kAround, [&](long at, long phase) {
    bus.write(kPccsr, kBase);
    bus.wait(8);
    bus.put(arm);
    bus.align(phase);
    bus.after(kAround + at, [&] { bus.dut.estop_closed_i = 0; });
    bus.wait(kAround);
    bus.as(true);
    bus.strobe(arm);
    const long fell = bus.now;
    if (!bus.answered(arm)) bus.fail("a write is not answered");
    const long acked = bus.now - fell;
    bus.release();
    bus.wait(4 * kAround);
    const unsigned first = bus.read(kPccsr), second = bus.read(kPccsr);
    if (first != second) bus.fail("two reads of PCCSR differ");
    const bool latched = first & kPanicIrq;
    if (latched != bus.dut.irq_o) bus.fail("latch and request differ");
    if (at >= acked && !latched) bus.fail("an edge under bit 7 is lost");
    if (at <= 0 && latched && acked > 5 * kClock) bus.fail("an edge before bit 7 is latched");
    if (!bus.dut.panic_o || bus.dut.brake_o) bus.fail("no PANIC");
    bus.dut.estop_closed_i = 1;
    bus.wait(12 * kClock);
    if (bus.dut.panic_o || !bus.dut.brake_o) bus.fail("PANIC stays");
    bus.check_health();
    bus.end_case("PCCSR", "button %ld after DS0*, phase %ld", at, phase);
  });
  bus.write(kPccsr, kArmed | kBase);
  bus.end_scene("PCCSR",
                "the button opens −375–1500 ns from the strobe of the write that sets bit 7");
}

void scene_link(Backplane &bus) {
  for (unsigned what = 0; what < 4; ++what) {  // cable or power; read or write
    bus.sweep(-kAround, 5 * kAround, [&](long at, long phase) {
      const Cycle &cycle = what & 1 ? kWrite : kRead;
      bus.written.clear();
      bus.put(cycle);
      bus.align(phase);
      bus.after(kAround + at, [&] { (what & 2 ? bus.dut.cable_ok_i : bus.dut.pc_power_i) = 0; });
      bus.wait(kAround);
      bus.as(true);
      bus.strobe(cycle);
      unsigned data = 0;
      if (!bus.answered(cycle, &data)) bus.fail("an access without link is not answered");
      if (!cycle.write && data != 0xFF && data != (0x315U ^ 0x5AU) % 256U) {
        bus.fail("a read gives neither the card's data nor 0xFF");
      }
      bus.release();
      bus.wait(kAround);
      if (at < 0 && (!bus.dut.panic_o || bus.dut.brake_o)) bus.fail("no PANIC");
      if (bus.dut.pc_ior_no == 0 || bus.dut.pc_iow_no == 0) bus.fail("a command stays");
      bus.wait(5 * kAround);
      bus.dut.cable_ok_i = bus.dut.pc_power_i = 1;
      bus.wait(6 * kClock);
      bus.check_health();
      bus.end_case("link", "%ld after DS0*, phase %ld, what %ld", at, phase, what);
    });
  }
  bus.end_scene("cable and power", "go away −375–1875 ns from the strobe of a read and a write");
}

void scene_safety(Backplane &bus) {
  for (unsigned pair = 0; pair < 3; ++pair) {
    bus.sweep(-kAround, kAround, [&](long at, long phase) {
      auto line = [&](unsigned n) -> unsigned char & {
        return n == 0 ? bus.dut.estop_closed_i : n == 1 ? bus.dut.cable_ok_i : bus.dut.pc_power_i;
      };
      bus.write(kPccsr, kBase);
      bus.write(kPccsr, kArmed | kPanicIrq | kBase);
      bus.align(phase);
      bus.after(kAround, [&] { line(pair) = 0; });
      bus.after(kAround + at, [&] { line((pair + 1) % 3) = 0; });
      unsigned rises = 0;
      bool was = bus.dut.panic_o;
      for (long n = 0; n < 4 * kAround; ++n) {
        bus.wait(1);
        rises += bus.dut.panic_o && !was;
        was = bus.dut.panic_o;
        if (bus.dut.brake_o && (was || !line(pair))) bus.fail("brakes are off");
      }
      if (rises != 1 || !was) bus.fail("not one rise of PANIC");
      if (!bus.dut.irq_o) bus.fail("PANIC is not latched");
      bus.after(1, [&] { line(pair) = 1; });
      bus.after(kAround + 1 + at, [&] { line((pair + 1) % 3) = 1; });
      bus.wait(6 * kAround);
      if (bus.dut.panic_o) bus.fail("PANIC stays");
      bus.check_health();
      bus.end_case("safety", "pair %ld, %ld, phase %ld", pair, at, phase);
    });
  }
  bus.write(kPccsr, kArmed | kBase);
  bus.end_scene("button, cable, power",
                "two of the three change within ±3 clocks: one edge of PANIC");
}
