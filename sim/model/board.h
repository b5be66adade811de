// SPDX-License-Identifier: Apache-2.0
// The Verilated model of a part: its registers and ports by name, and the ways to evaluate it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

class VerilatedContext;
class VerilatedFstC;

// Verilator's run-time library prints through this where assertions are compiled in: a library does
// not write to the console; the text becomes the note of the failed assertion.
extern "C" int mmcs_model_print(const char *format, ...);

namespace mmcs {

// What the models of a machine share. Verilator's own header takes longer to compile than most
// files here; those that need no more than this are compiled without it.
using Context = std::shared_ptr<VerilatedContext>;
Context create_context(uint64_t seed);
void use(const Context &context);  // in this thread, for all models that are made or run

// A variable of a model, as long as a machine word at most.
struct Net {
  char *at = nullptr;
  int bytes = 0, width = 0, entry = 0;  // entry: bytes of one of an array

  explicit operator bool() const { return at != nullptr; }
  uint64_t mask() const { return width == 64 ? ~uint64_t{0} : (uint64_t{1} << width) - 1; }
  uint64_t get() const {
    uint64_t value = 0;
    if (bytes == 1) return static_cast<uint8_t>(*at);
    std::memcpy(&value, at, std::min(static_cast<size_t>(bytes), sizeof value));
    return value;
  }
  void put(uint64_t value) const {
    value &= mask();
    if (bytes == 1) {
      *at = static_cast<char>(value);
    } else {
      std::memcpy(at, &value, std::min(static_cast<size_t>(bytes), sizeof value));
    }
  }
  // Bits of one that may be longer; lsb % 8 of them and these are 64 at most.
  uint64_t get(int lsb, int count) const {
    return part(lsb).get() >> lsb % 8 & ((uint64_t{1} << count) - 1);
  }
  void put(int lsb, int count, uint64_t value) const {
    const Net net = part(lsb);
    const uint64_t mask = ((uint64_t{1} << count) - 1) << lsb % 8;
    net.put((net.get() & ~mask) | (value << lsb % 8 & mask));
  }
  // All bytes of it. Bits that it does not have are dropped: the model trusts them to be 0.
  void load(const uint8_t *from) const {
    std::memcpy(at, from, static_cast<size_t>(bytes));
    for (int place = 0; place < bytes; place += entry) {
      for (int bit = width; bit < 8 * entry; ++bit) {
        at[place + bit / 8] = static_cast<char>(at[place + bit / 8] & ~(1 << bit % 8));
      }
    }
  }

 private:
  // The bytes from a bit on.
  Net part(int lsb) const {
    const int skipped = lsb / 8, rest = std::min(8, bytes - skipped);
    return {at + skipped, rest, 8 * rest, rest};
  }
};

// Registers with bits that a fault holds, at 0 or at 1.
class HeldBits {
 public:
  // From now on; no bits: the register is free.
  void hold(const Net &net, uint64_t zeros, uint64_t ones) {
    const auto same = [&net](const Held &h) { return h.net.at == net.at; };
    held_.erase(std::remove_if(held_.begin(), held_.end(), same), held_.end());
    if (zeros | ones) held_.push_back({net, zeros, ones});
  }
  // True: some register changes.
  bool apply() const {
    bool changed = false;
    for (const Held &h : held_) {
      const uint64_t before = h.net.get(), after = (before & ~h.zeros) | h.ones;
      changed = changed || before != after;
      h.net.put(after);
    }
    return changed;
  }
  bool any() const { return !held_.empty(); }

 private:
  struct Held {
    Net net;
    uint64_t zeros, ones;
  };
  std::vector<Held> held_;
};

// The variable of this name in a scope of the context; at is null if there is none.
// A longer one has its size in bytes, and may be copied as bytes only.
Net find_net(const VerilatedContext &context, const std::string &scope, const std::string &name);

class Board {
 public:
  // module: as in rtl/. Throws when this build has no such model.
  static std::unique_ptr<Board> create(const std::string &module, VerilatedContext &context,
                                       const std::string &name);
  virtual ~Board() = default;

  virtual std::string name() const = 0;
  // The slow way, as Verilator offers it: what follows from all that has changed, edges included.
  virtual void eval() = 0;

  // The fast way (fast.cpp). What follows from inputs and counters; true if registers followed
  // without a clock. One clock, with what follows. What follows from registers that were written.
  virtual bool inputs() = 0;
  virtual void clock() = 0;
  virtual void settle() = 0;
  // No edge of a reset or strobe has been until now.
  virtual void sync() = 0;

  // A port; at is null if there is none of this name.
  virtual Net port(const std::string &name) = 0;
  // Waveforms, where the build has them.
  virtual void trace(VerilatedFstC *) {}
};

}  // namespace mmcs
