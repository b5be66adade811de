// SPDX-License-Identifier: Apache-2.0
// The two sides of the testbench's call: what stands on the pins, and the change from the
// simulator's stack to the engine's and back, at the clocks that the engine has to see.
//
// DPI-C has no handle for what it calls, and a simulator has one testbench: so there is one Bench.
#pragma once

#include <sys/types.h>
#include <ucontext.h>

#include <cstdint>
#include <vector>

#include "mmcs_dpi.h"
#include "pins.h"

namespace mmcs {

class Bench {
 public:
  static Bench &only();

  // Before the first clock. `engine` runs on a stack of its own, from the first clock on.
  void begin(int cards, int clk_hz, void (*engine)());
  int cards() const { return cards_; }
  int clk_hz() const { return clk_hz_; }

  // Of the engine: everything put() goes out at this clock's edge. Returns at the next edge at
  // which IRQ1*..IRQ7*, DTACK* or a bit of `lines` has changed, at the latest `most` clocks on: how
  // many clocks have passed, 1 or more.
  int64_t clocks(int64_t most);
  void put(Port port, int lsb, int width, uint64_t value);
  // No more is to come: the run's exit status.
  void end(int status) { result_ = 1 + status; }

  // Of the simulator: mmcs_dpi_clock().
  int enter();

  // What the machine showed before the edge.
  uint32_t vme = 0, lines = 0;
  uint32_t drive[MMCS_DPI_AXIS_WORDS] = {}, leds[MMCS_DPI_LED_WORDS] = {};
  // A port as it stands from the edge on; 32 bits a word.
  uint64_t level(Port port) const { return ports_[port][0] | uint64_t{ports_[port][1]} << 32; }
  const uint32_t *words(Port port) const { return ports_[port]; }

 private:
  int cards_ = 0, clk_hz_ = 0;
  int result_ = 0;
  int64_t most_ = 0, passed_ = 0;
  uint32_t vme_then_ = 0, lines_then_ = 0;  // as clocks() was called
  ucontext_t simulator_ = {}, engine_ = {};
  std::vector<char> stack_;
  uint32_t ports_[kPorts][MMCS_DPI_AXIS_WORDS] = {};
};

inline uint32_t bits_of(const uint32_t *words, int lsb, int width) {
  uint64_t two = words[lsb / 32];
  if (lsb % 32 + width > 32) two |= uint64_t{words[lsb / 32 + 1]} << 32;
  return static_cast<uint32_t>(two >> lsb % 32 & ((uint64_t{1} << width) - 1));
}

}  // namespace mmcs
