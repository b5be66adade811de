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
#include "mailbox_host.h"
#include "vme_bus.h"

namespace mmcs {

class Processor final : public MailboxHost {
 public:
  // Throws std::runtime_error with one sentence.
  Processor(Machine &machine, VmeBus &bus, struct mc *mirror, const mmcs_config &config,
            Events events);
  ~Processor() override;

  bool run_until(int64_t clock, const std::function<void()> &idle) override;
  const Phases *phases() const override { return &phases_; }
  void save(Writer &a) override { state(a); }
  void restore(Reader &a) override { state(a); }

 private:
  template <class A>
  void state(A &a) {
    std::vector<uint8_t> core(core_size()), memory(memory_, memory_ + memory_size());
    if constexpr (!A::kReads) get_core(core.data());
    a(core);
    a(memory);
    for (auto *n : {&units_, &seen_cycles_}) a(*n);
    a(doorbell_);
    mailbox_state(a);
    if constexpr (A::kReads) put_back(core, memory);
  }

  size_t core_size() const;
  size_t memory_size() const;
  void get_core(uint8_t *bytes);
  void put_back(const std::vector<uint8_t> &core, const std::vector<uint8_t> &memory);
  uint32_t word(size_t offset) const override;
  void set_word(size_t offset, uint32_t value) override;
  uint8_t byte(size_t offset) const override;
  void ring() override;
  void account();
  void catch_up();
  void meet();
  void set_level();
  void step(int64_t limit) override;
  int read(uint32_t address, int size, uint32_t *value);
  int write(uint32_t address, int size, uint32_t value);
  int acknowledge(int level);
  double now_us() const;
  void show();

  VmeBus &bus_;
  void *library_ = nullptr;
  struct Functions;
  Functions *f_ = nullptr;
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
