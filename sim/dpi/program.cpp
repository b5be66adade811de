// SPDX-License-Identifier: Apache-2.0
// The program that drives the machine: `mmcs run` as a process of its own, whose calls of
// mmcs_sim.h are carried out here, on the engine's stack, while the simulator's clocks pass.

#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>

#include "bench.h"
#include "calls.h"

extern char **environ;

namespace mmcs {
namespace {

constexpr size_t kLongest = size_t{1} << 28;

int64_t log_of(mmcs_sim *sim, int64_t *rows, int32_t *cols, const double **data) {
  *data = mmcs_sim_log(sim, rows, cols);
  return *rows * *cols;
}

// A segment's table comes beside it.
int add_segment(mmcs_sim *sim, mmcs_segment *segment, const double *table) {
  segment->table = table;
  return mmcs_sim_add_segment(sim, segment);
}

const std::map<std::string, Call> &calls() {
#define MMCS_CALL(name) {"mmcs_sim_" #name, make_call(mmcs_sim_##name)}
#define MMCS_SCRIPT(name)                               \
  {                                                     \
    "mmcs_script_" #name, make_call(mmcs_script_##name) \
  }
  static const std::map<std::string, Call> known = {
      {"mmcs_sim_log", make_call(log_of)},
      {"mmcs_sim_add_segment", make_call(add_segment)},
      MMCS_CALL(build_cards),
      MMCS_CALL(build_clk_hz),
      MMCS_CALL(build_skip),
      MMCS_CALL(build_trace),
      MMCS_CALL(build_id),
      MMCS_CALL(open),
      MMCS_CALL(close),
      MMCS_CALL(ioctl),
      MMCS_CALL(read),
      MMCS_CALL(write),
      MMCS_CALL(signals),
      MMCS_SCRIPT(event),
      MMCS_SCRIPT(call),
      MMCS_SCRIPT(process),
      MMCS_SCRIPT(begin),
      MMCS_SCRIPT(start),
      MMCS_SCRIPT(client),
      MMCS_SCRIPT(act),
      MMCS_SCRIPT(answers),
      MMCS_SCRIPT(told),
      MMCS_CALL(start_motion),
      MMCS_CALL(input_name),
      MMCS_CALL(add_event),
      MMCS_CALL(run),
      MMCS_CALL(time),
      MMCS_CALL(clock),
      MMCS_CALL(log_taken),
      MMCS_CALL(notes),
      MMCS_CALL(notes_lost),
      MMCS_CALL(get_stats),
      MMCS_CALL(phases),
      MMCS_CALL(caches),
      MMCS_CALL(true_angle),
      MMCS_CALL(true_velocity),
      MMCS_CALL(true_current),
      MMCS_CALL(true_count),
      MMCS_CALL(encoder_register),
      MMCS_CALL(checkpoints),
      MMCS_CALL(history_bytes),
      MMCS_CALL(bus_watch),
      MMCS_CALL(bus_cycles),
  };
#undef MMCS_CALL
#undef MMCS_SCRIPT
  return known;
}

// The other end of the program's line.
class Program {
 public:
  // False, and a sentence on the error output: it cannot be started.
  bool start(const std::string &scenario) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return failed("no pair of sockets");
    line_ = ends[0];
    const char *name = std::getenv("MMCS");
    const std::string command = std::string("exec ") + (name ? name : "mmcs") + " run --dpi " +
                                std::to_string(ends[1]) + " " + scenario;
    const char *words[] = {"sh", "-c", command.c_str(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    const int error = posix_spawn(&process_, "/bin/sh", &actions, nullptr,
                                  const_cast<char *const *>(words), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    return error == 0 || failed("the program cannot be started: " + command);
  }

  // One call; false: the program has ended.
  bool serve() {
    uint32_t length = 0;
    if (!receive(&length, sizeof length) || length > kLongest) return false;
    std::vector<char> bytes(length), name;
    if (!receive(bytes.data(), length)) return false;
    Reader in(bytes);
    Writer out;
    in.array(name);
    carry_out(std::string(name.begin(), name.end()), in, out);
    length = static_cast<uint32_t>(out.bytes().size());
    return send(&length, sizeof length) && send(out.bytes().data(), length);
  }

  int wait() {
    mmcs_script_destroy(kept_.script);
    mmcs_sim_destroy(kept_.sim);
    int status = 0;
    ::close(line_);
    waitpid(process_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }

 private:
  static bool failed(const std::string &why) {
    std::fprintf(stderr, "mmcs_dpi: %s\n", why.c_str());
    return false;
  }

  void carry_out(const std::string &name, Reader &in, Writer &out) {
    if (name == "mmcs_sim_create") return create(in, out);
    if (name == "mmcs_script_create") return create_script(in, out);
    const auto call = calls().find(name);
    if (call == calls().end()) throw std::runtime_error("through DPI there is no " + name);
    call->second(kept_, in, out);
  }

  // The driver is native code, so no file of a processor is named.
  void create(Reader &in, Writer &out) {
    Argument<mmcs_config *> config(in, kept_);
    Argument<const mmcs_motor *> motors(in, kept_);
    Argument<const mmcs_link *> links(in, kept_);
    Argument<char *> why(in, kept_);
    config.get()->processor = config.get()->firmware = nullptr;
    kept_.sim =
        mmcs_sim_create(config.get(), motors.get(), links.get(), why.get(), why.bytes.size());
    out.number(kept_.sim ? 1 : 0);
    for (int n = 0; n < 3; ++n) out.number(-1);
    why.answer(out, 0);
  }

  void create_script(Reader &in, Writer &out) {
    Argument<const mmcs_driver *> driver(in, kept_);
    Argument<const struct mc_param *> params(in, kept_);
    mmcs_script_destroy(kept_.script);
    kept_.script = mmcs_script_create(driver.get(), params.get());
    out.number(kept_.script ? 1 : 0);
    for (int n = 0; n < 2; ++n) out.number(-1);
  }

  bool receive(void *into, size_t n) {
    for (auto *at = static_cast<char *>(into); n > 0;) {
      const ssize_t got = ::read(line_, at, n);
      if (got <= 0) return false;
      at += got;
      n -= static_cast<size_t>(got);
    }
    return true;
  }
  bool send(const void *from, size_t n) {
    for (auto *at = static_cast<const char *>(from); n > 0;) {
      const ssize_t sent = ::send(line_, at, n, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      at += sent;
      n -= static_cast<size_t>(sent);
    }
    return true;
  }

  int line_ = -1;
  pid_t process_ = -1;
  Kept kept_;
};

Program program;  // one, as the testbench

void serve() {
  try {
    while (program.serve()) {
    }
  } catch (const std::exception &problem) {
    std::fprintf(stderr, "mmcs_dpi: %s\n", problem.what());
  }
  Bench &bench = Bench::only();
  for (bench.end(program.wait());;) bench.clocks(INT64_MAX);
}

}  // namespace
}  // namespace mmcs

extern "C" __attribute__((visibility("default"))) int mmcs_dpi_open(const char *scenario, int cards,
                                                                    int clk_hz) {
  if (cards < 1 || cards > MMCS_DPI_CARDS) {
    std::fprintf(stderr, "mmcs_dpi: the machine has %d cards, and 1 to %d are possible\n", cards,
                 MMCS_DPI_CARDS);
    return 1;
  }
  mmcs::Bench::only().begin(cards, clk_hz, mmcs::serve);
  return mmcs::program.start(scenario) ? 0 : 1;
}
