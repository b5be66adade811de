// SPDX-License-Identifier: Apache-2.0
// How a user's program configures the driver (§2.3.6): decided here for Python, the page, FMU and
// bridges.
//
// Knows the C ABI and mcdef.h only.

#include <algorithm>
#include <cstring>
#include <string>

#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"

namespace {

constexpr int kMostAxes = 32;

// Requests of one client up to the first that is refused.
class Requests {
 public:
  Requests(mmcs_sim *sim, int client) : sim_(sim), client_(client) {}
  void integer(const char *name, uint32_t request, int value) {
    ask(std::string(name) + " " + std::to_string(value), request, &value);
  }
  void param(const char *name, uint32_t request, const mc_param &param) {
    mc_param sent = param;
    ask(std::string(name) + " of axis " + std::to_string(param.which), request, &sent);
  }
  void ask(const std::string &what, uint32_t request, void *argument) {
    if (result_ >= 0) done(what, mmcs_sim_ioctl(sim_, client_, request, argument));
  }
  void write(const int *setpoints, int axes) {
    const size_t bytes = sizeof *setpoints * static_cast<size_t>(axes);
    if (result_ >= 0)
      done("write of the setpoints", mmcs_sim_write(sim_, client_, setpoints, bytes));
  }
  int result() const { return result_ < 0 ? result_ : 0; }
  const std::string &refused() const { return refused_; }

 private:
  void done(const std::string &what, int result) {
    result_ = result;
    if (result < 0) refused_ = what;
  }
  mmcs_sim *sim_;
  int client_;
  int result_ = 0;
  std::string refused_;
};

void set_up(Requests &driver, const mmcs_driver &wanted) {
  if (wanted.verbose) driver.integer("MSETVERBOSITY", MSETVERBOSITY, M_VERBOSE);
  driver.integer("MSETNUMJOINTS", MSETNUMJOINTS, wanted.axes);
  driver.integer("MSETINTERVAL", MSETINTERVAL, wanted.interval_us);
  driver.integer("MDACMODE", MDACMODE, wanted.double_buffer);
  // value 0: counts are relative to the start
  for (int axis = 0; axis < wanted.axes; ++axis) driver.integer("MSETENC", MSETENC, axis);
}

// Parameters as well: a stop has switched all modes off.
void switch_on(Requests &driver, const mmcs_driver &wanted, const mc_param *params) {
  for (int axis = 0; axis < wanted.axes; ++axis) {
    mc_param param = params[axis];
    param.which = axis;
    driver.param("MGETPARAM", MGETPARAM, param);
    driver.param("MSETPARAM", MSETPARAM, param);
  }
  driver.ask("MENABLE", MENABLE, nullptr);
}

}  // namespace

extern "C" {

int mmcs_sim_configure(mmcs_sim *sim, int client, int what, const mmcs_driver *driver,
                       const struct mc_param *params, char *refused, size_t refused_len) {
  if (!driver || !params || driver->axes < 0 || driver->axes > kMostAxes) return -1;
  Requests requests(sim, client);
  if (what & MMCS_SET_UP) set_up(requests, *driver);
  if (what & MMCS_SWITCH_ON) switch_on(requests, *driver, params);
  const int rest[kMostAxes] = {};
  if (what == (MMCS_SET_UP | MMCS_SWITCH_ON)) requests.write(rest, driver->axes);
  if (refused && refused_len) {
    const size_t length = std::min(requests.refused().size(), refused_len - 1);
    std::memcpy(refused, requests.refused().data(), length);
    refused[length] = 0;
  }
  return requests.result();
}

}  // extern "C"
