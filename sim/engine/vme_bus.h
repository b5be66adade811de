// SPDX-License-Identifier: Apache-2.0
// The VME backplane of §4.3: bus master, bus timer and IACK daisy chain driver of slot 1.
#pragma once

#include <cstdint>
#include <vector>

#include "machine.h"

namespace mmcs {

enum class BusResult { kOk = 0, kTimeout = 1, kError = 2 };

class VmeBus {
 public:
  VmeBus(Machine &machine, double timeout_us);

  // One access of 1, 2 or 4 bytes; 4 bytes are two 16-bit cycles. Address as on the bus.
  BusResult read(uint32_t address, unsigned am, int size, uint32_t *value);
  BusResult write(uint32_t address, unsigned am, int size, uint32_t value);
  // Acknowledges the level. kTimeout: nobody answered.
  BusResult acknowledge(int level, uint8_t *vector);

  uint64_t cycles() const { return cycles_; }
  int32_t failures() const { return failures_; }

  // The cycles since the last call, valid until the next; the first call starts to keep them. No
  // part of the state.
  const std::vector<mmcs_bus_cycle> &take() {
    watched_ = true;
    taken_.clear();
    taken_.swap(kept_);
    return taken_;
  }

  template <class A>
  void state(A &a) {
    past(a, cycles_);
    past(a, failures_);
  }

 private:
  BusResult cycle(const Model::BusRequest &c, unsigned *data);
  BusResult fail(BusResult result, uint32_t address);
  void keep(int64_t begin, int64_t end, int kind, const Model::BusRequest &c, BusResult answer);

  Machine &machine_;
  int64_t timeout_clks_;
  uint64_t cycles_ = 0;
  int32_t failures_ = 0;
  bool watched_ = false;
  std::vector<mmcs_bus_cycle> kept_, taken_;
};

}  // namespace mmcs
