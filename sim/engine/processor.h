// SPDX-License-Identifier: Apache-2.0
// A real processor that runs the compiled driver, in lock-step with the machine, §4.3.
//
// Two clocks run side by side: the processor's cycles and the machine's clocks. The machine catches
// up at every bus access and after every few instructions; an access makes the processor wait for
// the machine. Files and requests go through the mailbox of firmware/ports/mailbox.h.
#pragma once

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "../../firmware/ports/mailbox.h"
#include "../hosts/iss.h"
#include "archive.h"
#include "driver.h"
#include "machine.h"
#include "phases.h"
#include "vme_bus.h"

namespace mmcs {

class Processor {
 public:
  // What the firmware reports. The mirror holds joints, setpoints, states and counts by then.
  struct Events {
    std::function<void()> acknowledged;
    std::function<void(bool sampled)> served;
    std::function<void(int client)> signal;
    std::function<void(const std::string &text)> log;
  };

  // Throws std::runtime_error with one sentence.
  Processor(Machine &machine, VmeBus &bus, struct mc *mirror, const mmcs_config &config,
            Events events);
  ~Processor();
  Processor(const Processor &) = delete;
  Processor &operator=(const Processor &) = delete;

  // One request of /dev/mc; time passes until it is answered. `in` and `out` bytes of `data` go
  // there and back. -EIO when the firmware is dead or silent for a second.
  int call(uint32_t what, int client, uint32_t a, void *data, size_t in, size_t out);
  // A write() that nobody waits for, by a process that runs between two samples.
  void post_write(int client, const std::vector<int32_t> &values);
  // Stops the machine as soon as the processor takes its interrupt, whatever request it is at.
  void stop();
  // So many microseconds no interrupt has come: mc_watch().
  void watch(uint32_t us);
  // As Host::run_until().
  bool run_until(int64_t clock, const std::function<void()> &idle);
  // What the firmware is doing.
  const Phases &phases() const { return phases_; }

  template <class A>
  void state(A &a) {
    std::vector<uint8_t> core(f_->state_size()), memory(memory_, memory_ + MAILBOX_RAM_BYTES);
    if constexpr (!A::kReads) f_->get_state(iss_, core.data());
    a.same(core);
    a.same(memory);
    for (auto *n : {&units_, &seen_cycles_}) a(*n);
    a(doorbell_);
    a(up_);
    a(dead_);
    a(pending_);
    if constexpr (A::kReads) {
      f_->set_state(iss_, core.data());
      std::copy(memory.begin(), memory.end(), memory_);
    }
  }

 private:
  // The one that call() waits for.
  struct Request {
    uint32_t what;
    void *data;
    size_t out;
    int result;
    bool done;
  };
  // A word of the mailbox, by its place in bytes.
  uint32_t word(size_t offset) const;
  void set_word(size_t offset, uint32_t value);
  void ring();
  // Lets the firmware start. Throws std::runtime_error when it does not.
  void start();
  bool busy() const;
  void report(uint32_t what);
  void collect(Request &request);
  void post(uint32_t what, int client, uint32_t a, const void *data, size_t bytes);
  void mirror();
  std::string text() const;

  void account();
  void catch_up();
  void meet();
  void set_level();
  void step(int64_t limit);
  int read(uint32_t address, int size, uint32_t *value);
  int write(uint32_t address, int size, uint32_t value);
  int acknowledge(int level);
  double now_us() const;
  void show();

  Machine &machine_;
  VmeBus &bus_;
  struct mc *mirror_;
  Events events_;
  int up_ = 0;
  int dead_ = 0;
  bool asks_ = false;  // call() waits for its turn
  Request *request_ = nullptr;
  std::vector<int32_t> pending_;  // a write that waits for the one before: client, values
  struct Functions {
    void *library;
#define ISS_FUNCTION(name) \
  decltype(&iss_##name) name = reinterpret_cast<decltype(name)>(dlsym(library, "iss_" #name))
    ISS_FUNCTION(abi);
    ISS_FUNCTION(create);
    ISS_FUNCTION(destroy);
    ISS_FUNCTION(run);
    ISS_FUNCTION(cycles);
    ISS_FUNCTION(stopped);
    ISS_FUNCTION(set_level);
    ISS_FUNCTION(pc);
    ISS_FUNCTION(memory);
    ISS_FUNCTION(state_size);
    ISS_FUNCTION(get_state);
    ISS_FUNCTION(set_state);
#undef ISS_FUNCTION
  };
  std::unique_ptr<Functions> f_;
  struct iss *iss_ = nullptr;
  uint8_t *memory_ = nullptr;
  // 8 MHz against 16.67 MHz: 25 cycles are 12 clocks, or as many times more as ClkHz is higher.
  int64_t units_per_cycle_, clocks_per_us_;
  int64_t units_ = 0;  // the processor's time
  int64_t seen_cycles_ = 0;
  uint8_t doorbell_ = 0;
  Phases phases_;
};

}  // namespace mmcs
