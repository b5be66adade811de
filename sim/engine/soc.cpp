// SPDX-License-Identifier: Apache-2.0
// The SoC's own processor: see soc.h.

#include "soc.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "../../firmware/ports/mailbox.h"

namespace mmcs {

Soc::Soc(Machine &machine, struct mc *mirror, const std::string &image, Events events)
    : MailboxHost(machine, mirror, std::move(events)) {
  std::ifstream file(image, std::ios::binary);
  std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  if (bytes.empty()) throw std::runtime_error("no firmware at " + image + "; run `make firmware`");
  if (bytes.size() > MAILBOX_BASE) {
    throw std::runtime_error("the firmware does not fit the processor's memory");
  }
  bytes.resize((bytes.size() + 3) & ~size_t{3});
  for (size_t at = 0; at < bytes.size(); at += 4) {
    uint32_t value = 0;
    for (size_t n = 4; n-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + n]);
    machine_.model().soc_write(static_cast<unsigned>(at / 4), value);
  }
  machine_.model().watch_soc([this](SocStep what, unsigned offset) { stepped(what, offset); });
  machine_.model().soc_run(true);
  start();
}

uint32_t Soc::word(size_t offset) const {
  return machine_.model().soc_read(static_cast<unsigned>((MAILBOX_BASE + offset) / 4));
}

void Soc::set_word(size_t offset, uint32_t value) {
  machine_.model().soc_write(static_cast<unsigned>((MAILBOX_BASE + offset) / 4), value);
}

uint8_t Soc::byte(size_t offset) const {
  return static_cast<uint8_t>(word(offset) >> 8 * (offset % 4));
}

void Soc::ring() {
  machine_.model().soc_ring();
}

// The processor's clocks within one of the machine are not told apart.
double Soc::now_us() const {
  return static_cast<double>(machine_.model().clock()) * 1e6 / Model::clk_hz();
}

void Soc::show() {
  machine_.model().host_phase(static_cast<unsigned>(phases_.now()), 0);
}

void Soc::stepped(SocStep step, unsigned offset) {
  if (step == SocStep::kInterrupt) {
    phases_.acknowledge(static_cast<double>(machine_.sample_clock()) * 1e6 / Model::clk_hz(),
                        now_us());
  } else if (step == SocStep::kAccess) {
    access_us_ = now_us();
  } else {
    phases_.access(offset, step == SocStep::kWrite, access_us_, now_us());
  }
  show();
}

void Soc::step(int64_t limit) {
  Model &model = machine_.model();
  const bool stalled = machine_.clock() < machine_.stalled_until();
  if (stalled != irq_open_) {
    irq_open_ = stalled;
    model.pins().set(Pin::kIrqOpen, 0, stalled);
  }
  if (stalled) limit = std::min(limit, machine_.stalled_until());
  if (limit > machine_.clock()) machine_.advance(limit - machine_.clock(), Watch::kReport);
  if (const unsigned what = model.report()) {
    model.take_report();
    // No acknowledge cycle tells when a pass began: the edge of SCLOCK before its end is its own.
    if (what == MAILBOX_SERVED || what == MAILBOX_SAMPLED) events_.acknowledged();
    phases_.report(what == MAILBOX_SAMPLED, now_us());
    report(what);
    show();
  }
}

bool Soc::run_until(int64_t clock, const std::function<void()> &idle) {
  while (machine_.clock() < clock && !machine_.failed()) {
    if (idle) idle();
    step(clock);
  }
  return !machine_.failed();
}

}  // namespace mmcs
