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

template <typename F>
void keep(mmcs_sim *sim, F again) {
  if (sim && sim->keeps_deeds) sim->deeds.push_back({sim->machine.clock(), again});
}

// Does f and keeps it.
template <typename F>
int deed(mmcs_sim *sim, int failure, F f) {
  keep(sim, f);
  return mmcs::guarded(sim, failure, [=] { return f(sim); });
}

std::vector<char> copied(const void *from, size_t length) {
  const char *bytes = static_cast<const char *>(from);
  return bytes ? std::vector<char>(bytes, bytes + length) : std::vector<char>();
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
  if (sim && sim->keeps_deeds) {
    const size_t length = request >> 16 & 0x1FFF;
    keep(sim, [=, bytes = copied(arg, length)](mmcs_sim *s) {
      std::vector<char> given = bytes;
      given.resize(std::max(length, kMostArgument));
      s->host.ioctl(client, request, given.data());
    });
  }
  return mmcs::guarded(sim, -MC_EBADF, [=] { return sim->host.ioctl(client, request, arg); });
}
int mmcs_sim_read(mmcs_sim *sim, int client, void *buf, size_t len) {
  keep(sim, [=](mmcs_sim *s) {
    std::vector<char> into(len);
    s->host.read(client, into.data(), len);
  });
  return mmcs::guarded(sim, -MC_EBADF, [=] { return sim->host.read(client, buf, len); });
}
int mmcs_sim_write(mmcs_sim *sim, int client, const void *buf, size_t len) {
  if (sim && sim->keeps_deeds)
    keep(sim, [=, bytes = copied(buf, len)](mmcs_sim *s) { s->host.write(client, bytes.data(), len); });
  return mmcs::guarded(sim, -MC_EBADF, [=] { return sim->host.write(client, buf, len); });
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
  const auto read = [=](mmcs_sim *s, uint32_t *into) {
    return static_cast<int>(
        s->bus.read(kWindow + offset % kWindowSize, static_cast<unsigned>(am), size, into));
  };
  keep(sim, [=](mmcs_sim *s) {
    uint32_t unused;
    read(s, &unused);
  });
  return mmcs::guarded(sim, -1, [=] { return read(sim, value); });
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
  if (sim && sim->keeps_deeds) {
    std::vector<double> table;
    if (segment->table) table.assign(segment->table, segment->table + segment->table_len);
    keep(sim, [one = *segment, table](mmcs_sim *s) {
      mmcs_segment given = one;
      given.table = table.data();
      s->host.motion().add(given);
    });
  }
  return mmcs::guarded(sim, -1, [=] {
    const std::string why = sim->host.motion().add(*segment);
    if (why.empty()) return 0;
    sim->machine.note("log", segment->axis, "motion refused: " + why);
    return -1;
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
