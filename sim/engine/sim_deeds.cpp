// SPDX-License-Identifier: Apache-2.0
// The C ABI of mmcs_sim.h: what acts on the machine, how the same is done to another, time travel.

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include "sim.h"

namespace {

constexpr uint32_t kWindow = 0x6000;
constexpr uint32_t kWindowSize = 0x800;
constexpr size_t kMostArgument = 256;  // bytes of a request's argument, at least
constexpr size_t kMostDeeds = 100'000;

bool valid_size(int bytes) {
  return bytes == 1 || bytes == 2 || bytes == 4;
}

// Number of the first deed that is kept.
int64_t first_deed(const mmcs_sim *sim) {
  return sim->timeline.deeds - static_cast<int64_t>(sim->deeds.size());
}

// Counts one more; whether it is to be kept. Those that no snapshot needs are forgotten, and of too
// many all.
bool count_deed(mmcs_sim *sim) {
  const auto &kept = sim->timeline.list();
  const int64_t needed = kept.empty() ? sim->timeline.deeds : kept.front().deeds;
  while (first_deed(sim) < needed) sim->deeds.pop_front();
  if (sim->deeds.size() >= kMostDeeds) sim->deeds.clear();
  ++sim->timeline.deeds;
  return sim->keeps_deeds;
}

// Does f and keeps how.
template <typename F>
int deed(mmcs_sim *sim, int failure, F f) {
  return mmcs::guarded(sim, failure, [&] {
    if (count_deed(sim)) sim->deeds.push_back({sim->machine.clock(), f});
    return f(sim);
  });
}

// The same of what takes or fills so many bytes: it is kept with a copy of them.
template <typename F>
int deed(mmcs_sim *sim, int failure, void *data, size_t length, F f) {
  return mmcs::guarded(sim, failure, [&] {
    if (count_deed(sim)) {
      std::vector<char> copy(std::max(length, kMostArgument));
      if (data) std::copy_n(static_cast<const char *>(data), length, copy.begin());
      const auto again = [f, copy](mmcs_sim *s) {
        std::vector<char> given = copy;
        f(s, given.data());
      };
      sim->deeds.push_back({sim->machine.clock(), again});
    }
    return f(sim, data);
  });
}

// Does with another machine the deeds from number `first` on that are later than the clock `after`.
int repeat(mmcs_sim *other, const mmcs_sim *sim, int64_t first, int64_t after, int64_t clock) {
  int64_t n = first_deed(sim);
  for (const mmcs_deed &deed : sim->deeds) {
    if (n++ < first || deed.clock <= after) continue;
    if (deed.clock > clock) break;
    if (!other->timeline.run_until(deed.clock)) return -1;
    deed.again(other);
  }
  return other->timeline.run_until(clock) ? 0 : -1;
}

bool put(mmcs_sim *other, mmcs_sim *sim, int64_t id) {
  const mmcs::Bytes *state = sim->timeline.bytes(id), *past = sim->timeline.history();
  return state &&
         other->timeline.restore_bytes(state->data(), state->size(), past->data(), past->size())
             .empty();
}

// The snapshots since which every deed is kept are the last ones from here on.
std::vector<mmcs_snapshot>::const_iterator first_known(const mmcs_sim *sim) {
  const auto &all = sim->timeline.list();
  return std::find_if(all.begin(), all.end(),
                      [=](const mmcs_snapshot &one) { return one.deeds >= first_deed(sim); });
}

int64_t given(const mmcs::Bytes *bytes, const uint8_t **data) {
  if (!bytes) return -1;
  *data = bytes->data();
  return static_cast<int64_t>(bytes->size());
}

}  // namespace

extern "C" {

int mmcs_sim_open(mmcs_sim *sim, int flags) {
  return deed(sim, -MC_ENXIO, [=](mmcs_sim *s) { return s->host.open(flags); });
}
int mmcs_sim_close(mmcs_sim *sim, int client) {
  return deed(sim, -MC_EBADF, [=](mmcs_sim *s) { return s->host.close(client); });
}
int mmcs_sim_ioctl(mmcs_sim *sim, int client, uint32_t request, void *arg) {
  return deed(sim, -MC_EBADF, arg, request >> 16 & 0x1FFF,
              [=](mmcs_sim *s, void *given) { return s->host.ioctl(client, request, given); });
}
int mmcs_sim_read(mmcs_sim *sim, int client, void *buf, size_t len) {
  return deed(sim, -MC_EBADF, buf, len,
              [=](mmcs_sim *s, void *into) { return s->host.read(client, into, len); });
}
int mmcs_sim_write(mmcs_sim *sim, int client, const void *buf, size_t len) {
  return deed(sim, -MC_EBADF, const_cast<void *>(buf), len,
              [=](mmcs_sim *s, void *from) { return s->host.write(client, from, len); });
}
int mmcs_sim_stop(mmcs_sim *sim) {
  return deed(sim, -MC_EIO, [](mmcs_sim *s) { return s->host.stop(); });
}
int mmcs_sim_set_look(mmcs_sim *sim, mmcs_look look, void *ctx) {
  if (!sim) return -1;
  sim->host.set_look(look, ctx);
  return 0;
}
int mmcs_sim_signals(mmcs_sim *sim, int client) {
  return deed(sim, 0, [=](mmcs_sim *s) { return s->host.take_signals(client); });
}

int mmcs_sim_bus_read(mmcs_sim *sim, uint32_t offset, int am, int size, uint32_t *value) {
  if (!value || !valid_size(size)) return -1;
  return deed(sim, -1, value, sizeof *value, [=](mmcs_sim *s, void *into) {
    const mmcs::BusResult result =
        s->bus.read(kWindow + offset % kWindowSize, static_cast<unsigned>(am), size,
                    static_cast<uint32_t *>(into));
    s->host.after_access();
    return static_cast<int>(result);
  });
}
int mmcs_sim_bus_write(mmcs_sim *sim, uint32_t offset, int am, int size, uint32_t value) {
  if (!valid_size(size)) return -1;
  return deed(sim, -1, [=](mmcs_sim *s) {
    const mmcs::BusResult result =
        s->bus.write(kWindow + offset % kWindowSize, static_cast<unsigned>(am), size, value);
    s->host.after_access();
    return static_cast<int>(result);
  });
}

int mmcs_sim_add_segment(mmcs_sim *sim, const mmcs_segment *segment, const double *numbers) {
  if (!segment) return -1;
  return mmcs::guarded(sim, -1, [=] {
    std::vector<double> table;
    if (numbers && segment->table_at >= 0 && segment->table_len > 0)
      table.assign(numbers + segment->table_at, numbers + segment->table_at + segment->table_len);
    return deed(sim, -1, [one = *segment, table](mmcs_sim *s) {
      return s->host.motion().add(one, table.empty() ? nullptr : table.data()) ? 0 : -1;
    });
  });
}
int mmcs_sim_start_motion(mmcs_sim *sim, int client) {
  if (client < 0 || client >= MC_MAX_CLIENTS) return -MC_EBADF;
  return deed(sim, -MC_EBADF, [=](mmcs_sim *s) {
    s->host.start_motion(client);
    return 0;
  });
}

int mmcs_sim_add_event(mmcs_sim *sim, const mmcs_event *event) {
  if (!event) return -1;
  return deed(sim, -1, [one = *event](mmcs_sim *s) {
    const std::string why =
        mmcs::is_time(one.t) ? s->machine.check_event(one) : "its time is impossible";
    if (why.empty()) {
      s->machine.add_event(one);
      return 0;
    }
    s->machine.note("log", -1, "event refused: " + why);
    return -1;
  });
}

void mmcs_sim_keep_deeds(mmcs_sim *sim) {
  if (sim) sim->keeps_deeds = true;
}
int64_t mmcs_sim_known(const mmcs_sim *sim) {
  if (!sim) return -1;
  const auto first = first_known(sim);
  return first == sim->timeline.list().end() ? sim->machine.clock() : first->clock;
}
int mmcs_sim_copy(mmcs_sim *other, mmcs_sim *sim) {
  if (!mmcs::rests(sim) || !mmcs::rests(other)) return -1;
  return mmcs::guarded(sim, -1, [=] {
    const int64_t now = sim->timeline.take();
    const bool good = put(other, sim, now);
    sim->timeline.drop(now);
    return good ? 0 : -1;
  });
}
int mmcs_sim_again(mmcs_sim *other, mmcs_sim *sim, int64_t clock) {
  if (!sim || !mmcs::rests(other)) return -1;
  return mmcs::guarded(other, -1, [=] {
    const auto known = first_known(sim), end = sim->timeline.list().end();
    const auto next = std::find_if(known, end, [=](const auto &one) { return one.clock > clock; });
    if (next == known || !put(other, sim, next[-1].id)) return -1;
    return repeat(other, sim, next[-1].deeds, -1, clock);
  });
}
int mmcs_sim_repeat(mmcs_sim *other, const mmcs_sim *sim, int64_t after, int64_t clock) {
  if (!sim || !mmcs::rests(other)) return -1;
  return mmcs::guarded(other, -1, [=] { return repeat(other, sim, 0, after, clock); });
}

int64_t mmcs_sim_snapshot(mmcs_sim *sim, double t) {
  if (!mmcs::is_time(t) || !mmcs::rests(sim)) return -1;
  return mmcs::guarded(sim, int64_t{-1}, [=] {
    return t < 0 ? sim->timeline.take() : sim->timeline.take_at(sim->machine.clocks(t));
  });
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
