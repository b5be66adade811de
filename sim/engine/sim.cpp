// SPDX-License-Identifier: Apache-2.0
// The C ABI of mmcs_sim.h, but for deeds and time travel. No exception leaves it.

#include "sim.h"

#include <exception>

namespace {

constexpr int64_t kLongest = 1 << 24;  // records in a ring of the tap

}  // namespace

extern "C" {

mmcs_sim *mmcs_sim_create(const mmcs_config *config, const mmcs_motor *motors,
                          const mmcs_link *links, char *err, size_t err_len) {
  try {
    return new mmcs_sim(*config, motors, links);
  } catch (const std::exception &problem) {
    mmcs::tell(err, err_len, problem.what());
    return nullptr;
  }
}

void mmcs_sim_destroy(mmcs_sim *sim) {
  delete sim;
}

int32_t mmcs_sim_build_cards(void) {
  return mmcs::Model::cards();
}
int32_t mmcs_sim_build_clk_hz(void) {
  return mmcs::Model::clk_hz();
}
const char *mmcs_sim_build_id(void) {
  return mmcs::build_id();
}

int mmcs_sim_trace(mmcs_sim *sim, const char *path, double from_s, double to_s) {
  if (!path || !mmcs::is_time(from_s) || !mmcs::is_time(to_s) || from_s >= to_s) return -1;
  return mmcs::guarded(sim, -1, [=] { return sim->machine.trace(path, from_s, to_s) ? 0 : -1; });
}

int mmcs_sim_watch(mmcs_sim *sim, const char *name) {
  if (!name) return -1;
  return mmcs::guarded(sim, -1, [=] { return sim->machine.model().watch(name); });
}
int64_t mmcs_sim_changes(const mmcs_sim *sim, const mmcs_change **changes) {
  if (!sim || !changes) return 0;
  const auto &found = sim->machine.model().changes();
  *changes = found.data();
  return static_cast<int64_t>(found.size());
}

const char *mmcs_sim_input_name(int32_t input) {
  return mmcs::Machine::input_name(input);
}

const mmcs_input *mmcs_sim_input(int32_t input) {
  return input >= 0 && input < mmcs::kInputCount ? &mmcs::kInputs[input].about : nullptr;
}

double mmcs_sim_input_value(const mmcs_sim *sim, int32_t input, int32_t index, double t) {
  return sim && mmcs_sim_input(input) ? sim->machine.input_value(input, index, t) : 0;
}

int mmcs_sim_run(mmcs_sim *sim, double until_s) {
  if (!mmcs::is_time(until_s) || !mmcs::rests(sim)) return -1;
  return mmcs::guarded(
      sim, -1, [=] { return sim->timeline.run_until(sim->machine.clocks(until_s)) ? 0 : -1; });
}

int mmcs_sim_run_to(mmcs_sim *sim, int64_t clock, int samples) {
  if (clock < 0 || !mmcs::rests(sim)) return -1;
  using Ends = mmcs::Host::Ends;
  sim->host.set_ends(samples ? Ends::kAtSample : Ends::kAtSignal);
  const int result =
      mmcs::guarded(sim, -1, [=] { return sim->timeline.run_until(clock) ? 0 : -1; });
  sim->host.set_ends(Ends::kAtClock);
  return result;
}

int64_t mmcs_sim_samples(const mmcs_sim *sim) {
  return sim ? sim->host.recorder().samples() : 0;
}

int32_t mmcs_sim_axes(const mmcs_sim *sim) {
  return sim ? sim->axes : 0;
}
double mmcs_sim_time(const mmcs_sim *sim) {
  return sim ? sim->machine.time() : 0.0;
}
int64_t mmcs_sim_clock(const mmcs_sim *sim) {
  return sim ? sim->machine.clock() : 0;
}

const double *mmcs_sim_log(const mmcs_sim *sim, int64_t *rows, int32_t *cols) {
  if (rows) *rows = sim ? sim->host.recorder().kept() : 0;
  if (cols) *cols = sim ? sim->host.recorder().cols() : 0;
  return sim ? sim->host.recorder().data() : nullptr;
}
void mmcs_sim_log_taken(mmcs_sim *sim) {
  if (sim) sim->host.took_log();
}

int mmcs_sim_notes(const mmcs_sim *sim, const mmcs_note **notes) {
  if (!sim || !notes) return 0;
  *notes = sim->machine.notes().data();
  return static_cast<int>(sim->machine.notes().size());
}

int64_t mmcs_sim_notes_lost(const mmcs_sim *sim) {
  return sim ? sim->machine.notes_lost() : 0;
}

void mmcs_sim_get_stats(const mmcs_sim *sim, mmcs_stats *stats) {
  if (!stats) return;
  *stats = mmcs_stats{};
  if (!sim) return;
  const struct mc_stats &driver = sim->host.stats();
  stats->cycles = static_cast<uint64_t>(sim->machine.clock());
  stats->evals = sim->machine.model().evals();
  stats->time_s = sim->machine.time();
  stats->interrupts = driver.total;
  stats->missed = driver.missed;
  stats->overruns = driver.overrun;
  stats->panics = driver.panics;
  stats->spurious = driver.spurious;
  stats->clips = driver.clips;
  stats->bus_errors = sim->bus.failures();
  stats->panic_level = sim->machine.panic();
  stats->bus_cycles = sim->bus.cycles();
  const struct mc *mc = sim->host.driver();
  stats->enabled = mc_is_enabled(mc);
  stats->stopped = mc_is_stopped(mc);
  stats->cause = mc_cause(mc, &stats->cause_of);
  stats->interval_us = static_cast<int32_t>(mc_interval(mc));
  stats->diag = mc_diag(mc);
  stats->double_buffer = mc_double_buffer(mc);
  for (const mmcs::CacheFigures &cache : sim->machine.model().cache_figures()) {
    stats->cache_hits += cache.hits;
    stats->cache_misses += cache.misses;
    stats->cache_bytes += cache.bytes;
  }
}

int mmcs_sim_caches(const mmcs_sim *sim, mmcs_cache *caches, int n) {
  if (!sim) return 0;
  int count = 0;
  for (const mmcs::CacheFigures &cache : sim->machine.model().cache_figures()) {
    if (count < n) {
      mmcs_cache &c = caches[count];
      c = {"", cache.hits, cache.misses, cache.states, cache.bytes};
      std::snprintf(c.part, sizeof c.part, "%s", cache.module.c_str());
    }
    ++count;
  }
  return count;
}

int mmcs_sim_true(const mmcs_sim *sim, int axis, mmcs_truth *truth) {
  if (!sim || axis < 0 || axis >= sim->axes) return -1;
  const mmcs::Plant &plant = sim->machine.plant();
  *truth = {plant.angle(axis), plant.velocity(axis), plant.current(axis), plant.count(axis)};
  return 0;
}

const char *mmcs_sim_register_name(int32_t reg) {
  return reg < 0 || static_cast<size_t>(reg) >= mmcs::registers().size()
             ? nullptr
             : mmcs::registers()[static_cast<size_t>(reg)].name.c_str();
}
int32_t mmcs_sim_register_width(int32_t reg) {
  return mmcs_sim_register_name(reg) ? mmcs::registers()[static_cast<size_t>(reg)].width : 0;
}
uint64_t mmcs_sim_register(mmcs_sim *sim, int32_t reg) {
  if (!sim || reg < 0) return 0;
  const size_t of_card = static_cast<size_t>(reg) - mmcs::registers().size();
  const mmcs::OwnCard *card = sim->machine.model().own_card();
  if (!mmcs_sim_register_name(reg)) return card && of_card < card->size() ? card->read(of_card) : 0;
  return sim->machine.model().read(reg);
}

int mmcs_sim_phases(const mmcs_sim *sim, mmcs_phase *phases, int n) {
  static const char *const names[] = {"latency", "pass",  "enter",  "read",
                                      "compute", "write", "publish"};
  const mmcs::Phases *found = sim ? sim->host.phases() : nullptr;
  if (!found) return 0;
  int count = 0;
  for (const auto &time : found->times()) {
    if (count < n) {
      mmcs_phase &p = phases[count];
      std::snprintf(p.name, sizeof p.name, "%s", names[count]);
      p.passes = time.passes;
      p.mean_us = time.passes ? time.sum_us / static_cast<double>(time.passes) : 0;
      p.max_us = time.max_us;
    }
    ++count;
  }
  return count;
}

uint64_t mmcs_sim_hash(const mmcs_sim *sim) {
  if (!sim) return 0;
  // The registers are read through the model's scope, which leaves no mark on the simulation.
  mmcs_sim *mutable_sim = const_cast<mmcs_sim *>(sim);
  mmcs::Hash hash = sim->host.recorder().hash();
  hash.add(mutable_sim->machine.trail().value());
  hash.add(mutable_sim->machine.model().digest());
  for (int axis = 0; axis < sim->axes; ++axis) hash.add(sim->machine.plant().angle(axis));
  return hash.value();
}

int mmcs_sim_checkpoints(const mmcs_sim *sim, const mmcs_checkpoint **points) {
  if (!sim || !points) return 0;
  *points = sim->host.recorder().checkpoints().data();
  return static_cast<int>(sim->host.recorder().checkpoints().size());
}

int mmcs_sim_tap(mmcs_sim *sim, int64_t rows, int64_t events) {
  if (rows < 0 || events < 0 || rows > kLongest || events > kLongest) return -1;
  return mmcs::guarded(sim, -1, [=] {
    sim->machine.tap().keep(rows, events);
    return 0;
  });
}
int mmcs_sim_tap_head(const mmcs_sim *sim, mmcs_tap_head *head) {
  if (!sim || !head) return -1;
  const mmcs::Tap &tap = sim->machine.tap();
  *head = {tap.rows(), tap.events(), tap.row_bytes()};
  return 0;
}
int mmcs_sim_tap_rows(const mmcs_sim *sim, int64_t from, int32_t every, uint8_t *rows,
                      int32_t limit, mmcs_tap_read *read) {
  if (!sim || !read || from < 0 || every < 1 || limit < 0 || (limit && !rows)) return -1;
  const auto got = sim->machine.tap().read_rows(from, every, rows, limit);
  *read = {got.next, got.lost, got.count};
  return 0;
}
int mmcs_sim_tap_events(const mmcs_sim *sim, int64_t from, mmcs_tap_event *events, int32_t limit,
                        mmcs_tap_read *read) {
  if (!sim || !read || from < 0 || limit < 0 || (limit && !events)) return -1;
  const auto got = sim->machine.tap().read_events(from, events, limit);
  *read = {got.next, got.lost, got.count};
  return 0;
}
int mmcs_sim_tap_note(mmcs_sim *sim, const char *kind, int32_t axis, int32_t value,
                      const char *text) {
  if (!kind || !text) return -1;
  return mmcs::guarded(sim, -1, [=] {
    sim->machine.tap().event(sim->machine.time(), kind, axis, value, text);
    return 0;
  });
}

int64_t mmcs_sim_bus_cycles(mmcs_sim *sim, const mmcs_bus_cycle **cycles) {
  if (!sim || !cycles) return 0;
  const auto &taken = sim->bus.take();
  *cycles = taken.data();
  return static_cast<int64_t>(taken.size());
}

}  // extern "C"
