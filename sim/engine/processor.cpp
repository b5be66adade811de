// SPDX-License-Identifier: Apache-2.0
// A real processor beside the machine: see processor.h.

#include "processor.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "../../firmware/ports/mailbox.h"

extern "C" {
#include "mc_priv.h"
}

namespace mmcs {
namespace {

// 8 MHz against 16.67 MHz: 25 cycles are 12 clocks.
constexpr int64_t kUnitsPerClock = 25;
constexpr int64_t kUnitsPerCycle = 12;
// Longest time that the processor runs ahead of the machine.
constexpr int kQuantumCycles = 50;
constexpr int kServoLevel = 5;
constexpr int kDoorbellLevel = 2;
constexpr unsigned kAmSupervisor = 0x2D;
constexpr double kStartS = 0.1;
constexpr double kAnswerS = 1.0;

#define FIELD(name) offsetof(struct mailbox, name)

}  // namespace

struct Processor::Functions {
  decltype(&iss_abi) abi;
  decltype(&iss_create) create;
  decltype(&iss_destroy) destroy;
  decltype(&iss_run) run;
  decltype(&iss_cycles) cycles;
  decltype(&iss_stopped) stopped;
  decltype(&iss_set_level) set_level;
  decltype(&iss_memory) memory;
  decltype(&iss_state_size) state_size;
  decltype(&iss_get_state) get_state;
  decltype(&iss_set_state) set_state;
};

Processor::Processor(Machine &machine, VmeBus &bus, struct mc *mirror, const std::string &library,
                     const std::string &image, int wait_states, Events events)
    : machine_(machine), bus_(bus), mirror_(mirror), events_(std::move(events)) {
  std::ifstream file(image, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  if (bytes.empty()) throw std::runtime_error("no firmware at " + image + "; run `make firmware`");
  library_ = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library_) throw std::runtime_error("no processor at " + library + "; run `make firmware`");
  f_ = new Functions;
  const auto find = [this](auto &function, const char *name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library_, name));
    if (!function) throw std::runtime_error(std::string("the processor lacks ") + name);
  };
  find(f_->abi, "iss_abi");
  find(f_->create, "iss_create");
  find(f_->destroy, "iss_destroy");
  find(f_->run, "iss_run");
  find(f_->cycles, "iss_cycles");
  find(f_->stopped, "iss_stopped");
  find(f_->set_level, "iss_set_level");
  find(f_->memory, "iss_memory");
  find(f_->state_size, "iss_state_size");
  find(f_->get_state, "iss_get_state");
  find(f_->set_state, "iss_set_state");
  if (f_->abi() != MMCS_ISS_ABI)
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
  // Without wait states all fetches are taken to hit: the cache model charges misses in full.
  const struct iss_timing timing = {wait_states > 0, wait_states};
  iss_ = f_->create(MAILBOX_RAM_BYTES, reinterpret_cast<const uint8_t *>(bytes.data()),
                    bytes.size(), &iss_bus, &timing);
  if (!iss_) throw std::runtime_error("the firmware does not fit the processor's memory");
  memory_ = f_->memory(iss_);
  units_ = machine_.clock() * kUnitsPerClock;
  const int64_t end = machine_.clock() + machine_.clocks(kStartS);
  while (!up_ && machine_.clock() < end && !machine_.failed()) step(end);
  if (!up_) throw std::runtime_error("the firmware does not come up");
}

Processor::~Processor() {
  if (iss_) f_->destroy(iss_);
  delete f_;
  if (library_) dlclose(library_);
}

// --- the mailbox -------------------------------------------------------------------------------

uint32_t Processor::word(size_t offset) const {
  const uint8_t *m = memory_ + MAILBOX_BASE + offset;
  return static_cast<uint32_t>(m[0]) << 24 | static_cast<uint32_t>(m[1]) << 16 |
         static_cast<uint32_t>(m[2]) << 8 | m[3];
}

void Processor::set_word(size_t offset, uint32_t value) {
  uint8_t *m = memory_ + MAILBOX_BASE + offset;
  for (int n = 3; n >= 0; --n, value >>= 8) m[n] = static_cast<uint8_t>(value);
}

bool Processor::busy() const {
  return word(FIELD(posted)) != word(FIELD(done));
}

void Processor::post(uint32_t what, int client, uint32_t a, const void *data, size_t bytes) {
  set_word(FIELD(call), what);
  set_word(FIELD(client), static_cast<uint32_t>(client));
  set_word(FIELD(a), a);
  set_word(FIELD(has_data), data ? 1 : 0);
  bytes = std::min(bytes, sizeof(uint32_t) * MAILBOX_DATA_WORDS);
  for (size_t at = 0; data && at + 4 <= bytes; at += 4) {
    uint32_t value;
    std::memcpy(&value, static_cast<const uint8_t *>(data) + at, 4);
    set_word(FIELD(data) + at, value);
  }
  set_word(FIELD(posted), word(FIELD(posted)) + 1);
  doorbell_ = 1;
  set_level();
}

int Processor::call(uint32_t what, int client, uint32_t a, void *data, size_t in, size_t out) {
  const int64_t end = machine_.clock() + machine_.clocks(kAnswerS);
  const auto wait = [&] {
    while ((busy() || !pending_.empty()) && !dead_ && machine_.clock() < end &&
           !machine_.failed()) {
      step(end);
    }
    return !busy() && !dead_;
  };
  if (!wait()) return -MC_EIO;
  post(what, client, a, data, in);
  if (!wait()) return -MC_EIO;
  const int result = static_cast<int>(word(FIELD(result)));
  if (result < 0 || !data) return result;
  if (what == MAILBOX_READ) out = static_cast<size_t>(result);
  for (size_t at = 0; at + 4 <= out; at += 4) {
    const uint32_t value = word(FIELD(data) + at);
    std::memcpy(static_cast<uint8_t *>(data) + at, &value, 4);
  }
  return result;
}

void Processor::post_write(int client, const std::vector<int32_t> &values) {
  if (busy()) {
    pending_ = values;
    pending_.insert(pending_.begin(), client);
    return;
  }
  post(MAILBOX_WRITE, client, static_cast<uint32_t>(4 * values.size()), values.data(),
       4 * values.size());
}

// What the firmware published, as the native driver would hold it.
void Processor::mirror() {
  mirror_->joints = static_cast<int>(word(FIELD(joints)));
  int32_t stats[6];
  for (size_t n = 0; n < 6; ++n) stats[n] = static_cast<int32_t>(word(FIELD(stats) + 4 * n));
  static_assert(sizeof stats == sizeof mirror_->stats);
  std::memcpy(&mirror_->stats, stats, sizeof stats);
  for (int axis = 0; axis < mirror_->joints && axis < MAILBOX_AXES; ++axis) {
    const size_t at = FIELD(axis) + static_cast<size_t>(axis) * sizeof(struct mailbox_axis);
    mirror_->axis[axis].setpoint = static_cast<int32_t>(word(at));
    int32_t state[7];
    for (size_t n = 0; n < 7; ++n) state[n] = static_cast<int32_t>(word(at + 4 + 4 * n));
    std::memcpy(&mirror_->axis[axis].state, state, sizeof state);
  }
}

void Processor::report(uint32_t what) {
  switch (what) {
    case MAILBOX_UP:
      up_ = 1;
      break;
    case MAILBOX_SERVED:
    case MAILBOX_SAMPLED:
      mirror();
      events_.served(what == MAILBOX_SAMPLED);
      break;
    case MAILBOX_DONE:
      mirror();
      if (!pending_.empty()) {
        const std::vector<int32_t> values(pending_.begin() + 1, pending_.end());
        const int client = pending_.front();
        pending_.clear();
        post_write(client, values);
      }
      break;
    case MAILBOX_SIGNAL:
      events_.signal(static_cast<int>(word(FIELD(signal_client))));
      break;
    case MAILBOX_LOG:
    case MAILBOX_DEAD: {
      const char *text = reinterpret_cast<const char *>(memory_ + MAILBOX_BASE + FIELD(text));
      if (what == MAILBOX_LOG) {
        events_.log(std::string(text, strnlen(text, MAILBOX_TEXT)));
        break;
      }
      dead_ = 1;
      char line[80];
      std::snprintf(line, sizeof line, "the firmware died: exception %u at 0x%X",
                    static_cast<unsigned>(word(FIELD(fault))),
                    static_cast<unsigned>(word(FIELD(fault_pc))));
      events_.log(line);
      break;
    }
    default:
      break;
  }
}

// --- time and bus ------------------------------------------------------------------------------

// The cycles used since the last look become time.
void Processor::account() {
  const int64_t cycles = f_->cycles(iss_);
  units_ += (cycles - seen_cycles_) * kUnitsPerCycle;
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
    *value = static_cast<uint32_t>(units_ / (8 * kUnitsPerClock));
    return 0;
  }
  if (address < MAILBOX_SHORT_IO) return 1;
  catch_up();
  const BusResult result = bus_.read(address & 0xFFFF, kAmSupervisor, size, value);
  meet();
  return result == BusResult::kOk ? 0 : 1;
}

int Processor::write(uint32_t address, int size, uint32_t value) {
  if (size == 4 && (address == MAILBOX_REPORT || address == MAILBOX_DOORBELL)) {
    catch_up();
    if (address == MAILBOX_DOORBELL) doorbell_ = 0;
    if (address == MAILBOX_REPORT) report(value);
    set_level();
    return 0;
  }
  if (address < MAILBOX_SHORT_IO) return 1;
  catch_up();
  const BusResult result = bus_.write(address & 0xFFFF, kAmSupervisor, size, value);
  meet();
  return result == BusResult::kOk ? 0 : 1;
}

int Processor::acknowledge(int level) {
  if (level != kServoLevel) return -1;
  catch_up();
  events_.acknowledged();
  uint8_t vector = 0;
  const BusResult result = bus_.acknowledge(level, &vector);
  meet();
  return result == BusResult::kOk ? vector : -2;
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
    if (until > machine_.clock()) machine_.advance(until - machine_.clock(), Watch::kIrq);
    units_ = std::max(units_, machine_.clock() * kUnitsPerClock);
    return;
  }
  f_->run(iss_, kQuantumCycles);
  catch_up();
}

bool Processor::run_until(int64_t clock, const std::function<void()> &idle) {
  while (machine_.clock() < clock && !machine_.failed()) {
    if (idle && f_->stopped(iss_) && !busy()) idle();
    step(clock);
  }
  return !machine_.failed();
}

// --- snapshots ---------------------------------------------------------------------------------

size_t Processor::core_size() const {
  return f_->state_size();
}
size_t Processor::memory_size() const {
  return MAILBOX_RAM_BYTES;
}
void Processor::get_core(uint8_t *bytes) {
  f_->get_state(iss_, bytes);
}
void Processor::put_back(const std::vector<uint8_t> &core, const std::vector<uint8_t> &memory) {
  if (core.size() != core_size() || memory.size() != memory_size()) {
    throw std::invalid_argument("the snapshot holds another processor");
  }
  f_->set_state(iss_, core.data());
  std::memcpy(memory_, memory.data(), memory.size());
}

}  // namespace mmcs
