// SPDX-License-Identifier: Apache-2.0
// Sweeps of the IACK* chain, with boards before and behind us.

#include "scenes.h"

namespace {

struct Slot1 {
  long fall, rise;  // steps from DS* low to IACKIN*, from AS* high to its end
  bool first;       // we are the first board: the one before us is not there
};

// One acknowledge whose strobe falls now; who answered, as a bit per board.
unsigned acknowledge(Backplane &bus, const Cycle &cycle, const Slot1 &slot, unsigned *data) {
  bus.dut.as_ni = 0;
  bus.strobe(cycle);
  const unsigned bit = slot.first ? 2 : 1;
  bus.after(slot.fall, [&bus, bit] {
    if (!bus.dut.as_ni) bus.dut.iackin_ni &= ~bit & 0xFU;
  });
  *data = 0x100;
  bus.answered(cycle, data);
  bus.wait(2);
  return bus.answers;
}

void end_acknowledge(Backplane &bus, const Slot1 &slot) {
  const unsigned bit = slot.first ? 2 : 1;
  bus.dut.ds_ni = 3;
  bus.on_bus = nullptr;
  bus.dut.as_ni = 1;
  bus.after(slot.rise, [&bus, bit] { bus.dut.iackin_ni |= bit; });
  bus.wait(1);
}

}  // namespace

void scene_chain(Backplane &bus) {
  const Cycle acks[] = {{3, false, 0, true}, {5, false, 0, true}};
  for (bool asks : {true, false}) {
    bus.request(asks);
    for (bool first : {true, false}) {
      for (unsigned pair = 0; pair < 8; ++pair) {
        bus.fast = pair >= 4;
        for (long fall : {1L, 5L}) {
          for (long rise : {0L, 6L}) {
            const Slot1 slot{fall, rise, first};
            bus.sweep(6, kAround, [&](long gap, long phase) {
              bus.dut.req_i = bus.fast ? 0 : 0b110;
              bus.put(acks[pair & 1]);
              bus.align(phase);
              for (unsigned turn = 0; turn < 2; ++turn) {
                const Cycle &ack = acks[pair >> turn & 1];
                const unsigned who = ack.address == 3 ? 4 : asks ? 2 : 8;
                unsigned data;
                const unsigned got = acknowledge(bus, ack, slot, &data);
                if (!got)
                  bus.fail("an acknowledge is neither answered nor passed on");
                else if (got != who)
                  bus.fail("the wrong board answers");
                else if (who == 2 && data != kMyVector)
                  bus.fail("a wrong vector");
                end_acknowledge(bus, slot);
                bus.wait_for([&] { return !bus.dtack(); }, 5 * kClock);
                bus.put(acks[pair >> 1 & 1]);
                bus.wait(gap - 1);
              }
              bus.wait(2 * kClock);
              const bool was = bus.failed();
              bus.end_case("chain", "levels %ld, gap %ld, phase %ld", pair, gap, phase);
              if (was && asks) bus.request(true);
            });
          }
        }
      }
    }
  }
  bus.fast = false;
  bus.request(false);
  bus.write(kPccsr, kArmed | kBase);
  bus.end_scene("IACK\\* chain",
                "two acknowledges of levels 3 and 5, AS\\* high 30–375 ns between "
                "them, as first and second board, boards behind");
}

// Our request comes up around the fall of IACKIN*; the board behind asks on the same level.
void scene_request(Backplane &bus) {
  const Cycle ack{5, false, 0, true};
  for (bool first : {true, false}) {
    bus.sweep(-2 * kAround, kAround, [&](long at, long phase) {
      bus.write(kPccsr, kBase);
      bus.write(kPccsr, kArmed | kPanicIrq | kBase);
      bus.dut.req_i = 0b100;
      bus.wait(8);
      bus.put(ack);
      bus.align(phase);
      const Slot1 slot{2, 2, first};
      bus.after(2 * kAround + 2 + at, [&] { bus.dut.estop_closed_i = 0; });
      bus.wait(2 * kAround);
      unsigned data;
      const unsigned got = acknowledge(bus, ack, slot, &data);
      if (got != 2 && got != 8) bus.fail("not one of the two answers");
      if (got == 2 && data != kMyVector) bus.fail("a wrong vector");
      if (first && at <= -5 * kClock && got != 2) bus.fail("a request that stood is passed on");
      if (first && at >= 0 && got != 8) bus.fail("a later request steals the cycle");
      end_acknowledge(bus, slot);
      bus.wait(3 * kClock);
      bus.dut.estop_closed_i = 1;
      bus.wait(6 * kClock);
      bus.check_health();
      bus.end_case("request", "%ld after IACKIN*, phase %ld", at, phase);
    });
  }
  bus.write(kPccsr, kArmed | kBase);
  bus.end_scene("request",
                "our request comes up −750–375 ns from the fall of IACKIN\\*, a board "
                "behind asks too");
}

// A data cycle and an acknowledge next to each other, in both orders, the address pipelined or not.
void scene_mixed(Backplane &bus) {
  const Cycle ack{5, false, 0, true};
  bus.request(true);
  for (const Cycle *data : {&kWrite, &kForeignWrite}) {
    for (long over : {-1L, 0L, 10L, 60L}) {  // -1: not pipelined
      bus.sweep(6, kAround, [&](long gap, long phase) {
        bus.written.clear();
        const Slot1 slot{2, 5, true};
        bus.align(phase);
        bus.put(*data);
        bus.wait(2);
        bus.as(true);
        bus.strobe(*data);
        if (data->ours()) {
          if (!bus.answered(*data)) bus.fail("a cycle of ours is not answered");
        } else
          bus.wait(20);
        if (over >= 0) {
          bus.dut.as_ni = 1;
          bus.put_address(ack);
          bus.wait(6);
          bus.dut.as_ni = 0;
          bus.wait(over + 1);
        }
        bus.ds(3);
        if (over < 0) bus.dut.as_ni = 1;
        bus.wait_for([&] { return !bus.dtack(); }, 5 * kClock);
        bus.put(ack);
        bus.wait(gap);
        unsigned got_data;
        const unsigned got = acknowledge(bus, ack, slot, &got_data);
        if (got != 2 || got_data != kMyVector) bus.fail("our acknowledge is not answered");
        end_acknowledge(bus, slot);
        bus.wait_for([&] { return !bus.dtack(); }, 5 * kClock);
        bus.put(kWriteNext);
        bus.wait(gap);
        bus.dut.as_ni = 0;
        finish(bus, kWriteNext);
        expect_writes(bus, *data, kWriteNext);
        const bool was = bus.failed();
        bus.end_case("mixed", "over %ld, gap %ld, phase %ld", over, gap, phase);
        if (was) bus.request(true);
      });
    }
  }
  bus.request(false);
  bus.write(kPccsr, kArmed | kBase);
  bus.end_scene("data and acknowledge",
                "one after the other and back, 30–375 ns apart, the "
                "acknowledge's address pipelined or not");
}
