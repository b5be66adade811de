// SPDX-License-Identifier: Apache-2.0
// The C ABI of mmcs_sim.h: what acts on the machine, and how the same is done to another.

#include <algorithm>
#include <string>
#include <vector>

#include "sim.h"

namespace {

constexpr uint32_t kWindow = 0x6000;
constexpr uint32_t kWindowSize = 0x800;
constexpr size_t kMostArgument = 256;  // bytes of a request's argument, at least

bool valid_size(int bytes) {
  return bytes == 1 || bytes == 2 || bytes == 4;
}

// Does f and keeps how.
template <typename F>
int deed(mmcs_sim *sim, int failure, F f) {
  return mmcs::guarded(sim, failure, [&] {
    if (sim->keeps_deeds) sim->deeds.push_back({sim->machine.clock(), f});
    return f(sim);
  });
}

// The same of what takes or fills so many bytes: it is kept with a copy of them.
template <typename F>
int deed(mmcs_sim *sim, int failure, void *data, size_t length, F f) {
  return mmcs::guarded(sim, failure, [&] {
    if (sim->keeps_deeds) {
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
    return static_cast<int>(s->bus.read(kWindow + offset % kWindowSize, static_cast<unsigned>(am),
                                        size, static_cast<uint32_t *>(into)));
  });
}
int mmcs_sim_bus_write(mmcs_sim *sim, uint32_t offset, int am, int size, uint32_t value) {
  if (!valid_size(size)) return -1;
  return deed(sim, -1, [=](mmcs_sim *s) {
    return static_cast<int>(
        s->bus.write(kWindow + offset % kWindowSize, static_cast<unsigned>(am), size, value));
  });
}

int mmcs_sim_add_segment(mmcs_sim *sim, const mmcs_segment *segment) {
  if (!segment) return -1;
  return mmcs::guarded(sim, -1, [=] {
    std::vector<double> table;
    if (segment->table && segment->table_len > 0)
      table.assign(segment->table, segment->table + segment->table_len);
    return deed(sim, -1, [one = *segment, table](mmcs_sim *s) {
      mmcs_segment given = one;
      given.table = table.empty() ? nullptr : table.data();
      const std::string why = s->host.motion().add(given);
      if (why.empty()) return 0;
      s->machine.note("log", one.axis, "motion refused: " + why);
      return -1;
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

int64_t mmcs_sim_deeds(mmcs_sim *sim) {
  if (!sim) return 0;
  sim->keeps_deeds = true;
  return sim->first_deed + static_cast<int64_t>(sim->deeds.size());
}
void mmcs_sim_keep_deeds(mmcs_sim *sim, int64_t first, int64_t end) {
  if (!sim) return;
  const auto at = [sim](int64_t n) {
    const auto most = static_cast<int64_t>(sim->deeds.size());
    return sim->deeds.begin() + std::clamp(n - sim->first_deed, int64_t{0}, most);
  };
  sim->deeds.erase(at(end), sim->deeds.end());
  sim->deeds.erase(sim->deeds.begin(), at(first));
  sim->first_deed = std::max(first, sim->first_deed);
}
int mmcs_sim_repeat(mmcs_sim *other, const mmcs_sim *sim, int64_t first, int64_t after,
                    int64_t clock) {
  if (!sim || !mmcs::rests(other)) return -1;
  return mmcs::guarded(other, -1, [=] {
    int64_t n = sim->first_deed;
    for (const mmcs_deed &deed : sim->deeds) {
      if (n++ < first || deed.clock <= after) continue;
      if (deed.clock > clock) break;
      if (!other->timeline.run_until(deed.clock)) return -1;
      deed.again(other);
    }
    return other->timeline.run_until(clock) ? 0 : -1;
  });
}

}  // extern "C"
