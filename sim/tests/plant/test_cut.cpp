// SPDX-License-Identifier: Apache-2.0
// Motors that PANIC cuts off their amplifiers.
#include "bench.h"
#include "check.h"

// i = -km w / R: the speed falls by km^2 h / (R J) in a step, whatever the amplifier does.
TEST(motor_that_is_cut_off_and_shorted) {
  mmcs_motor m = bench::ideal();
  m.v_supply = 40.0;
  for (int way : {1, 2, 3}) {
    mmcs_config c = bench::config(1);
    c.amp_panic_cut = way;
    auto plant = mmcs::Plant::create(c, &m, nullptr, bench::kClks, bench::kGap);
    std::vector<mmcs::PinEdge> edges;
    const double volts = 5.0;
    for (int k = 0; k < 200; ++k) plant->step(&volts, true, true, edges);
    const double before = plant->velocity(0);
    for (int k = 0; k < 400; ++k) plant->step(&volts, true, false, edges);
    const double step = 1.0 - m.km * m.km * bench::kStepS / (m.resistance * m.inertia);
    const double share = way == 3 ? std::pow(step, 400) : 1.0;
    CHECK(std::abs(plant->velocity(0) / before - share) < 1e-9, "%d: %.15g", way,
          plant->velocity(0) / before);
  }
}
