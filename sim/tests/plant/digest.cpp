// SPDX-License-Identifier: Apache-2.0
// Prints a digest of everything that an arm and a row of axes do under a busy drive while each
// input of the plant is set for 20 ms in turn.
#include <cstddef>
#include <cstdio>
#include <cstring>

#include "axis.h"
#include "bench.h"
#include "maths.h"

namespace {

uint64_t run(mmcs::Plant &plant, int steps) {
  uint64_t digest = 0xCBF29CE484222325u;
  const auto add = [&digest](uint64_t word) { digest = (digest ^ word) * 0x100000001B3u; };
  plant.set_input(bench::input("pot_noise"), -1, 0.01);
  plant.set_input(bench::input("encoder_glitch"), 2, 300.0);
  plant.set_input(bench::input("load_torque"), 1, 0.03);
  std::vector<double> drive(static_cast<size_t>(plant.axes()));
  std::vector<mmcs::PinEdge> edges;
  uint64_t random = 5;
  int inputs = 0, input = 0, axis = 0;
  while (mmcs::Plant::input_name(inputs) != nullptr) ++inputs;
  for (int k = 0; k < steps; ++k) {
    if (k % 400 == 0) {
      plant.set_input(input, axis, 0.0);
      input = k / 400 % inputs;
      axis = k / 400 % plant.axes();
      plant.set_input(input, axis, k / 400 / inputs % 2 + 1.0);
      for (double &v : drive) v = 12.0 * (mmcs::random_unit(random) - 0.5);
    }
    if (k % 20000 == 10000) {  // of what a speed of before has calculated nothing may be kept
      auto still = plant.save();
      std::memset(&still[offsetof(mmcs::AxisState, qd)], 0, sizeof(double));
      plant.restore(still);
    }
    plant.step(drive.data(), k % 6000 < 5000, k % 7000 < 6500, edges);
    for (const auto &e : edges) {
      add(static_cast<uint64_t>(e.clk) << 16 | static_cast<uint64_t>(e.axis) << 8 |
          static_cast<uint64_t>(e.a | e.b << 1 | e.i << 2));
    }
  }
  for (uint8_t byte : plant.save()) add(byte);
  return digest;
}

}  // namespace

int main() {
  auto motors = bench::puma_rotors();
  motors[2].encoder_offset = -0.3;  // of the disc on the shaft
  motors[3].index_per_rev = 0;
  motors[4].stiffness = 50.0;
  motors[4].backlash = 0.002;
  motors[4].load_inertia = 0.2;
  auto arm = bench::puma_arm(motors);
  auto alone =
      mmcs::Plant::create(bench::config(6), motors.data(), nullptr, bench::kClks, bench::kGap);
  auto five = mmcs::Plant::create(bench::config(5, 5), motors.data(), robots::puma560_links,
                                  bench::kClks, bench::kGap);  // the last pair of joints is half
  for (auto *plant : {&arm, &alone, &five})
    std::printf("%016llx\n", static_cast<unsigned long long>(run(**plant, 100000)));
}
