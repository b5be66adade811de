// SPDX-License-Identifier: Apache-2.0
// Who uses a served machine, for every carrier: clients, lease and dead-man, the stream, the way
// back. Included once.
#pragma once

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "asked.h"
#include "mcdef.h"
#include "mmcs_regs.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"
#include "sys/mmcs.h"

namespace {

constexpr int kIo = 5, kNoDevice = 6, kBadFile = 9, kBusy = 16;
constexpr int kRows = 8192, kEvents = 4096;  // that the tap keeps
constexpr int kRowsAtOnce = 512, kEventsAtOnce = 256;
constexpr double kSnapshotEveryS = 0.1;  // the ring at the start
constexpr int kSnapshots = 100;
constexpr int kAccess = 3, kWriting = 2;  // of the flags of open(2)
constexpr int kUserAm = 0x29;             // mapped accesses are non-privileged (§2.4)
constexpr int kBusTimeout = 1, kBusError = 2;
constexpr double kBusTimeoutS = 16e-6;

struct Driver {  // a row of requests.def
  const char *name;
  uint32_t code;
  bool changes;
};
constexpr Driver kDriver[] = {
#define REQUEST(name, number, argument, way, serve, changes, ...) {#name, name, changes != 0},
#include "requests.def"
};

std::vector<mmcs_snapshot> snapshots(mmcs_sim *sim) {
  const mmcs_snapshot *list = nullptr;
  const int count = mmcs_sim_snapshots(sim, &list);
  std::vector<mmcs_snapshot> made;
  made.assign(list, list + count);
  return made;
}

mmcs_tap_head tap_head(const mmcs_sim *sim) {
  mmcs_tap_head now{};
  mmcs_sim_tap_head(sim, &now);
  return now;
}

int places(const mmcs_input &is) {
  const int cards = mmcs_sim_build_cards();
  return is.scope == MMCS_SCOPE_MACHINE ? 1 : is.scope == MMCS_SCOPE_CARD ? cards : 2 * cards;
}
int input_of(const std::string &name) {
  const mmcs_input *is;
  for (int n = 0; (is = mmcs_sim_input(n)) != nullptr; ++n)
    if (name == is->name) return n;
  throw Refusal(kRefusedValue, "name: there is no input '" + name + "'");
}

}  // namespace

struct Client : mmcs_client {
  Client(int of_number, const char *is, const char *called, int of_pid)
      : mmcs_client{0, of_number, of_pid, MMCS_CLOSED, -1, 0, 0}, kind(is), name(called) {}
  std::string kind, name;
  double deadman_s = 0;  // silence that ends the lease; 0: none
  struct {
    bool samples = false, events = false, behind = false;  // behind: rows are due
    int every = 1;
    double period_s = 0, due = 0;
    int64_t row = 0, event = 0, lost = 0;
    std::deque<std::string> told;
  } follows;
  std::string message;  // the last of the stream

  std::string who() const {
    return "client " + std::to_string(number) + (name.empty() ? "" : " (" + name + ")");
  }
};

struct Served : mmcs_server {
  mmcs_sim *sim;
  std::map<int, std::unique_ptr<Client>> clients;
  Client *lease = nullptr;
  Client nobody{0, "", "", 0};
  int numbers = 0;
  std::string why;  // the last answer of mmcs_server_held()
  // Who has the device open in snapshots from a number on: the client's number, the driver's.
  std::map<int64_t, std::map<int, int>> opened;
  int64_t next = 0;  // the number that the next snapshot will have, or less

  explicit Served(mmcs_sim *of) : mmcs_server{0, 0, 0, 0, -1}, sim(of) {}
  Client &of(mmcs_client *client) { return client ? *static_cast<Client *>(client) : nobody; }

  void note(const char *kind, int value, const std::string &text) const {
    mmcs_sim_tap_note(sim, kind, -1, value, text.c_str());
  }

  int close(Client &client) {
    if (!client.device) return -kBadFile;
    if (client.driver >= 0) mmcs_sim_close(sim, client.driver);
    const char *what = client.device == MMCS_MC ? "/dev/mc0" : "/dev/vme16";
    note("client", client.number, client.who() + " has closed " + what);
    client.device = MMCS_CLOSED;
    client.driver = -1;
    opens_changed();
    return 0;
  }

  void set_lease(Client *client, double deadman_s = 0) {
    if (lease) lease->deadman_s = 0;
    lease = client;
    if (client) client->deadman_s = deadman_s;
    note("lease", client ? client->number : -1,
         (client ? client->who() : "nobody") + " has the lease");
  }

  // A snapshot holds the machine and its driver, and no client: those that have the device open now
  // have it open then, and what others had is closed.
  bool rewind(int64_t number) {
    if (mmcs_sim_restore(sim, number) != 0) return false;
    next = std::max(next, number + 1);
    opened.erase(opened.upper_bound(number), opened.end());
    std::map<int, int> had;
    if (!opened.empty()) had = opened.rbegin()->second;
    for (auto &[who, client] : clients) {
      if (client->device != MMCS_MC) continue;
      const auto then = had.find(who);
      client->driver = then == had.end() ? -1 : then->second;
      if (then != had.end()) had.erase(then);
    }
    for (auto &[_, client] : clients)
      if (client->device == MMCS_MC && client->driver < 0)
        client->driver = std::max(-1, mmcs_sim_open(sim, client->flags & kAccess));
    for (const auto &[_, driver] : had) mmcs_sim_close(sim, driver);
    note("rewind", static_cast<int>(number), "back to snapshot " + std::to_string(number));
    opens_changed();
    return true;
  }

  void opens_changed() {
    const std::vector<mmcs_snapshot> kept = snapshots(sim);
    if (!kept.empty()) next = std::max(next, kept.back().id + 1);
    const int64_t oldest = kept.empty() ? next : kept.front().id;
    std::map<int, int> now;
    opens = 0;
    for (const auto &[number, client] : clients) {
      opens += client->device != MMCS_CLOSED;
      if (client->driver >= 0) now[number] = client->driver;
    }
    opened[next] = now;
    while (opened.size() > 1 && std::next(opened.begin())->first <= oldest)
      opened.erase(opened.begin());
  }
};

namespace {

void tell_events(mmcs_sim *sim, Client &client) {
  auto &f = client.follows;
  std::vector<mmcs_tap_event> events(kEventsAtOnce);
  mmcs_tap_read read{};
  mmcs_sim_tap_events(sim, f.event, events.data(), kEventsAtOnce, &read);
  f.event = read.next;
  if (read.lost) f.told.push_back(object(fields("type", "lost", "events", read.lost)));
  events.resize(static_cast<size_t>(read.count));
  for (const mmcs_tap_event &e : events)
    f.told.push_back(object(fields("type", "event", "n", e.n, "t", e.t, "kind", e.kind, "axis",
                                   e.axis, "value", e.value, "text", e.text)));
}

void take_rows(mmcs_sim *sim, Client &client) {
  auto &f = client.follows;
  const int row_bytes = tap_head(sim).row_bytes, cards = mmcs_sim_build_cards();
  const auto size = static_cast<size_t>(row_bytes);
  std::vector<uint8_t> rows(kRowsAtOnce * size);
  mmcs_tap_read read{};
  mmcs_sim_tap_rows(sim, f.row, f.every, rows.data(), kRowsAtOnce, &read);
  f.row = read.next;
  f.lost += read.lost;
  f.behind = read.count > 0;
  if (!f.behind) return;
  client.message.assign("S1\0\0", 4);
  const auto put = [&](auto value) {
    client.message.append(reinterpret_cast<const char *>(&value), sizeof value);
  };
  put(read.count);
  put(row_bytes);
  put(static_cast<uint16_t>(2 * cards));
  put(static_cast<uint16_t>(cards));
  put(static_cast<double>(f.lost));
  put(static_cast<double>(f.row - int64_t{read.count} * f.every));
  client.message.append(reinterpret_cast<const char *>(rows.data()),
                        static_cast<size_t>(read.count) * size);
}

}  // namespace

extern "C" {

mmcs_server *mmcs_server_create(mmcs_sim *sim) {
  mmcs_sim_tap(sim, kRows, kEvents);
  mmcs_sim_ring(sim, kSnapshotEveryS, kSnapshots);
  return new Served(sim);
}

void mmcs_server_destroy(mmcs_server *server) {
  delete static_cast<Served *>(server);
}

mmcs_client *mmcs_server_enter(mmcs_server *server, const char *kind, const char *name, int pid) {
  auto &my = *static_cast<Served *>(server);
  const int number = ++my.numbers;
  return (my.clients[number] = std::make_unique<Client>(number, kind, name, pid)).get();
}

void mmcs_server_leave(mmcs_server *server, mmcs_client *client) {
  auto &my = *static_cast<Served *>(server);
  if (my.lease == client) {  // nobody is left in control by a dead man
    if (my.lease->deadman_s > 0) mmcs_server_stop(server, 0);
    my.set_lease(nullptr);
  }
  my.close(my.of(client));
  my.clients.erase(client->number);
}

int mmcs_server_open(mmcs_server *server, mmcs_client *client, const char *device, int flags,
                     int opened) {
  auto &my = *static_cast<Served *>(server);
  const bool motors = std::string("/dev/mc0") == device, writes = (flags & kAccess) != 0;
  if (client->device) return -kBusy;
  if (!motors && std::string("/dev/vme16") != device) return -kNoDevice;
  if (motors && opened < 0) opened = mmcs_sim_open(my.sim, flags & kAccess);
  if (motors && opened < 0) return opened;
  *client = {client->heard, client->number, client->pid, motors ? MMCS_MC : MMCS_VME,
             opened,        flags,          writes};
  my.opens_changed();
  my.note("client", client->number,
          my.of(client).who() + " has " + device + " open for " + (writes ? "writing" : "reading"));
  return 0;
}

const char *mmcs_server_held(mmcs_server *server, const mmcs_client *client) {
  auto &my = *static_cast<Served *>(server);
  if (!my.lease || my.lease == client || client == &my.nobody) return nullptr;
  my.why = my.lease->who() + " has the lease";
  return my.why.c_str();
}

int mmcs_server_stop(mmcs_server *server, int pid) {
  server->stopped_by = pid;
  return mmcs_sim_stop(static_cast<Served *>(server)->sim);
}

int mmcs_server_ioctl(mmcs_server *server, mmcs_client *client, uint32_t request, void *argument) {
  auto &my = *static_cast<Served *>(server);
  bool changes = request != MSTOP;
  for (const Driver &row : kDriver) changes = changes && (row.code != request || row.changes);
  if (request == MSTOP && !client->writes) return mmcs_server_stop(server, client->pid);
  if (changes && mmcs_server_held(server, client)) return -kBusy;
  const int result = mmcs_sim_ioctl(my.sim, client->driver, request, argument);
  if (request == MSTOP && result >= 0) server->stopped_by = client->pid;
  return result;
}

int mmcs_server_write(mmcs_server *server, mmcs_client *client, const void *data, size_t size) {
  if (mmcs_server_held(server, client)) return -kBusy;
  return mmcs_sim_write(static_cast<Served *>(server)->sim, client->driver, data, size);
}

int mmcs_server_bus(mmcs_server *server, mmcs_client *client, uint64_t address, int size,
                    int writes, uint32_t *value) {
  mmcs_sim *sim = static_cast<Served *>(server)->sim;
  if (writes && !client->writes) return kBusTimeout;
  if (writes && mmcs_server_held(server, client)) return kBusError;
  const uint64_t offset = address - MMCS_WINDOW_BASE;
  if (offset >= MMCS_WINDOW_SIZE) {
    mmcs_sim_run(sim, mmcs_sim_time(sim) + kBusTimeoutS);
    return kBusTimeout;
  }
  const auto at = static_cast<uint32_t>(offset);
  const int result = writes ? mmcs_sim_bus_write(sim, at, kUserAm, size, *value)
                            : mmcs_sim_bus_read(sim, at, kUserAm, size, value);
  return result < 0 ? kBusError : result;  // of a machine that has failed
}

const char *mmcs_server_said(const mmcs_server *server, int64_t event) {
  static thread_local std::string said;
  std::vector<mmcs_tap_event> events(kEventsAtOnce);
  mmcs_tap_read read{};
  mmcs_sim_tap_events(static_cast<const Served *>(server)->sim, event, events.data(), kEventsAtOnce,
                      &read);
  said.clear();
  for (int n = 0; n < read.count; ++n) {
    if (std::strcmp(events[n].kind, "log") != 0) continue;
    const char *text = events[n].text;
    said +=
        (said.empty() ? "" : "; ") + std::string(text + (std::strncmp(text, "mc: ", 4) ? 0 : 4));
  }
  return said.c_str();
}

int mmcs_server_check(mmcs_server *server, double now) {
  auto &my = *static_cast<Served *>(server);
  if (!my.lease || my.lease->deadman_s <= 0 || now - my.lease->heard <= my.lease->deadman_s)
    return 0;
  my.note("log", 0, my.lease->who() + " is silent: stopped");
  mmcs_server_stop(server, 0);
  my.set_lease(nullptr);
  return 1;
}

int64_t mmcs_server_stream(mmcs_server *server, mmcs_client *client, double now,
                           const uint8_t **message) {
  auto &my = *static_cast<Served *>(server);
  Client &to = my.of(client);
  auto &f = to.follows;
  if (now >= f.due && f.told.empty() && !f.behind) {
    f.due = now + f.period_s;
    f.behind = f.samples;
    if (f.events) tell_events(my.sim, to);
  }
  to.message.clear();
  if (!f.told.empty()) {
    to.message = f.told.front();
    f.told.pop_front();
  } else if (f.behind) {
    take_rows(my.sim, to);
  }
  *message = reinterpret_cast<const uint8_t *>(to.message.data());
  return static_cast<int64_t>(to.message.size());
}

}  // extern "C"
