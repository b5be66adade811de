// SPDX-License-Identifier: Apache-2.0
// The C ABI of mmcs_sim.h: time travel.

#include <exception>
#include <string>

#include "sim.h"

namespace {

int64_t given(const mmcs::Bytes *bytes, const uint8_t **data) {
  if (!bytes) return -1;
  *data = bytes->data();
  return static_cast<int64_t>(bytes->size());
}

}  // namespace

extern "C" {

int64_t mmcs_sim_snapshot(mmcs_sim *sim) {
  if (!mmcs::rests(sim)) return -1;
  return mmcs::guarded(sim, int64_t{-1}, [=] { return sim->timeline.take(); });
}
int64_t mmcs_sim_snapshot_at(mmcs_sim *sim, double t) {
  if (!mmcs::is_time(t) || !mmcs::rests(sim)) return -1;
  return mmcs::guarded(sim, int64_t{-1},
                       [=] { return sim->timeline.take_at(sim->machine.clocks(t)); });
}
int mmcs_sim_restore(mmcs_sim *sim, int64_t id) {
  if (!mmcs::rests(sim)) return -1;
  return mmcs::guarded(sim, -1, [=] {
    const int64_t before = sim->timeline.deeds;
    if (!sim->timeline.restore(id)) return -1;
    for (int64_t n = sim->timeline.deeds; n < before && !sim->deeds.empty(); ++n)
      sim->deeds.pop_back();
    return 0;
  });
}
int mmcs_sim_drop(mmcs_sim *sim, int64_t id) {
  return mmcs::guarded(sim, -1, [=] { return sim->timeline.drop(id) ? 0 : -1; });
}
int mmcs_sim_ring(mmcs_sim *sim, double every_s, int32_t count) {
  if (!mmcs::is_time(every_s) || every_s < 0 || count < 0) return -1;
  return mmcs::guarded(sim, -1, [=] {
    sim->timeline.ring(sim->machine.clocks(every_s), count);
    return 0;
  });
}
uint64_t mmcs_sim_future(mmcs_sim *sim) {
  return mmcs::guarded(sim, uint64_t{0}, [=] { return sim->timeline.future(); });
}
int mmcs_sim_snapshots(const mmcs_sim *sim, const mmcs_snapshot **list) {
  if (!sim || !list) return 0;
  *list = sim->timeline.list().data();
  return static_cast<int>(sim->timeline.list().size());
}

int64_t mmcs_sim_snapshot_bytes(mmcs_sim *sim, int64_t id, const uint8_t **bytes) {
  if (!bytes) return -1;
  return mmcs::guarded(sim, int64_t{-1}, [=] { return given(sim->timeline.bytes(id), bytes); });
}
int64_t mmcs_sim_history_bytes(mmcs_sim *sim, const uint8_t **bytes) {
  if (!bytes) return -1;
  return mmcs::guarded(sim, int64_t{-1}, [=] { return given(sim->timeline.history(), bytes); });
}
int mmcs_sim_restore_bytes(mmcs_sim *sim, const uint8_t *snapshot, size_t snapshot_len,
                           const uint8_t *history, size_t history_len, char *err, size_t err_len) {
  std::string why = "no simulation given";
  if (sim) {
    try {
      why = sim->timeline.restore_bytes(snapshot, snapshot_len, history, history_len);
    } catch (const std::exception &problem) {
      why = problem.what();
    }
  }
  if (why.empty()) return 0;
  mmcs::tell(err, err_len, why);
  return -1;
}

}  // extern "C"
