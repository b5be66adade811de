// SPDX-License-Identifier: Apache-2.0
// The host computer: the mc driver as native code, its interrupts, the processes that use it.
//
// The driver takes no time but for its bus cycles, the time of computation that the configuration
// charges for, and its waits. An interrupt is taken a random latency after the request, when the
// level is not masked: at once from idle, from a process after its current bus cycle.
// With a real processor the compiled driver takes its own time, and memory_ mirrors its results.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "driver.h"
#include "hash.h"
#include "machine.h"
#include "motion.h"
#include "processor.h"
#include "recorder.h"
#include "vme_bus.h"

namespace mmcs {

class Host {
 public:
  Host(Machine &machine, VmeBus &bus, const mmcs_config &config);
  Host(const Host &) = delete;
  Host &operator=(const Host &) = delete;

  // /dev/mc0; as mc_open() and its like.
  int open(int flags);
  int close(int client);
  int ioctl(int client, uint32_t request, void *arg);
  int read(int client, void *buf, size_t len);
  int write(int client, const void *buf, size_t len);
  int take_signals(int client);
  // Called every millisecond of the machine's time while a request waits; not 0: it waits no more,
  // and fails. No request waits longer than a second in all.
  void set_look(int (*look)(void *), void *ctx) {
    look_ = look;
    look_ctx_ = ctx;
  }
  // A request that waits is under way: nothing that needs an idle firmware can be done.
  bool waits() const { return waiting_; }
  // mc_halt(): acts before this returns, on a real processor as soon as time passes.
  int stop();

  // The processor is idle until this clock; interrupts are served. False: an assertion failed.
  // `idle` is called whenever no firmware is active, before each advance and interrupt: the
  // instants at which state() is complete.
  bool run_until(int64_t clock, const std::function<void()> &idle = nullptr);
  // From now on it also ends behind each SIGUSR1, and each sample if asked.
  enum class Ends { kAtClock, kAtSignal, kAtSample };
  void set_ends(Ends ends) {
    ends_ = ends;
    ended_ = false;
  }

  // Everything that changes in the host, the driver included, as long as no firmware is active.
  template <class A>
  void state(A &a) {
    driver_state(a, memory_);
    a(random_);
    a(masked_);
    a(requested_);
    a(due_clock_);
    a(opens_);
    a(quiet_since_);
    a(watch_clock_);
    a.same(signals_);
    motion_.state(a);
    a(motion_client_);
    a(motion_axes_);
    a(written_);
    recorder_.state(a);
    if (!cpu_) return;
    cpu_->state(a);
  }
  template <class A>
  void history(A &a) {
    recorder_.history(a);
  }

  // A program has accessed the bus by itself: between two of its instructions interrupts come.
  void after_access() {
    if (!cpu_) poll();
  }
  Motion &motion() { return motion_; }
  // From now on the process behind this client writes the motion's setpoints at every sample.
  void start_motion(int client);

  const Recorder &recorder() const { return recorder_; }
  void took_log() { recorder_.took(); }
  // Of a real processor; nullptr: there is none, or it keeps none.
  const Phases *phases() const { return cpu_ ? &cpu_->phases() : nullptr; }
  const struct mc_stats &stats() const { return *mc_stats_of(mc()); }
  const struct mc *driver() const { return mc(); }

 private:
  struct mc *mc() { return reinterpret_cast<struct mc *>(memory_.data()); }
  const struct mc *mc() const { return reinterpret_cast<const struct mc *>(memory_.data()); }
  void track_request();
  bool due() const;
  bool interrupt();  // 1: it took a sample
  void serve();
  void poll();
  void heard();
  void watch();
  void write_setpoints();
  int send(int client, std::vector<int32_t> values);

  enum mc_bus_result access(bool write, uint16_t offset, uint8_t *value);
  static Host &of(void *ctx) { return *static_cast<Host *>(ctx); }
  void bind();
  template <class F>
  int request(F f);
  void wait(uint32_t us);
  void tell();
  void served(bool sampled);

  Machine &machine_;
  VmeBus &bus_;
  std::vector<uint64_t> memory_;  // the driver's state
  struct mc_bus mc_bus_ = {};
  struct mc_os mc_os_ = {};
  Random random_;
  int64_t latency_clks_;
  double cpu_us_per_axis_;
  bool masked_ = false;
  bool serving_ = false;
  bool requested_ = false;  // the request of this assertion has its due_clock_
  int64_t due_clock_ = 0;
  int opens_ = 0;
  int64_t quiet_since_ = 0, watch_clock_ = 0;  // the last interrupt; when to look for the next
  std::vector<int> signals_;
  Motion motion_;
  int motion_client_ = -1;
  int motion_axes_ = 0;
  std::vector<int32_t> written_;
  Recorder recorder_;
  int (*look_)(void *) = nullptr;
  void *look_ctx_ = nullptr;
  int64_t patience_ends_ = 0;  // clock at which the request under way waits no more
  bool waiting_ = false;
  Ends ends_ = Ends::kAtClock;
  bool ended_ = false;              // what ends_ asks for has come
  std::unique_ptr<Processor> cpu_;  // null: the driver is native code
};

}  // namespace mmcs
