// SPDX-License-Identifier: Apache-2.0
// VME cycles of the host, with time-out and bus error. §4.3.

#include "vme_bus.h"

#include <cstdio>

namespace mmcs {
namespace {

// Strobes stay low for so long before an injected BERR* ends the cycle.
constexpr int64_t kInjectedErrorClks = 4;
constexpr unsigned kAmAcknowledge = 0x2D;  // not looked at while IACK* is low

}  // namespace

VmeBus::VmeBus(Machine &machine, double timeout_us)
    : machine_(machine), timeout_clks_(machine.clocks((timeout_us > 0 ? timeout_us : 16) * 1e-6)) {}

// Lets clocks pass for a cycle that is made clock by clock (Model::clock_by_clock()).
static bool advance(Machine &machine, int64_t n, int dtack) {
  return machine.advance(n, dtack < 0   ? Watch::kNothing
                            : dtack > 0 ? Watch::kDtackHigh
                                        : Watch::kDtackLow);
}

BusResult VmeBus::fail(BusResult result, uint32_t address) {
  ++failures_;
  char text[64];
  std::snprintf(text, sizeof text, "%s at 0x%04X",
                result == BusResult::kTimeout ? "bus time-out" : "bus error", address);
  machine_.note("bus", -1, text);
  return result;
}

void VmeBus::keep(int64_t begin, int64_t end, int kind, const Model::BusRequest &c,
                  BusResult answer) {
  if (!watched_) return;
  kept_.push_back({begin, end, c.address, c.data, static_cast<int32_t>(c.am),
                   static_cast<int32_t>(c.ds), kind, static_cast<int32_t>(answer)});
}

BusResult VmeBus::cycle(const Model::BusRequest &c, unsigned *data) {
  if (machine_.host_dead()) return BusResult::kTimeout;
  Model &model = machine_.model();
  const int64_t begin = machine_.clock();
  const int kind = c.write ? MMCS_BUS_WRITE : MMCS_BUS_READ;
  ++cycles_;
  BusResult result = BusResult::kOk;
  const auto answered = [&](const Model::BusReply &reply) {
    if (result == BusResult::kError) return keep(begin, reply.answered, kind, c, result);
    *data = reply.data;
    const unsigned moved = c.write ? c.data : reply.data;
    Hash &trail = machine_.trail();
    trail.add(static_cast<uint64_t>(reply.answered));
    trail.add((static_cast<uint64_t>(c.address) << 32) | (uint64_t{c.write} << 63) |
              (c.write || result == BusResult::kOk ? moved : 0x10000u));
    keep(begin, reply.answered, kind, {c.address, c.am, c.ds, c.write, moved, 0}, result);
  };
  Model::BusReply reply;
  if (machine_.bus_cycle(c, &reply)) {
    answered(reply);
    return result;
  }
  const auto pass = [&](int64_t n, int dtack) {
    if (dtack == 0 && machine_.take_bus_error()) {
      result = BusResult::kError;
      machine_.advance(kInjectedErrorClks, Watch::kNothing);
    } else if (!advance(machine_, n, dtack) && dtack == 0) {
      result = BusResult::kTimeout;
    }
  };
  model.clock_by_clock(c, pass, answered);
  return result == BusResult::kOk ? result : fail(result, c.address);
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
  const BusResult result = cycle({address, am, ds, false, 0xFFFF, timeout_clks_}, &data);
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
  return cycle({address, am, ds, true, lines, timeout_clks_}, &data);
}

BusResult VmeBus::acknowledge(int level, uint8_t *vector) {
  Model &model = machine_.model();
  const uint32_t address = static_cast<uint32_t>(level) << 1;
  const int64_t begin = machine_.clock();
  ++cycles_;
  model.pins().vme_address(address, kAmAcknowledge, false, 0xFFFF, true);
  machine_.advance(1, Watch::kNothing);
  model.pins().vme_strobes(1);
  machine_.advance(1, Watch::kNothing);
  model.pins().vme_iackin(true);
  const bool answered = machine_.advance(timeout_clks_, Watch::kDtackLow);
  *vector = static_cast<uint8_t>(model.pins().vme_data(model.vme_sample() & 0xFFFF));
  machine_.trail().add(static_cast<uint64_t>(machine_.clock()) << 8 | (answered ? *vector : 0u));
  keep(begin, machine_.clock(), MMCS_BUS_IACK, {address, kAmAcknowledge, 1, false, *vector, 0},
       answered ? BusResult::kOk : BusResult::kTimeout);
  model.release([this](int64_t n, int dtack) { advance(machine_, n, dtack); });
  if (answered) return BusResult::kOk;
  ++failures_;
  machine_.note("bus", -1, "interrupt acknowledge unanswered");
  return BusResult::kTimeout;
}

}  // namespace mmcs
