// SPDX-License-Identifier: Apache-2.0
// VME cycles, literally: address first, strobes a clock later, release after DTACK*. §4.3.

#include "vme_bus.h"

#include <cstdio>

namespace mmcs {
namespace {

// Longest that a slave may hold DTACK* after the strobes went high, before the master goes on.
constexpr int64_t kReleaseClks = 256;
// Strobes stay low for so long before an injected BERR* ends the cycle.
constexpr int64_t kInjectedErrorClks = 4;
constexpr unsigned kAmAcknowledge = 0x2D;  // not looked at while IACK* is low

}  // namespace

VmeBus::VmeBus(Machine &machine, double timeout_us)
    : machine_(machine), timeout_clks_(machine.clocks((timeout_us > 0 ? timeout_us : 16) * 1e-6)) {}

void VmeBus::release() {
  machine_.model().pins().vme_release();
  machine_.advance(kReleaseClks, Watch::kDtackHigh);
  machine_.advance(1, Watch::kNothing);
}

BusResult VmeBus::fail(BusResult result, uint32_t address) {
  ++failures_;
  char text[64];
  std::snprintf(text, sizeof text, "%s at 0x%04X",
                result == BusResult::kTimeout ? "bus time-out" : "bus error", address);
  machine_.note("bus", -1, text);
  return result;
}

void VmeBus::keep(int64_t begin, int64_t end, int kind, const Cycle &c, BusResult answer) {
  if (!watched_) return;
  kept_.push_back({begin, end, c.address, c.data, static_cast<int32_t>(c.am),
                   static_cast<int32_t>(c.ds), kind, static_cast<int32_t>(answer)});
}

BusResult VmeBus::cycle(const Cycle &c, unsigned *data) {
  if (machine_.host_dead()) return BusResult::kTimeout;
  Model &model = machine_.model();
  const int64_t begin = machine_.clock();
  const int kind = c.write ? MMCS_BUS_WRITE : MMCS_BUS_READ;
  ++cycles_;
  Model::BusReply reply;
  const bool as_one_step =
      machine_.bus_cycle({c.address, c.am, c.ds, c.write, c.data, 0, timeout_clks_}, &reply);
  bool answered = true;
  if (!as_one_step) {
    model.pins().vme_address(c.address, c.am, c.write, false, c.data);
    machine_.advance(1, Watch::kNothing);
    model.pins().vme_strobe(c.ds);
    if (machine_.take_bus_error()) {
      machine_.advance(kInjectedErrorClks, Watch::kNothing);
      keep(begin, machine_.clock(), kind, c, BusResult::kError);
      release();
      return fail(BusResult::kError, c.address);
    }
    answered = machine_.advance(timeout_clks_, Watch::kDtackLow);
    reply = {model.pins().vme_data(model.vme_sample() & 0xFFFF), machine_.clock(), 0};
  }
  *data = reply.data;
  Hash &trail = machine_.trail();
  trail.add(static_cast<uint64_t>(reply.answered));
  trail.add((static_cast<uint64_t>(c.address) << 32) | (uint64_t{c.write} << 63) |
            (c.write    ? c.data
             : answered ? *data
                        : 0x10000u));
  keep(begin, reply.answered, kind, {c.address, c.am, c.ds, c.write, c.write ? c.data : *data},
       answered ? BusResult::kOk : BusResult::kTimeout);
  if (!as_one_step) release();
  return answered ? BusResult::kOk : fail(BusResult::kTimeout, c.address);
}

BusResult VmeBus::read(uint32_t address, unsigned am, int size, uint32_t *value) {
  unsigned data = 0;
  if (size == 4) {
    uint32_t high = 0, low = 0;
    const BusResult first = read(address, am, 2, &high);
    const BusResult second = read(address + 2, am, 2, &low);
    *value = high << 16 | low;
    return first != BusResult::kOk ? first : second;
  }
  const unsigned ds = size == 2 ? 3 : address & 1 ? 1 : 2;
  const BusResult result = cycle({address, am, ds, false, 0xFFFF}, &data);
  *value = size == 2 ? data : address & 1 ? data & 0xFF : data >> 8;
  return result;
}

BusResult VmeBus::write(uint32_t address, unsigned am, int size, uint32_t value) {
  unsigned data = 0;
  if (size == 4) {
    const BusResult first = write(address, am, 2, value >> 16);
    const BusResult second = write(address + 2, am, 2, value & 0xFFFF);
    return first != BusResult::kOk ? first : second;
  }
  const unsigned ds = size == 2 ? 3 : address & 1 ? 1 : 2;
  // A byte goes out on both halves, as a 68020 does it.
  const unsigned lines = size == 2 ? value & 0xFFFF : (value & 0xFF) * 0x101;
  return cycle({address, am, ds, true, lines}, &data);
}

BusResult VmeBus::acknowledge(int level, uint8_t *vector) {
  Model &model = machine_.model();
  const uint32_t address = static_cast<uint32_t>(level) << 1;
  const int64_t begin = machine_.clock();
  ++cycles_;
  model.pins().vme_address(address, kAmAcknowledge, false, false, 0xFFFF, true);
  machine_.advance(1, Watch::kNothing);
  model.pins().vme_strobe(1);
  machine_.advance(1, Watch::kNothing);
  model.pins().vme_iackin(true);
  const bool answered = machine_.advance(timeout_clks_, Watch::kDtackLow);
  *vector = static_cast<uint8_t>(model.pins().vme_data(model.vme_sample() & 0xFFFF));
  machine_.trail().add(static_cast<uint64_t>(machine_.clock()) << 8 | (answered ? *vector : 0u));
  keep(begin, machine_.clock(), MMCS_BUS_IACK, {address, kAmAcknowledge, 1, false, *vector},
       answered ? BusResult::kOk : BusResult::kTimeout);
  release();
  if (answered) return BusResult::kOk;
  ++failures_;
  machine_.note("bus", -1, "interrupt acknowledge unanswered");
  return BusResult::kTimeout;
}

}  // namespace mmcs
