// SPDX-License-Identifier: Apache-2.0
// Prints how long one 50 us step takes, for six axes alone and for the arm. Not a test: `make` runs
// no timed tests. Build it like them, see docs/simulator/plant.md.
#include <chrono>
#include <cstdio>

#include "bench.h"

namespace {

double microseconds_per_step(mmcs::Plant &plant, double volts) {
  constexpr int kSteps = 200000;
  std::vector<mmcs::PinEdge> edges;
  double drive[6];
  double best = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kSteps; ++k) {
      const double sign = k / 4000 % 2 == 0 ? 1.0 : -1.0;  // to and fro, 0.2 s each way
      for (double &v : drive) v = sign * volts;
      plant.step(drive, true, true, edges);
    }
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
    best = std::min(best, time.count() / kSteps);
  }
  return best;
}

}  // namespace

int main() {
  auto alone =
      mmcs::Plant::create(bench::config(6), robots::puma560, nullptr, bench::kClks, bench::kGap);
  auto arm = bench::puma_arm(bench::puma_rotors());
  for (const double volts : {0.0, 2.0, 6.0}) {
    std::printf("drive %g V: six axes %.2f us, arm %.2f us per step\n", volts,
                microseconds_per_step(*alone, volts), microseconds_per_step(*arm, volts));
  }
}
