// SPDX-License-Identifier: Apache-2.0
// A real processor that runs the compiled driver, in lock-step with the machine, §4.3.
//
// Two clocks run side by side: the processor's cycles and the machine's clocks. The machine catches
// up at every bus access and after every few instructions; an access makes the processor wait for
// the machine. Files and requests go through the mailbox of firmware/ports/mailbox.h.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "../hosts/iss.h"
#include "archive.h"
#include "driver.h"
#include "machine.h"
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

  // library and image are file names. Throws std::runtime_error with one sentence.
  Processor(Machine &machine, VmeBus &bus, struct mc *mirror, const std::string &library,
            const std::string &image, int wait_states, Events events);
  ~Processor();
  Processor(const Processor &) = delete;
  Processor &operator=(const Processor &) = delete;

  // One request of /dev/mc; time passes until it is answered. `size` words' worth of bytes go in
  // and out of `data`. -EIO when the firmware is dead or silent for a second.
  int call(uint32_t what, int client, uint32_t a, void *data, size_t in, size_t out);
  // A write() that nobody waits for, by a process that runs between two samples.
  void post_write(int client, const std::vector<int32_t> &values);

  bool run_until(int64_t clock, const std::function<void()> &idle);

  template <class A>
  void state(A &a) {
    std::vector<uint8_t> core(core_size()), memory(memory_, memory_ + memory_size());
    if constexpr (!A::kReads) get_core(core.data());
    a(core);
    a(memory);
    for (auto *n : {&units_, &seen_cycles_}) a(*n);
    a(doorbell_);
    a(up_);
    a(dead_);
    a(pending_);
    if constexpr (A::kReads) put_back(core, memory);
  }

 private:
  size_t core_size() const;
  size_t memory_size() const;
  void get_core(uint8_t *bytes);
  void put_back(const std::vector<uint8_t> &core, const std::vector<uint8_t> &memory);
  uint32_t word(size_t offset) const;
  void set_word(size_t offset, uint32_t value);
  void post(uint32_t what, int client, uint32_t a, const void *data, size_t bytes);
  bool busy() const;
  void account();
  void catch_up();
  void meet();
  void set_level();
  void step(int64_t limit);
  void mirror();
  void report(uint32_t what);
  int read(uint32_t address, int size, uint32_t *value);
  int write(uint32_t address, int size, uint32_t value);
  int acknowledge(int level);

  Machine &machine_;
  VmeBus &bus_;
  struct mc *mirror_;
  Events events_;
  void *library_ = nullptr;
  struct Functions;
  Functions *f_ = nullptr;
  struct iss *iss_ = nullptr;
  uint8_t *memory_ = nullptr;
  int64_t units_ = 0;  // the processor's time: 25 to a clock, 12 to a cycle
  int64_t seen_cycles_ = 0;
  uint8_t doorbell_ = 0, up_ = 0, dead_ = 0;
  std::vector<int32_t> pending_;  // client and values of a write that waits for the mailbox
};

}  // namespace mmcs
