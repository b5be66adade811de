// SPDX-License-Identifier: Apache-2.0
// What the handle of mmcs_sim.h stands for.
#pragma once

// The functions of this header, and nothing else, are visible outside the library.
#pragma GCC visibility push(default)
#include "mmcs_sim.h"
#pragma GCC visibility pop

#include <exception>
#include <new>

#include "host.h"
#include "machine.h"
#include "timeline.h"
#include "vme_bus.h"

struct mmcs_sim {
  mmcs_sim(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links)
      : axes(config.axes),
        machine(config, motors, links),
        bus(machine, config.bus_timeout_us),
        host(machine, bus, config),
        timeline(machine, bus, host, mmcs::config_digest(config, motors, links)) {}

  int axes;
  mmcs::Machine machine;
  mmcs::VmeBus bus;
  mmcs::Host host;
  mmcs::Timeline timeline;
};

namespace mmcs {

// Calls f; what it throws becomes a note and the value for failure.
template <typename T, typename F>
T guarded(mmcs_sim *sim, T failure, F f) {
  if (!sim) return failure;
  try {
    return f();
  } catch (const std::exception &problem) {
    const bool full = dynamic_cast<const std::bad_alloc *>(&problem) != nullptr;
    try {
      sim->machine.note("log", -1, full ? "out of memory" : problem.what());
    } catch (const std::exception &) {
      return failure;
    }
    return failure;
  }
}

}  // namespace mmcs
