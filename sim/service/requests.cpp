// SPDX-License-Identifier: Apache-2.0
// What requests of the messages do to a served machine (docs/use/protocol.md), for every carrier.
//
// Knows the C ABI and mcdef.h only.

#include <exception>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"
#include "served.h"

namespace {

constexpr int kProtocol = 1, kNoRequest = 25, kMostSnapshots = 100;
// --- what is done ---

class Request {
 public:
  Request(Served &server, Client &by, const char *flat)
      : server_(server), sim_(server.sim), by_(by), asked_(flat, 2 * mmcs_sim_build_cards()) {}

  Fields done(double now, bool only_check, const char *held) {
    static const std::map<std::string, Fields (Request::*)()> kDone = {
        {"hello", &Request::hello},       {"clients", &Request::clients},
        {"inputs", &Request::inputs},     {"name", &Request::name},
        {"open", &Request::open},         {"close", &Request::close},
        {"read", &Request::read},         {"write", &Request::write},
        {"setpoint", &Request::setpoint}, {"call", &Request::call},
        {"change", &Request::change},     {"load", &Request::load},
        {"store", &Request::store},       {"stop", &Request::stop},
        {"lease", &Request::lease},       {"input", &Request::input},
        {"pace", &Request::pace},         {"advance", &Request::advance},
        {"follow", &Request::follow},     {"unfollow", &Request::unfollow},
        {"ring", &Request::ring},         {"snapshot", &Request::snapshot},
        {"snapshots", &Request::listed},  {"drop", &Request::drop},
        {"rewind", &Request::rewind},     {"export", &Request::exported},
    };
    now_ = now;
    only_check_ = only_check;
    held_ = held;
    const auto found = kDone.find(asked_.op());
    return found == kDone.end() ? asked_.checked() : (this->*found->second)();
  }

 private:
  int whole_of(const char *name) { return static_cast<int>(asked_.get(name).number()); }
  int64_t number_of(const char *name) { return static_cast<int64_t>(asked_.get(name).number()); }
  bool flag_of(const char *name) { return asked_.get(name).text == "1"; }
  bool has_number(const char *name) { return asked_.has(name) && asked_.get(name).kind != 'n'; }
  Fields time() const { return fields("t", mmcs_sim_time(sim_)); }

  void must_be_open(bool writing) const {
    if (by_.driver >= 0 && (by_.writes || !writing)) return;
    throw Refusal(kBadFile,
                  std::string("the device is not open") + (writing ? " for writing" : ""));
  }
  void must_control() const {
    if (const char *held = mmcs_server_held(&server_, &by_)) throw Refusal(kBusy, held);
  }
  void must_write() const {
    if (!held_) return;
    must_control();
    throw Refusal(kBusy, held_);
  }
  // Refused with what the driver has said since the request began, or because of the lease.
  void check(int result) const {
    if (result >= 0) return;
    const std::string said = mmcs_server_said(&server_, before_);
    if (result == -kBusy && said.empty()) must_control();
    throw Refusal(-result, said);
  }

  // --- who is there ---

  Fields hello() {
    mmcs_stats stats{};
    mmcs_sim_get_stats(sim_, &stats);
    std::vector<std::string> names;
    for (const char *name : kState) names.push_back(quoted(name));
    for (const char *name : {"setpoint", "demand", "current"}) names.push_back(quoted(name));
    const Made sample = {object(
        fields("fields", Made{joined('[', names, ']')}, "row_bytes", tap_head(sim_).row_bytes))};
    const int cards = mmcs_sim_build_cards();
    const bool button = value_of(input_of("estop"), 0) != 0;
    return fields("protocol", kProtocol, "you", by_.number, "axes", 2 * cards, "cards", cards,
                  "time", mmcs_sim_time(sim_), "speed", speed(), "paused", server_.paused != 0,
                  "opens", server_.opens, "lease", holder(), "sample", sample, "enabled",
                  stats.enabled != 0, "stopped", stats.stopped != 0, "double_buffer",
                  stats.double_buffer != 0, "interval_us", stats.interval_us, "diag", stats.diag,
                  "panic", stats.panic_level != 0, "button", button);
  }
  Made speed() const { return {server_.speed > 0 ? real(server_.speed) : "null"}; }
  Made holder() const { return {server_.lease ? json(server_.lease->number) : "null"}; }

  Fields clients() {
    std::vector<std::string> rows;
    rows.reserve(server_.clients.size());
    for (const auto &[number, one] : server_.clients)
      rows.push_back(object(fields("client", number, "name", one->name, "pid", one->pid, "kind",
                                   one->kind, "mode",
                                   !one->device  ? ""
                                   : one->writes ? "rw"
                                                 : "r",
                                   "lease", one.get() == server_.lease)));
    return {{"clients", joined('[', rows, ']')}};
  }
  Fields name() {
    by_.name = asked_.get("name").text;
    return {};
  }
  Fields open() {
    const int flags = asked_.get("mode").text == "rw" ? kWriting : 0;
    check(mmcs_server_open(&server_, &by_, "/dev/mc0", flags, -1));
    return {};
  }
  Fields close() {
    if (server_.lease == &by_) server_.set_lease(nullptr);
    check(server_.close(by_));
    return {};
  }
  Fields stop() {
    check(mmcs_server_stop(&server_, by_.pid));
    return time();
  }
  Fields lease() {
    if (!asked_.has("give") && !asked_.has("drop")) asked_.get("take");
    asked_.checked();
    if (has_number("give")) {
      const auto other = server_.clients.find(whole_of("give"));
      if (server_.lease != &by_) throw Refusal(kBusy, "only the holder can pass the lease on");
      if (other == server_.clients.end() || !other->second->device || !other->second->writes)
        throw Refusal(kRefusedValue, "give: no such client has the device open for writing");
      server_.set_lease(other->second.get());
    } else if (asked_.has("drop") && flag_of("drop")) {
      if (server_.lease == &by_) server_.set_lease(nullptr);
    } else {
      must_control();
      if (!by_.device || !by_.writes) throw Refusal(kBadFile, "");
      const double ms = has_number("deadman_ms") ? asked_.get("deadman_ms").number() : 0;
      server_.set_lease(&by_, ms / 1000);
      by_.heard = now_;
    }
    return fields("lease", holder());
  }

  // --- the device ---

  Fields read() {
    must_be_open(false);
    const size_t axes = static_cast<size_t>(whole_of("axes"));
    std::vector<int> states(axes * std::size(kState));
    const int result = mmcs_sim_read(sim_, by_.driver, states.data(), axes * sizeof(mc_state));
    check(result);
    const size_t count = static_cast<size_t>(result) / sizeof(mc_state);
    std::vector<std::string> rows;
    rows.reserve(count);
    for (size_t n = 0; n < count; ++n)
      rows.push_back(wholes(&states[n * std::size(kState)], std::size(kState)));
    return {{"states", joined('[', rows, ']')}};
  }

  Fields write() {
    must_be_open(true);
    std::vector<int> setpoints;
    for (const auto &[_, one] : asked_.get("setpoints").of)
      setpoints.push_back(static_cast<int>(one.number()));
    must_write();
    check(mmcs_server_write(&server_, &by_, setpoints.data(), setpoints.size() * sizeof(int)));
    return {};
  }

  Fields setpoint() {
    must_be_open(true);
    mmcs_setpoint wanted = {whole_of("axis"), whole_of("value")};
    must_write();
    check(mmcs_server_ioctl(&server_, &by_, MSETPOINT, &wanted));
    return time();
  }

  Fields call() {
    must_be_open(false);
    const std::string wanted = asked_.get("request").text;
    const Driver *request = nullptr;
    for (const Driver &row : kDriver)
      if (wanted == row.name) request = &row;
    if (!request) throw Refusal(kNoRequest, "request: there is no " + wanted);
    const uint32_t code = request->code;
    const bool stops = code == MSTOP, whole = (code & 0x1FFF0000) == MC_INT;
    union {
      int value;
      mc_param param;
      mc_stats stats;
      unsigned char room[256];
    } argument = {};
    if (code & MC_ARG_IN) {
      const int64_t value = number_of(whole ? "value" : "axis");  // the first word of either
      argument.value = static_cast<int>(static_cast<uint32_t>(value));
      if (code == MSETPARAM) asked_.change(argument.param);
    }
    if (only_check_ && request->changes && !stops) must_be_open(true);
    if (only_check_) return asked_.checked();
    check(mmcs_server_ioctl(&server_, &by_, code, &argument));
    if (!(code & MC_ARG_OUT)) return {};
    if (whole) return {{"value", std::to_string(argument.value)}};
    if (code == MGETSTATS) return {{"stats", wholes(&argument.stats, std::size(kStats), kStats)}};
    return {{"param", wholes(&argument.param, kFieldCount, kParam)}};
  }

  // Some parameters of an axis; the others stay what they are at this moment.
  Fields change() {
    must_be_open(true);
    mc_param param{};
    param.which = whole_of("axis");
    asked_.get("param");
    if (only_check_) return asked_.checked();
    check(mmcs_sim_ioctl(sim_, by_.driver, MGETPARAM, &param));
    must_control();
    asked_.change(param);
    check(mmcs_sim_ioctl(sim_, by_.driver, MSETPARAM, &param));
    return {{"param", wholes(&param, kFieldCount, kParam)}};
  }

  static void bus(int result) {
    if (result) throw Refusal(kIo, result == 1 ? "bus time-out" : "bus error");
  }
  Fields load() {
    uint32_t value = 0;
    bus(mmcs_sim_bus_read(sim_, static_cast<uint32_t>(whole_of("offset")), kUserAm, 1, &value));
    return {{"value", std::to_string(value)}};
  }
  Fields store() {
    must_control();
    const uint32_t offset = static_cast<uint32_t>(whole_of("offset"));
    bus(mmcs_sim_bus_write(sim_, offset, kUserAm, 1, static_cast<uint32_t>(whole_of("value"))));
    return {};
  }

  // --- inputs and time ---

  double value_of(int number, int index) const {
    return mmcs_sim_input_value(sim_, number, index, mmcs_sim_time(sim_));
  }
  // Of each, what differs from healthy.
  Fields inputs() {
    static constexpr const char *kScopes[] = {"machine", "card", "axis"};
    std::vector<std::string> rows;
    const mmcs_input *is;
    for (int n = 0; (is = mmcs_sim_input(n)) != nullptr; ++n) {
      Fields values;
      for (int index = 0; index < places(*is); ++index)
        if (const double value = value_of(n, index); value != is->healthy)
          values.emplace_back(std::to_string(index), real(value));
      rows.push_back(object(fields("name", is->name, "scope", kScopes[is->scope], "healthy",
                                   is->healthy, "low", is->low, "high", is->high, "meaning",
                                   is->meaning, "values", Made{object(values)})));
    }
    return {{"inputs", joined('[', rows, ']')}};
  }

  Fields input() {
    const std::string wanted = asked_.get("name").text;
    const int number = input_of(wanted);
    const mmcs_input &is = *mmcs_sim_input(number);
    const double value = asked_.get({"", "value", Kind::kNumber, is.low, is.high}).number();
    const double index =
        asked_.get({"", "index", Kind::kWhole, 0, static_cast<double>(places(is) - 1), 0}).number();
    if (wanted != "estop" || value != 1) must_control();
    if (only_check_)
      return {{"name", quoted(wanted)}, {"index", whole(index)}, {"value", real(value)}};
    const mmcs_event event = {mmcs_sim_time(sim_), number, static_cast<int>(index), value};
    if (mmcs_sim_add_event(sim_, &event) != 0)
      throw Refusal(kRefusedValue, "index: nothing is connected there");
    mmcs_sim_run(sim_, event.t + 1.0 / mmcs_sim_build_clk_hz());  // a waiting request does, else
    return time();
  }

  Fields pace() {
    must_control();
    asked_.checked();
    if (asked_.has("speed")) server_.speed = has_number("speed") ? asked_.get("speed").number() : 0;
    if (asked_.has("paused")) server_.paused = flag_of("paused");
    const std::string pace =
        server_.speed > 0 ? printed("speed %g", server_.speed) : "as fast as it goes";
    server_.note("pace", 0, server_.paused ? "paused" : pace);
    return fields("speed", speed(), "paused", server_.paused != 0);
  }
  void must_stand() const {
    if (server_.target >= 0)
      throw Refusal(kBusy, "another client has asked for time to pass; wait for its end");
  }
  // The rest is the carrier's.
  Fields advance() {
    must_control();
    const double until = mmcs_sim_time(sim_) + asked_.get("seconds").number();
    if (!server_.paused) throw Refusal(kBusy, "time passes by itself; pause first");
    must_stand();
    server_.target = std::llround(until * mmcs_sim_build_clk_hz());
    return {};
  }
  Fields follow() {
    asked_.checked();
    const mmcs_tap_head head = tap_head(sim_);
    auto &f = by_.follows = {};
    f.samples = flag_of("samples");
    f.events = flag_of("events");
    f.every = whole_of("every");
    f.period_s = asked_.get("period_ms").number() / 1000;
    f.row = std::max<int64_t>(0, head.rows - number_of("past"));
    f.event = head.events;
    return {};
  }
  Fields unfollow() {
    by_.follows = {};
    return {};
  }

  // --- the past ---

  Fields ring() {
    must_control();
    const double every_s = asked_.get("every_s").number();
    mmcs_sim_ring(sim_, every_s, whole_of("count"));
    return {};
  }
  Fields snapshot() {
    int count = 0;
    for (const mmcs_snapshot &one : snapshots(sim_)) count += one.kept;
    if (count >= kMostSnapshots)
      throw Refusal(kBusy,
                    std::to_string(kMostSnapshots) + " snapshots are kept already; drop one");
    const int64_t id = mmcs_sim_snapshot(sim_, -1);
    if (id < 0) throw Refusal(kIo, "no snapshot: an assertion of the machine has failed");
    return fields("snapshot", Made{object(fields("id", id, "t", mmcs_sim_time(sim_)))});
  }
  Fields listed() {
    std::vector<std::string> rows;
    for (const mmcs_snapshot &one : snapshots(sim_))
      rows.push_back(object(fields("id", one.id, "t", one.t, "kept", one.kept != 0)));
    return {{"snapshots", joined('[', rows, ']')}};
  }
  Fields drop() {
    must_control();
    if (mmcs_sim_drop(sim_, number_of("snapshot")) != 0)
      throw Refusal(kRefusedValue, "snapshot: there is none of this number");
    return {};
  }
  Fields rewind() {
    must_control();
    const int64_t found = chosen(asked_.has("t"));
    must_stand();
    if (!server_.rewind(found)) throw Refusal(kIo, "the snapshot cannot be restored");
    return fields("snapshot", found, "t", mmcs_sim_time(sim_));
  }
  // Found only: the file is the carrier's.
  Fields exported() { return fields("snapshot", chosen(false)); }
  int64_t chosen(bool by_time) {
    const double wanted = asked_.get(by_time ? "t" : "snapshot").number();
    int64_t found = -1;
    for (const mmcs_snapshot &one : snapshots(sim_))
      if (by_time ? one.t <= wanted + 1e-9 : static_cast<double>(one.id) == wanted) found = one.id;
    if (found < 0) throw Refusal(kRefusedValue, "snapshot: there is none of this number or time");
    return found;
  }

  Served &server_;
  mmcs_sim *sim_;
  Client &by_;
  Asked asked_;
  int64_t before_ = tap_head(sim_).events;
  double now_ = 0;
  bool only_check_ = false;
  const char *held_ = nullptr;
};

}  // namespace

extern "C" {

const char *mmcs_server_request(mmcs_server *server, mmcs_client *client, double now,
                                const char *asked, int only_check, const char *held) {
  static thread_local std::string reply;
  std::string made;
  try {
    auto &my = *static_cast<Served *>(server);
    made = object(Request(my, my.of(client), asked).done(now, only_check != 0, held));
  } catch (const Refusal &no) {
    made = object({{"errno", std::to_string(no.error)}, {"text", quoted(no.what())}});
  } catch (const std::exception &problem) {
    made = object({{"errno", std::to_string(kIo)}, {"text", quoted(problem.what())}});
  }
  reply = made;
  return reply.c_str();
}

}  // extern "C"
