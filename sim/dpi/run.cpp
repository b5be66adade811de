// SPDX-License-Identifier: Apache-2.0
// The run behind the testbench: a set-up's machine and script, on the engine's stack, while the
// simulator's clocks pass. log.csv and bus.csv go into a folder, as `mmcs run --bus` writes them.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "bench.h"
#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"

// Of the Makefile, "dpi" and a digest: the machine's size is the testbench's.
extern "C" char mmcs_build_id_text[64];

namespace mmcs {
namespace {

constexpr double kLookS = 0.02;  // of the machine's time between two writes to the files
constexpr int kUsualClkHz = 8'000'000;

class Run {
 public:
  // False, and a sentence on the error output: files cannot be read or made.
  bool open(const char *setup, const std::string &folder) {
    char why[300] = "";
    data_.reset(mmcs_setup_load(setup, &size_, why, sizeof why));
    if (!data_) return failed(why);
    for (auto [file, name] : {std::pair{&log_, "log.csv"}, {&bus_, "bus.csv"}}) {
      *file = std::fopen((folder + "/" + name).c_str(), "w");
      if (!*file) return failed(folder + "/" + name + ": cannot be made");
    }
    return true;
  }

  // The exit status: 0, or 1 and a sentence on the error output.
  int carry_out() {
    const mmcs_overrides every_clock = {0, 0, {}, {}, {}, MMCS_OVER_SKIP, 0, 0, 0, 0};
    char why[300] = "";
    sim_ = mmcs_sim_create_from(data_.get(), size_, &every_clock, why, sizeof why);
    if (sim_) script_ = mmcs_script_create_from(data_.get(), size_, &every_clock, why, sizeof why);
    if (!script_) return !failed(why);
    const mmcs_bus_cycle *none = nullptr;
    mmcs_sim_bus_cycles(sim_, &none);  // from now on they are recorded
    if (mmcs_script_axes(script_) == 0) return !failed("the set-up's [[program]] needs `mmcs run`");
    const int refused = mmcs_script_begin(script_, sim_, why, sizeof why);
    if (refused < 0) return !failed(refusal(why));
    if (refused == 0 && !move()) return 1;
    write_log();
    const int client = mmcs_script_client(script_);
    if (refused == 0) mmcs_sim_ioctl(sim_, client, MSTOP, nullptr);
    report();
    mmcs_sim_close(sim_, client);
    write_bus();
    return std::fclose(log_) || std::fclose(bus_) ? !failed("no room for the files") : 0;
  }

 private:
  // From look to look, so that the files grow while the run goes on.
  bool move() {
    const double duration = mmcs_script_duration(script_), start = mmcs_script_start(script_);
    const int looks = std::max(1, static_cast<int>(duration / kLookS));
    write_log(true);
    for (int look = 1; look <= looks; ++look) {
      const double until = duration * look / looks;
      char what[300] = "";
      const int result = mmcs_script_act(script_, sim_, until, what, sizeof what);
      if (result < 0) return failed(refusal(what));
      if (result > 0 || mmcs_sim_run(sim_, start + until) != 0)
        return failed("an assertion of the machine has failed");
      write_log();
      write_bus();
    }
    return true;
  }

  void write_log(bool first = false) {
    int64_t rows = 0;
    int32_t columns = 0;
    const double *data = mmcs_sim_log(sim_, &rows, &columns);
    if (first) std::fputs(mmcs_log_lines(columns, nullptr, 0), log_);
    if (rows) std::fputs(mmcs_log_lines(columns, data, rows), log_);
    mmcs_sim_log_taken(sim_);
  }
  void write_bus() {
    if (std::ftell(bus_) == 0) std::fputs(mmcs_bus_lines(nullptr, 0), bus_);
    const mmcs_bus_cycle *cycles = nullptr;
    const int64_t count = mmcs_sim_bus_cycles(sim_, &cycles);
    if (count) std::fputs(mmcs_bus_lines(cycles, count), bus_);
  }

  void report() const {
    mmcs_stats s;
    mmcs_sim_get_stats(sim_, &s);
    std::printf(
        "mmcs: %d interrupts, %d missed, %d overruns, %d panics; no hash: no register can "
        "be read\n",
        s.interrupts, s.missed, s.overruns, s.panics);
  }
  // A request, and what the engine has said of it.
  std::string refusal(const char *what) const {
    const mmcs_note *notes = nullptr;
    const int count = mmcs_sim_notes(sim_, &notes);
    return std::string(what) + ": " + (count ? notes[count - 1].text : "refused");
  }
  static bool failed(const std::string &why) {
    std::fprintf(stderr, "mmcs: %s\n", why.c_str());
    return false;
  }

  std::unique_ptr<void, void (*)(void *)> data_{nullptr, std::free};
  size_t size_ = 0;
  std::FILE *log_ = nullptr, *bus_ = nullptr;
  mmcs_sim *sim_ = nullptr;
  mmcs_script *script_ = nullptr;
};

Run run;  // one, as the testbench

void engine() {
  Bench &bench = Bench::only();
  for (bench.end(run.carry_out());;) bench.clocks(INT64_MAX);
}

}  // namespace
}  // namespace mmcs

extern "C" __attribute__((visibility("default"))) int mmcs_dpi_open(const char *setup,
                                                                    const char *folder, int cards,
                                                                    int clk_hz) {
  if (cards < 1 || cards > MMCS_DPI_CARDS) {
    std::fprintf(stderr, "mmcs: the machine has %d cards, and 1 to %d are possible\n", cards,
                 MMCS_DPI_CARDS);
    return 1;
  }
  std::string id = mmcs_build_id_text;
  const std::string clk = clk_hz == mmcs::kUsualClkHz ? "" : "_clk" + std::to_string(clk_hz);
  id.replace(0, id.find(' '), "c" + std::to_string(cards) + clk);
  std::snprintf(mmcs_build_id_text, sizeof mmcs_build_id_text, "%s", id.c_str());
  mmcs::Bench::only().begin(cards, clk_hz, mmcs::engine);
  return mmcs::run.open(setup, folder) ? 0 : 1;
}
