// SPDX-License-Identifier: Apache-2.0
// What the handle of mmcs_sim.h stands for.
#pragma once

#include <cstdio>
#include <deque>
#include <exception>
#include <functional>
#include <new>
#include <string>

#include "host.h"
#include "machine.h"
#include "mmcs_sim.h"
#include "timeline.h"
#include "vme_bus.h"

// What was done to the machine at a clock, and how it is done to another.
struct mmcs_deed {
  int64_t clock;
  std::function<void(mmcs_sim *)> again;
};

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
  bool keeps_deeds = false;
  std::deque<mmcs_deed> deeds;  // the last of timeline.deeds
};

namespace mmcs {

constexpr double kLongestS = 1e9;  // clocks of it fit 64 bits with room to spare

inline bool is_time(double s) {
  return s >= -kLongestS && s <= kLongestS;  // and is a number
}

// No request waits: we are not called from mmcs_look.
inline bool rests(const mmcs_sim *sim) {
  return sim && !sim->host.waits();
}

inline void tell(char *err, size_t err_len, const std::string &why) {
  if (err && err_len) std::snprintf(err, err_len, "%s", why.c_str());
}

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
