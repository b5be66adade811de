// SPDX-License-Identifier: Apache-2.0
// What requests of the messages do to the machine (docs/use/protocol.md), for every carrier.
//
// Knows the C ABI and mcdef.h only.

#include <cstring>
#include <exception>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "asked.h"
#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"
#include "sys/mmcs.h"

namespace {

constexpr int kIo = 5, kBadFile = 9, kBusy = 16, kNoRequest = 25;
constexpr int kMostSnapshots = 100, kEventsAtOnce = 256, kUserAm = 0x29;
struct Driver {  // a row of requests.def
  const char *name;
  uint32_t code;
  bool changes;
};
constexpr Driver kDriver[] = {
#define REQUEST(name, number, argument, way, serve, changes, ...) {#name, name, changes != 0},
#include "requests.def"
};

// --- what is done ---

class Request {
 public:
  Request(mmcs_sim *sim, const mmcs_asker &by, const char *flat)
      : sim_(sim), by_(by), asked_(flat, 2 * mmcs_sim_build_cards()), before_(head().events) {}

  Fields done() {
    static const std::map<std::string, Fields (Request::*)()> kDone = {
        {"read", &Request::read},           {"write", &Request::write},
        {"setpoint", &Request::setpoint},   {"call", &Request::call},
        {"change", &Request::change},       {"load", &Request::load},
        {"store", &Request::store},         {"input", &Request::input},
        {"ring", &Request::ring},           {"snapshot", &Request::snapshot},
        {"snapshots", &Request::snapshots}, {"drop", &Request::drop},
        {"rewind", &Request::rewind},       {"export", &Request::exported},
    };
    const std::string &op = asked_.op();
    if (const auto found = kDone.find(op); found != kDone.end()) return (this->*found->second)();
    if (op == "pace" || op == "advance") must_control();
    if (op == "lease" && !asked_.has("give") && !asked_.has("drop")) asked_.get("take");
    return asked_.checked();
  }

 private:
  mmcs_tap_head head() const {
    mmcs_tap_head now{};
    mmcs_sim_tap_head(sim_, &now);
    return now;
  }
  int whole_of(const char *name) { return static_cast<int>(asked_.get(name).number()); }
  int64_t number_of(const char *name) { return static_cast<int64_t>(asked_.get(name).number()); }
  Fields time() const { return {{"t", real(mmcs_sim_time(sim_))}}; }

  void must_be_open(bool writing) const {
    if (by_.client >= 0 && (by_.writes || !writing)) return;
    throw Refusal(kBadFile,
                  std::string("the device is not open") + (writing ? " for writing" : ""));
  }
  void must_control() const {
    if (by_.held) throw Refusal(kBusy, by_.held);
  }
  // Refused with what the driver has said since the request began.
  void check(int result) const {
    if (result >= 0) return;
    std::vector<mmcs_tap_event> events(kEventsAtOnce);
    mmcs_tap_read read{};
    mmcs_sim_tap_events(sim_, before_, events.data(), kEventsAtOnce, &read);
    std::string said;
    for (int n = 0; n < read.count; ++n) {
      if (std::strcmp(events[n].kind, "log") != 0) continue;
      const char *text = events[n].text;
      said +=
          (said.empty() ? "" : "; ") + std::string(text + (std::strncmp(text, "mc: ", 4) ? 0 : 4));
    }
    throw Refusal(-result, said);
  }

  // --- the device ---

  Fields read() {
    must_be_open(false);
    const size_t axes = static_cast<size_t>(whole_of("axes"));
    constexpr size_t kState = sizeof(mc_state) / sizeof(int);
    std::vector<int> states(axes * kState);
    const int result = mmcs_sim_read(sim_, by_.client, states.data(), axes * sizeof(mc_state));
    check(result);
    const size_t count = static_cast<size_t>(result) / sizeof(mc_state);
    std::vector<std::string> rows;
    rows.reserve(count);
    for (size_t n = 0; n < count; ++n) rows.push_back(wholes(&states[n * kState], kState));
    return {{"states", joined('[', rows, ']')}};
  }

  Fields write() {
    must_be_open(true);
    std::vector<int> setpoints;
    for (const auto &[_, one] : asked_.get("setpoints").of)
      setpoints.push_back(static_cast<int>(one.number()));
    must_control();
    check(mmcs_sim_write(sim_, by_.client, setpoints.data(), setpoints.size() * sizeof(int)));
    return {};
  }

  Fields setpoint() {
    must_be_open(true);
    mmcs_setpoint wanted = {whole_of("axis"), whole_of("value")};
    must_control();
    check(mmcs_sim_ioctl(sim_, by_.client, MSETPOINT, &wanted));
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
    if (by_.only_check && request->changes && !stops) must_be_open(true);
    if (by_.only_check) return asked_.checked();
    if (request->changes && !stops) must_control();
    check(stops && !by_.writes ? mmcs_sim_stop(sim_)
                               : mmcs_sim_ioctl(sim_, by_.client, code, &argument));
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
    if (by_.only_check) return asked_.checked();
    check(mmcs_sim_ioctl(sim_, by_.client, MGETPARAM, &param));
    must_control();
    asked_.change(param);
    check(mmcs_sim_ioctl(sim_, by_.client, MSETPARAM, &param));
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

  Fields input() {
    const std::string wanted = asked_.get("name").text;
    int number = 0;
    const mmcs_input *is = mmcs_sim_input(number);
    while (is && wanted != is->name) is = mmcs_sim_input(++number);
    if (!is) throw Refusal(kRefusedValue, "name: there is no input '" + wanted + "'");
    const int cards = mmcs_sim_build_cards();
    const int places = is->scope == MMCS_SCOPE_MACHINE ? 1
                       : is->scope == MMCS_SCOPE_CARD  ? cards
                                                       : 2 * cards;
    const double value = asked_.get({"", "value", Kind::kNumber, is->low, is->high}).number();
    const double index =
        asked_.get({"", "index", Kind::kWhole, 0, static_cast<double>(places - 1), 0}).number();
    if (wanted != "estop" || value != 1) must_control();
    if (by_.only_check)
      return {{"name", quoted(wanted)}, {"index", whole(index)}, {"value", real(value)}};
    const mmcs_event event = {mmcs_sim_time(sim_), number, static_cast<int>(index), value};
    if (mmcs_sim_add_event(sim_, &event) != 0)
      throw Refusal(kRefusedValue, "index: nothing is connected there");
    mmcs_sim_run(sim_, event.t + 1.0 / mmcs_sim_build_clk_hz());  // a waiting request does, else
    return time();
  }

  // --- the past ---

  std::vector<mmcs_snapshot> kept() const {
    const mmcs_snapshot *list = nullptr;
    const int count = mmcs_sim_snapshots(sim_, &list);
    std::vector<mmcs_snapshot> made;
    made.assign(list, list + count);
    return made;
  }
  Fields ring() {
    must_control();
    const double every_s = asked_.get("every_s").number();
    mmcs_sim_ring(sim_, every_s, whole_of("count"));
    return {};
  }
  Fields snapshot() {
    int count = 0;
    for (const mmcs_snapshot &one : kept()) count += one.kept;
    if (count >= kMostSnapshots)
      throw Refusal(kBusy,
                    std::to_string(kMostSnapshots) + " snapshots are kept already; drop one");
    const int64_t id = mmcs_sim_snapshot(sim_);
    if (id < 0) throw Refusal(kIo, "no snapshot: an assertion of the machine has failed");
    return {{"snapshot", object({{"id", std::to_string(id)}, time().front()})}};
  }
  Fields snapshots() {
    std::vector<std::string> rows;
    for (const mmcs_snapshot &one : kept())
      rows.push_back(object({{"id", std::to_string(one.id)},
                             {"t", real(one.t)},
                             {"kept", one.kept ? "true" : "false"}}));
    return {{"snapshots", joined('[', rows, ']')}};
  }
  Fields drop() {
    must_control();
    if (mmcs_sim_drop(sim_, number_of("snapshot")) != 0)
      throw Refusal(kRefusedValue, "snapshot: there is none of this number");
    return {};
  }
  // Found only: who has the device open then, the carrier knows.
  Fields rewind() {
    must_control();
    return chosen(asked_.has("t"));
  }
  Fields exported() { return chosen(false); }
  Fields chosen(bool by_time) {
    const double wanted = asked_.get(by_time ? "t" : "snapshot").number();
    int64_t found = -1;
    for (const mmcs_snapshot &one : kept())
      if (by_time ? one.t <= wanted + 1e-9 : static_cast<double>(one.id) == wanted) found = one.id;
    if (found < 0) throw Refusal(kRefusedValue, "snapshot: there is none of this number or time");
    return {{"snapshot", std::to_string(found)}};
  }

  mmcs_sim *sim_;
  const mmcs_asker &by_;
  Asked asked_;
  int64_t before_;
};

}  // namespace

extern "C" {

const char *mmcs_sim_request(mmcs_sim *sim, const mmcs_asker *by, const char *asked) {
  static thread_local std::string reply;
  std::string made;
  try {
    made = object(Request(sim, *by, asked).done());
  } catch (const Refusal &no) {
    made = object({{"errno", std::to_string(no.error)}, {"text", quoted(no.what())}});
  } catch (const std::exception &problem) {
    made = object({{"errno", std::to_string(kIo)}, {"text", quoted(problem.what())}});
  }
  reply = made;
  return reply.c_str();
}

}  // extern "C"
