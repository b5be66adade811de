// SPDX-License-Identifier: Apache-2.0
// Sweeps of the VMEbus: two events of asynchronous lines, every 5 ns against each other and the
// clock.

#include "scenes.h"

void expect_writes(Backplane &bus, const Cycle &may, const Cycle &must) {
  size_t at = 0;
  auto is = [&](const Cycle &c) {
    return at < bus.written.size() && (bus.written[at].address & 0x1F) == (c.address >> 1 & 0x1F) &&
           bus.written[at].data == c.data;
  };
  if (may.ours() && may.write && is(may)) ++at;
  if (must.write) {
    if (!is(must)) {
      bus.fail("a write is lost or goes wrong");
      return;
    }
    ++at;
  }
  if (at != bus.written.size()) bus.fail("a write that nobody asked for");
}

void finish(Backplane &bus, const Cycle &cycle) {
  bus.strobe(cycle);
  unsigned data = 0;
  if (!bus.answered(cycle, &data))
    bus.fail("a cycle of ours is not answered");
  else if (!cycle.write && data != ((0x300U | (cycle.address >> 1 & 0x1F)) ^ 0x5AU) % 256U) {
    bus.fail("a read gives the wrong data");
  }
  bus.release();
}

namespace {

// The strobe is low for `low` steps in another's cycle, in ours withdrawn, or until its DTACK*;
// then high for `gap`, then a cycle of ours.
void strobes_apart(Backplane &bus, const Cycle &first, const Cycle &next, long low, long gap,
                   long phase) {
  bus.written.clear();
  bus.align(phase);
  bus.put(first);
  bus.wait(2);
  bus.as(true);
  bus.strobe(first);
  bus.wait(low);
  bus.ds(3);
  bus.as(false);
  if (bus.dtack()) bus.wait_for([&] { return !bus.dtack(); }, 5 * kClock);
  bus.put(next);
  bus.wait(gap);
  bus.as(true);
  finish(bus, next);
  expect_writes(bus, first, next);
}

void scene_gap(Backplane &bus) {
  struct {
    const char *name;
    const Cycle &first;
  } kinds[] = {{"another's read", kForeignRead},
               {"another's write", kForeignWrite},
               {"even byte", kEven},
               {"our write withdrawn", kWrite},
               {"our read withdrawn", kRead}};
  for (auto &kind : kinds) {
    for (long low : {6L, 13L, 24L, 26L, 37L, 51L, 63L, 80L, 120L, 170L, 200L, 230L}) {
      bus.sweep(6, kAround, [&](long gap, long phase) {
        strobes_apart(bus, kind.first, gap % 2 ? kWriteNext : kRead, low, gap, phase);
        bus.check_health();
        bus.end_case(kind.name, "low %ld, high %ld, phase %ld", low, gap, phase);
      });
    }
  }
  bus.end_scene("strobe gap",
                "DS\\* high 30–375 ns after a cycle of another board, or one of ours "
                "withdrawn, then a cycle of ours");
}

void scene_withdrawn(Backplane &bus) {
  for (long gap : {6L, 9L, 24L, 25L, 50L}) {
    bus.sweep(6, 14 * kClock, [&](long low, long phase) {
      const Cycle &first = low % 3 ? kWrite : kRead;
      strobes_apart(bus, first, low % 2 ? kWriteNext : kRead, low, gap, phase);
      bus.check_health();
      bus.end_case("withdrawn", "low %ld, high %ld, phase %ld", low, gap, phase);
    });
  }
  bus.end_scene("withdrawal",
                "a strobe of ours withdrawn at any 5 ns of its cycle, the next one "
                "30–250 ns later");
}

// The next address is put out while the strobe of `first` still stands, `over` steps of it under
// AS* of the next; then the strobe is high for `gap` and falls for the next.
void pipelined(Backplane &bus, const Cycle &first, const Cycle &next, long low, long over, long gap,
               long phase) {
  bus.written.clear();
  bus.align(phase);
  bus.put(first);
  bus.wait(2);
  bus.as(true);
  bus.strobe(first);
  if (first.ours())
    bus.answered(first);
  else
    bus.wait(low);
  bus.as(false);
  bus.put_address(next);
  bus.wait(6);
  bus.as(true);
  bus.wait(over);
  if (bus.written.size() > (first.ours() && first.write ? 1U : 0U)) {
    bus.fail("another board's data is written to us");
  }
  bus.ds(3);
  bus.wait_for([&] { return !bus.dtack(); }, 5 * kClock);
  bus.put(next);
  bus.wait(gap);
  finish(bus, next);
  expect_writes(bus, first, next);
}

void scene_pipeline(Backplane &bus) {
  for (const Cycle *first : {&kForeignWrite, &kForeignRead, &kWrite, &kRead}) {
    for (long low : {6L, 20L, 60L}) {
      if (first->ours() && low != 6) continue;
      for (long gap : {6L, 13L, 30L}) {
        bus.sweep(0, kAround, [&](long over, long phase) {
          pipelined(bus, *first, over % 2 ? kWriteNext : kRead, low, over, gap, phase);
          bus.check_health();
          bus.end_case("pipelined", "low %ld, over %ld, phase %ld", low, over, phase);
        });
      }
    }
  }
  bus.end_scene("address pipelining",
                "our address and AS\\* 0–375 ns before the strobe of another's "
                "or our own cycle rises");
}

void scene_skew(Backplane &bus) {
  const Cycle word{kCard | 0x30U, true, 0x5B, false, 0b00};
  for (long late = -2; late <= kAround; ++late) {  // AS* before DS0*, 10 ns after at the most
    // DS1* against DS0*, at both ends
    bus.sweep(-4, 4, [&](long skew, long phase) {
      bus.written.clear();
      bus.put(word);
      bus.align(phase);
      const long base = 8;
      bus.after(base - late, [&] { bus.dut.as_ni = 0; });
      bus.after(base, [&] {
        bus.on_bus = &word;
        bus.dut.ds_ni &= 2;
      });
      bus.after(base + skew, [&] {
        bus.on_bus = &word;
        bus.dut.ds_ni &= 1;
      });
      if (late > base) {
        bus.dut.as_ni = 0;
      }
      bus.wait(base + 5);
      if (!bus.answered(word)) bus.fail("a word is not answered");
      bus.after(5, [&] { bus.dut.ds_ni |= 1; });
      bus.after(5 + skew, [&] { bus.dut.ds_ni |= 2; });
      bus.wait(12);
      bus.release();
      expect_writes(bus, kForeignRead, word);
      bus.check_health();
      bus.end_case("skew", "AS* %ld, DS1* %ld, phase %ld", late, skew, phase);
    });
  }
  bus.end_scene("strobe skew",
                "AS\\* −10–375 ns before DS0\\*, DS1\\* within 20 ns of it at both ends");
}

void scene_reset(Backplane &bus) {
  for (const Cycle *cycle : {&kWrite, &kRead, &kForeignWrite}) {
    bus.sweep(-kAround, kAround, [&](long at, long phase) {
      bus.align(phase);
      bus.wait(kAround);
      bus.after(at + kAround, [&] { bus.dut.sysreset_ni = 0; });
      bus.after(kAround, [&] {
        bus.put(*cycle);
        bus.dut.as_ni = 0;
        bus.on_bus = cycle;
        bus.dut.ds_ni = cycle->ds & 3;
      });
      bus.wait(2 * kAround + 10 * kClock);
      bus.release();
      bus.wait(20 * kClock);
      if (bus.dut.dtack_o || bus.dut.d_oe_o) bus.fail("SYSRESET* does not let go");
      bus.dut.sysreset_ni = 1;
      bus.wait(6 * kClock);
      bus.write(kPccsr, kArmed | kBase);
      bus.check_health();
      bus.end_case("SYSRESET*", "%ld after DS0*, phase %ld", at, phase);
    });
  }
  bus.end_scene("SYSRESET\\*", "falls within ±3 clocks of DS\\*; afterwards all is well");
}

}  // namespace

int main(int argc, char **argv) {
  Verilated::commandArgs(argc, argv);
  Backplane bus;
  const Options options(argc, argv);
  bus.sample = options.sample;
  struct {
    const char *name;
    void (*run)(Backplane &);
  } scenes[] = {
      {"gap", scene_gap},         {"withdrawn", scene_withdrawn}, {"pipeline", scene_pipeline},
      {"skew", scene_skew},       {"reset", scene_reset},         {"chain", scene_chain},
      {"request", scene_request}, {"mixed", scene_mixed},         {"pccsr", scene_pccsr},
      {"link", scene_link},       {"safety", scene_safety}};
  for (auto &scene : scenes) {
    if (!options.wants(scene.name)) continue;
    bus.reset();
    scene.run(bus);
  }
  return bus.total != 0;
}
