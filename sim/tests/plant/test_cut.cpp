// SPDX-License-Identifier: Apache-2.0
// Motors that PANIC cuts off their amplifiers.
#include "bench.h"
#include "check.h"

TEST(motor_that_is_cut_off_coasts) {
  mmcs_motor m = bench::ideal();
  m.v_supply = 40.0;
  auto plant = mmcs::Plant::create(bench::config(1), &m, nullptr, bench::kClks, bench::kGap);
  std::vector<mmcs::PinEdge> edges;
  const double volts = 5.0;
  for (int k = 0; k < 200; ++k) plant->step(&volts, true, true, edges);
  const double before = plant->velocity(0);
  for (int k = 0; k < 400; ++k) plant->step(&volts, true, false, edges);
  CHECK(std::abs(plant->velocity(0) / before - 1.0) < 1e-9, "%.15g", plant->velocity(0) / before);
}
