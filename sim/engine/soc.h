// SPDX-License-Identifier: Apache-2.0
// The SoC's own processor, which is part of the model: see rtl/soc and docs/hardware/soc.md.
//
// There is one clock loop, that of the machine; the processor runs in it. It waits at each report
// until the report is taken, so that what it published is read as it was.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "mailbox_host.h"

namespace mmcs {

class Soc final : public MailboxHost {
 public:
  // image is a file name. Throws std::runtime_error with one sentence.
  Soc(Machine &machine, struct mc *mirror, const std::string &image, Events events);

  bool run_until(int64_t clock, const std::function<void()> &idle) override;
  const Phases *phases() const override { return &phases_; }
  void save(Writer &a) override { state(a); }
  void restore(Reader &a) override { state(a); }

 private:
  template <class A>
  void state(A &a) {
    mailbox_state(a);
    a(irq_open_);
  }
  uint32_t word(size_t offset) const override;
  void set_word(size_t offset, uint32_t value) override;
  uint8_t byte(size_t offset) const override;
  void ring() override;
  void step(int64_t limit) override;
  void stepped(SocStep step, unsigned offset);
  double now_us() const;
  void show();

  bool irq_open_ = false;  // the host is stalled: no interrupt reaches the processor
  double access_us_ = 0;   // when the access under way began
  Phases phases_;
};

}  // namespace mmcs
