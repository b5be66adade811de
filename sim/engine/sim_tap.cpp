// SPDX-License-Identifier: Apache-2.0
// The C ABI of mmcs_sim.h: the tap, and the cycles of the VME bus.

#include "sim.h"

namespace {

constexpr int64_t kLongest = 1 << 24;  // records in a ring

}  // namespace

extern "C" {

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

int mmcs_sim_bus_watch(mmcs_sim *sim) {
  if (!sim) return -1;
  sim->bus.watch();
  return 0;
}
int64_t mmcs_sim_bus_cycles(mmcs_sim *sim, const mmcs_bus_cycle **cycles) {
  if (!sim || !cycles) return 0;
  const auto &taken = sim->bus.take();
  *cycles = taken.data();
  return static_cast<int64_t>(taken.size());
}

}  // extern "C"
