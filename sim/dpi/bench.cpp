// SPDX-License-Identifier: Apache-2.0
// See bench.h and mmcs_dpi.h.

#include "bench.h"

#include <algorithm>

namespace mmcs {
namespace {

constexpr size_t kStackBytes = size_t{1} << 22;
constexpr uint32_t kWatched = 1u << MMCS_DPI_DTACK | 0x7Fu << MMCS_DPI_IRQ;  // of vme

}  // namespace

Bench &Bench::only() {
  static Bench bench;
  return bench;
}

void Bench::begin(int cards, int clk_hz, void (*engine)()) {
  cards_ = cards;
  clk_hz_ = clk_hz;
  stack_.resize(kStackBytes);
  getcontext(&engine_);
  engine_.uc_stack.ss_sp = stack_.data();
  engine_.uc_stack.ss_size = stack_.size();
  makecontext(&engine_, engine, 0);
}

int64_t Bench::clocks(int64_t most) {
  most_ = most;
  passed_ = 0;
  vme_then_ = vme;
  lines_then_ = lines;
  swapcontext(&engine_, &simulator_);
  return passed_;
}

// swapcontext() is two calls of the kernel: as long as the rest of a clock.
int Bench::enter() {
  const bool same = !((vme ^ vme_then_) & kWatched) && lines == lines_then_;
  if (++passed_ < most_ && same) return result_;
  swapcontext(&simulator_, &engine_);
  return result_;
}

void Bench::put(Port port, int lsb, int width, uint64_t value) {
  for (int bit = 0; bit < width; ++bit) {
    uint32_t &word = ports_[port][(lsb + bit) / 32];
    const uint32_t mask = 1u << (lsb + bit) % 32;
    word = value >> bit & 1 ? word | mask : word & ~mask;
  }
}

}  // namespace mmcs

// Seen by the simulator, as the header of the engine is by its program.
#define MMCS_SEEN __attribute__((visibility("default")))

extern "C" MMCS_SEEN int mmcs_dpi_clock(uint32_t vme, uint32_t lines, const uint32_t *drive,
                                        const uint32_t *leds, uint64_t *bus, uint32_t *safety,
                                        uint32_t *encoder, uint32_t *switches, uint32_t *adc) {
  using namespace mmcs;
  Bench &bench = Bench::only();
  bench.vme = vme;
  bench.lines = lines;
  std::copy_n(drive, MMCS_DPI_AXIS_WORDS, bench.drive);
  std::copy_n(leds, MMCS_DPI_LED_WORDS, bench.leds);
  const int result = bench.enter();
  const auto at = [&bench](Port port, int bit) { return bench.level(port) << bit; };
  *bus = at(kVmeD, 0) | at(kVmeA, MMCS_DPI_A) | at(kVmeAm, MMCS_DPI_AM) | at(kVmeAs, MMCS_DPI_AS) |
         at(kVmeDs, MMCS_DPI_DS) | at(kVmeWrite, MMCS_DPI_WRITE) | at(kVmeLword, MMCS_DPI_LWORD) |
         at(kVmeIack, MMCS_DPI_IACK) | at(kVmeIackin, MMCS_DPI_IACKIN) |
         at(kVmeSysreset, MMCS_DPI_SYSRESET);
  *safety =
      static_cast<uint32_t>(at(kEstopClosed, MMCS_DPI_ESTOP_CLOSED) |
                            at(kCableOk, MMCS_DPI_CABLE_OK) | at(kPcPower, MMCS_DPI_PC_POWER));
  for (int n = 0; n < 3; ++n) encoder[n] = bench.words(static_cast<Port>(kEncA + n))[0];
  switches[0] = bench.words(kAxisEnable)[0];
  std::copy_n(bench.words(kDip), 2, switches + 1);
  std::copy_n(bench.words(kAdc), MMCS_DPI_AXIS_WORDS, adc);
  return result;
}
