// SPDX-License-Identifier: Apache-2.0
// What a user's program does with /dev/mc0 for a scenario (§2.3.6): configure the driver, carry a
// [[call]] out, turn axes round at their limits. Decided here for Python, the page, FMU and
// bridges.
//
// Knows the C ABI and mcdef.h only.

#include <algorithm>
#include <cstring>
#include <string>

#include "mcdef.h"
#include "mmcs_sim.h"

namespace {

constexpr int kAxes = 32;
constexpr int kWords = sizeof(mc_param) / sizeof(int);

bool named(uint32_t axes, int axis) {
  return axes >> axis & 1;
}

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

void merge(mc_param &param, const mmcs_set *sets, int count) {
  int words[kWords];
  std::memcpy(words, &param, sizeof words);
  for (const mmcs_set *set = sets; set != sets + count; ++set) {
    if (set->word < 1 || set->word >= kWords) continue;  // word 0 is `which`
    words[set->word] = (words[set->word] & ~set->mask) | (set->value & set->mask);
  }
  std::memcpy(&param, words, sizeof words);
}

}  // namespace

extern "C" {

int mmcs_sim_configure(mmcs_sim *sim, int client, int what, const mmcs_driver *driver,
                       const struct mc_param *params, char *refused, size_t refused_len) {
  if (!driver || !params || driver->axes < 0 || driver->axes > kAxes) return -1;
  Requests requests(sim, client);
  if (what & MMCS_SET_UP) set_up(requests, *driver);
  if (what & MMCS_SWITCH_ON) switch_on(requests, *driver, params);
  const int rest[kAxes] = {};
  if (what == (MMCS_SET_UP | MMCS_SWITCH_ON)) requests.write(rest, driver->axes);
  if (refused && refused_len) {
    const size_t length = std::min(requests.refused().size(), refused_len - 1);
    std::memcpy(refused, requests.refused().data(), length);
    refused[length] = 0;
  }
  return requests.result();
}

int mmcs_sim_call(mmcs_sim *sim, int client, int32_t axes, struct mc_param *params,
                  const mmcs_call *call, const mmcs_set *sets, struct mc_state *states,
                  int32_t *results) {
  if (!params || !call || !states || !results || axes < 0 || axes > kAxes) return -1;
  if (call->sets < 0 || (call->sets && !sets)) return -1;
  const uint32_t request = call->request;
  for (int axis = 0; axis < kAxes; ++axis) results[axis] = 0;
  if (request == MCALIB || request == MCLEARERROR) {
    // MCALIB: the potentiometer tells which index pulse comes; MCLEARERROR clears what a read
    // showed
    const size_t bytes = sizeof *states * static_cast<size_t>(axes);
    const int got = mmcs_sim_read(sim, client, states, bytes);
    if (got < 0) return results[0] = got;
  }
  if (request != MCALIB && request != MSETENC && request != MSETPARAM) {
    int value = call->value;
    return results[0] =
               mmcs_sim_ioctl(sim, client, request, request & MC_ARG_IN ? &value : nullptr);
  }
  int least = 0;
  for (int axis = 0; axis < axes; ++axis) {
    if (!named(call->axes, axis)) continue;
    int value = request == MCALIB ? axis : axis | (call->value & 0xFFFF) << 8;
    void *argument = &value;
    if (request == MSETPARAM) {
      merge(params[axis], sets, call->sets);
      params[axis].which = axis;
      argument = &params[axis];
    }
    results[axis] = mmcs_sim_ioctl(sim, client, request, argument);
    least = std::min(least, results[axis]);
  }
  return least;
}

int mmcs_sim_bounce(mmcs_sim *sim, int client, int32_t axes, uint32_t bounces, const int32_t *goals,
                    int32_t *setpoints) {
  if (!goals || !setpoints || axes < 0 || axes > kAxes) return -1;
  if (!mmcs_sim_signals(sim, client)) return 0;
  mc_state states[kAxes] = {};
  const int got = mmcs_sim_read(sim, client, states, sizeof *states * static_cast<size_t>(axes));
  if (got < 0) return got;
  mmcs_sim_ioctl(sim, client, MCLEARERROR, nullptr);
  bool turned = false;
  for (int axis = 0; axis < axes; ++axis) {
    const int limits = states[axis].errcode & MERR_POSLIM;
    if (!named(bounces, axis) || (limits != MERR_PHI && limits != MERR_PLO)) continue;
    const int speed = goals[axis] < 0 ? -goals[axis] : goals[axis];
    setpoints[axis] = limits == MERR_PHI ? -speed : speed;
    turned = true;
  }
  if (!turned) return 0;
  const size_t bytes = sizeof *setpoints * static_cast<size_t>(axes);
  const int written = mmcs_sim_write(sim, client, setpoints, bytes);
  return written < 0 ? written : 1;
}

}  // extern "C"
