// SPDX-License-Identifier: Apache-2.0
// A real processor beside the machine: see processor.h.

#include "processor.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace mmcs {
namespace {

constexpr int64_t kUnitsPerClock = 25;
constexpr int64_t kUnitsPerCycleAt8MHz = 12;
// Longest time that the processor runs ahead of the machine.
constexpr int kQuantumCycles = 50;
constexpr int kServoLevel = 5;
constexpr int kDoorbellLevel = 2;
constexpr unsigned kAmSupervisor = 0x2D;

}  // namespace

Processor::Processor(Machine &machine, VmeBus &bus, struct mc *mirror, const mmcs_config &config,
                     Events events)
    : machine_(machine),
      bus_(bus),
      mirror_(mirror),
      events_(std::move(events)),
      units_per_cycle_(kUnitsPerCycleAt8MHz * (Model::clk_hz() / 8000000)),
      clocks_per_us_(Model::clk_hz() / 1000000) {
  const std::string library = config.processor, image = config.firmware;
  std::ifstream file(image, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  if (bytes.empty()) throw std::runtime_error("no firmware at " + image + "; run `make firmware`");
  void *const opened = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!opened) throw std::runtime_error("no processor at " + library + "; run `make firmware`");
  f_ = std::make_unique<Functions>(Functions{opened});
  if (!f_->abi || f_->abi() != MMCS_ISS_ABI)
    throw std::runtime_error("the processor's library is of another age");
  const struct iss_bus iss_bus = {
      this,
      [](void *ctx, uint32_t address, int size, uint32_t *value) {
        return static_cast<Processor *>(ctx)->read(address, size, value);
      },
      [](void *ctx, uint32_t address, int size, uint32_t value) {
        return static_cast<Processor *>(ctx)->write(address, size, value);
      },
      [](void *ctx, int level) { return static_cast<Processor *>(ctx)->acknowledge(level); },
  };
  const struct iss_timing timing = {config.instruction_cache != 0, config.wait_states};
  iss_ = f_->create(MAILBOX_RAM_BYTES, reinterpret_cast<const uint8_t *>(bytes.data()),
                    bytes.size(), &iss_bus, &timing);
  if (!iss_) throw std::runtime_error("the firmware does not fit the processor's memory");
  memory_ = f_->memory(iss_);
  units_ = machine_.clock() * kUnitsPerClock;
  start();
}

Processor::~Processor() {
  if (iss_) f_->destroy(iss_);
  if (f_) dlclose(f_->library);
}

// --- time and bus ------------------------------------------------------------------------------

// The cycles used since the last look become time.
void Processor::account() {
  const int64_t cycles = f_->cycles(iss_);
  units_ += (cycles - seen_cycles_) * units_per_cycle_;
  seen_cycles_ = cycles;
}

// The machine follows the processor.
void Processor::catch_up() {
  account();
  const int64_t behind = units_ / kUnitsPerClock - machine_.clock();
  if (behind > 0) machine_.advance(behind, Watch::kNothing);
}

// The processor waited for the machine.
void Processor::meet() {
  units_ = std::max(units_, machine_.clock() * kUnitsPerClock);
  set_level();
}

void Processor::set_level() {
  const bool servo = machine_.irq() && machine_.clock() >= machine_.stalled_until();
  f_->set_level(iss_, servo ? kServoLevel : doorbell_ ? kDoorbellLevel : 0);
}

int Processor::read(uint32_t address, int size, uint32_t *value) {
  if (address == MAILBOX_CLOCK_US && size == 4) {
    account();
    *value = static_cast<uint32_t>(units_ / (clocks_per_us_ * kUnitsPerClock));
    return 0;
  }
  if (address < MAILBOX_SHORT_IO) return 1;
  catch_up();
  const double from = now_us();
  const BusResult result = bus_.read(address & 0xFFFF, kAmSupervisor, size, value);
  meet();
  phases_.access(address & 0x7FF, false, from, now_us());
  show();
  return result == BusResult::kOk ? 0 : 1;
}

int Processor::write(uint32_t address, int size, uint32_t value) {
  if (size == 4 && (address == MAILBOX_REPORT || address == MAILBOX_DOORBELL)) {
    catch_up();
    if (address == MAILBOX_DOORBELL) doorbell_ = 0;
    if (address == MAILBOX_REPORT) {
      phases_.report(value == MAILBOX_SAMPLED, now_us());
      report(value);
      show();
    }
    set_level();
    return 0;
  }
  if (address < MAILBOX_SHORT_IO) return 1;
  catch_up();
  const double from = now_us();
  const BusResult result = bus_.write(address & 0xFFFF, kAmSupervisor, size, value);
  meet();
  phases_.access(address & 0x7FF, true, from, now_us());
  show();
  return result == BusResult::kOk ? 0 : 1;
}

int Processor::acknowledge(int level) {
  if (level != kServoLevel) return -1;
  catch_up();
  phases_.acknowledge(
      static_cast<double>(machine_.sample_clock()) / static_cast<double>(clocks_per_us_), now_us());
  show();
  events_.acknowledged();
  uint8_t vector = 0;
  const BusResult result = bus_.acknowledge(level, &vector);
  meet();
  return result == BusResult::kOk ? vector : -2;
}

double Processor::now_us() const {
  return static_cast<double>(units_) / static_cast<double>(clocks_per_us_ * kUnitsPerClock);
}

// Into the waveform, where there is one.
void Processor::show() {
  machine_.model().host_phase(static_cast<unsigned>(phases_.now()), f_->pc(iss_));
}

// A few instructions, or sleep until something happens; never beyond `limit` while asleep.
void Processor::step(int64_t limit) {
  set_level();
  const bool wakes = doorbell_ || (machine_.irq() && machine_.clock() >= machine_.stalled_until());
  if (f_->stopped(iss_) && (dead_ || !wakes)) {
    int64_t until = limit;
    if (machine_.irq() && machine_.stalled_until() > machine_.clock()) {
      until = std::min(until, machine_.stalled_until());
    }
    machine_.model().host_phase(static_cast<unsigned>(Phase::kWaiting), f_->pc(iss_));
    if (until > machine_.clock()) machine_.advance(until - machine_.clock(), Watch::kIrq);
    show();
    units_ = std::max(units_, machine_.clock() * kUnitsPerClock);
    return;
  }
  f_->run(iss_, kQuantumCycles);
  catch_up();
  show();
}

bool Processor::run_until(int64_t clock, const std::function<void()> &idle) {
  while (machine_.clock() < clock && !machine_.failed()) {
    if (idle && f_->stopped(iss_) && !busy()) idle();
    step(clock);
  }
  return !machine_.failed();
}

}  // namespace mmcs
